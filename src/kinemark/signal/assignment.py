"""Assignment of rows to columns: at the least total cost, or the cheapest pair first."""

from __future__ import annotations

import numpy as np
import scipy

from ..data.array_types import Floats, Ints


def assign(cost: Floats, limit: Floats) -> tuple[Ints, Ints]:
    """Rows and columns that go together, with cost (n, m) at most limit (n), as many and as cheap as can be.

    A pair beyond its limit costs more than all allowed ones together, so it is only taken where nothing else is left,
    and then given back.
    """
    allowed = cost <= limit[:, None]
    if not allowed.any():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    forbidden = 1.0 + cost[allowed].sum()
    rows, columns = scipy.optimize.linear_sum_assignment(np.where(allowed, cost, forbidden))
    good = allowed[rows, columns]
    return rows[good], columns[good]


def assign_nearest(cost: Floats, limit: Floats) -> tuple[Ints, Ints]:
    """Rows and columns that go together, the cheapest of all first, with cost (n, m) at most limit (n)."""
    row, column = np.nonzero(cost <= limit[:, None])
    return cheapest_first(row, column, cost[row, column])


def cheapest_first(row: Ints, column: Ints, cost: Floats) -> tuple[Ints, Ints]:
    """Of possible pairs (K) those taken where the cheapest goes first and each row and column once; ties: the first."""
    order = np.argsort(cost, kind="stable")
    rows: dict[int, int] = {}
    taken: set[int] = set()
    for i, j in zip(row[order].tolist(), column[order].tolist(), strict=True):
        if i not in rows and j not in taken:
            rows[i] = j
            taken.add(j)
    return np.array(list(rows), np.int64), np.array(list(rows.values()), np.int64)
