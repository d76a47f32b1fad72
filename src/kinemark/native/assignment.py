"""Assignment of rows to columns at the least sum of costs, each at most once, by shortest augmenting paths.

Rows are taken in turn; each goes to the free column that is nearest in costs reduced by the prices of rows and columns,
over rows that then take another one (Jonker & Volgenant 1987, "A shortest augmenting path algorithm for dense and
sparse linear assignment problems"; for tables that are not square Crouse 2016, "On implementing 2D rectangular
assignment algorithms"). Without a compiled library SciPy does the same.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .array_checks import FLOAT, INT, Arrays
from .compiled_library import library

_COST = Arrays(cost=(FLOAT, "n", "m"))
_PAIRS = Arrays(start=(INT, "S"), a=(INT, "K"), b=(INT, "K"), score=(FLOAT, "K"))


def assign(cost: Floats, *, maximize: bool = False) -> tuple[Ints, Ints]:
    """Rows, rising, and columns that go together, as many as can be, at the least sum of costs, or the greatest.

    Args:
        cost: (n, m) finite numbers.
        maximize: the greatest sum is wanted.

    Raises:
        ValueError: `cost` has another shape or dtype, or a number in it is not finite.
    """
    (cost,) = _COST(cost)
    if not np.isfinite(cost).all():
        raise ValueError("cost has numbers that are not finite")
    if (compiled := library()) is None:
        return _of_scipy(cost, maximize)
    turned = cost.shape[0] > cost.shape[1]
    table = np.ascontiguousarray(cost.T if turned else cost)
    (n, m), whole = table.shape, np.empty(2 * sum(table.shape) + 2 * table.shape[1], np.int64)
    compiled.assign(n, m, -table if maximize else table, np.empty(n + 2 * m), whole)
    columns = whole[:n].copy()
    if not turned:
        return np.arange(n), columns
    order = np.argsort(columns)
    return columns[order], order


def assign_pairs(start: Ints, a: Ints, b: Ints, score: Floats) -> Bools:
    """(K) which of K pairs have the greatest sum of scores, no a and no b twice, in each of G groups by itself.

    Args:
        start: (G+1) where each group starts among the pairs; the last is K.
        a: (K) what goes with b; no pair is twice in a group.
        b: (K).
        score: (K) finite and positive.

    Raises:
        ValueError: an array has another shape or dtype, groups do not follow each other, or a score is not finite and
            positive.
    """
    start, a, b, score = _PAIRS(start, a, b, score)
    size = np.diff(start)
    if not len(start) or start[0] != 0 or start[-1] != len(a) or (size < 0).any():
        raise ValueError(f"start does not go from 0 to {len(a)}, rising")
    if not ((score > 0) & (score < np.inf)).all():
        raise ValueError("score has numbers that are not finite and positive")
    if (compiled := library()) is None:
        return _pairs_of_scipy(start, a, b, score)
    most, chosen, room = int(size.max(initial=0)), np.zeros(len(a), bool), 0
    work = np.empty(3 * most), np.empty(10 * most, np.int64)
    wanted = 4 * most
    while wanted > room:
        room = wanted
        wanted = compiled.assign_pairs(len(size), len(a), most, room, start, a, b, score, np.empty(room), *work, chosen)
    return chosen


def _of_scipy(cost: Floats, maximize: bool) -> tuple[Ints, Ints]:
    import scipy  # only where there is no compiled library, and no command may wait for it

    return scipy.optimize.linear_sum_assignment(cost, maximize=maximize)


def _pairs_of_scipy(start: Ints, a: Ints, b: Ints, score: Floats) -> Bools:
    chosen = np.zeros(len(a), bool)
    for first, end in zip(start[:-1].tolist(), start[1:].tolist(), strict=True):
        (rows, i), (columns, j) = (_in_order(part[first:end].tolist()) for part in (a, b))
        gain, which = np.zeros((rows, columns)), np.full((rows, columns), -1)
        gain[i, j], which[i, j] = score[first:end], np.arange(first, end)
        taken = which[_of_scipy(gain, True)]
        chosen[taken[taken >= 0]] = True
    return chosen


def _in_order(names: list[int]) -> tuple[int, list[int]]:
    """How many names there are, and which each is, counted as they come."""
    places = {name: k for k, name in enumerate(dict.fromkeys(names))}
    return len(places), [places[name] for name in names]
