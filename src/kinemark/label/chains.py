"""Chains of whole markers that have all moved up one place, moved back as one.

Where a marker sits far from where the template foretells it, its neighbour can take its name, the next one the
neighbour's, and so on to a label that is absent: each name is wrong, and each supports the next, so that no marker
alone would change. So a marker that does not lie where its name should takes another's name, the one that had it takes
the next, and so on, each time the few by which the places gain most, or the two change places,

    gain of a step = e3(m, a) − e3(m', a)   where m' had a,   e3(m, a) + 10   where no marker had it,            (1)

with e3 the mean of `shape` (2), by the names that are left. The best of these labellings are scored anew as wholes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints

STARTS = 4
"""Markers from which chains begin, those that fit worst; chosen."""
LONGEST = 6
"""Names that change hands in a chain, at most; chosen: the spine of the largest set has five."""
EACH, BEAM = 3, 2
"""Names that a marker tries, and chains that go on; chosen."""
PASSES = 4
"""Chains that are moved one after the other, at most; chosen."""
TRIED, EXCHANGED = 12, 3
"""Chains from one marker, and its exchanges with another, that are scored as wholes, those that gain most; chosen: of
three the right one was none, as four names lose by its third step."""

Nats = Callable[[Ints], Floats]
"""(M, L) of markers as labels, where the labels of markers (M) are these."""
Score = Callable[[Ints], float]
"""Nats of a labelling (M)."""


class Chain(NamedTuple):
    """A labelling (M) on its way: what it gained, nats; the marker without name, −1 for none; (L) names given."""

    gain: float
    label: Ints
    hand: int
    given: Bools


def rechained(now: Ints, nats: Nats, rough: Score, score: Score, *, least: float, absent: float) -> Ints:
    """(M) labels after the best chains, one after the other, or as they were where none scores better.

    Args:
        now: (M) −1 for none. nats: of markers as labels. rough: chooses among the chains of a marker. score: judges
            what it chose. least: nats of a marker under its own name up to which a chain begins at it. absent: what a
            label without a marker costs, nats.
    """
    for _ in range(PASSES):
        new = _once(now, nats, rough, score, least, absent)
        if (new == now).all():
            break
        now = new
    return now


def _once(now: Ints, nats: Nats, rough: Score, score: Score, least: float, absent: float) -> Ints:
    """(M) labels after the best chain."""
    worth = nats(now)
    own = worth[np.arange(len(now)), np.maximum(now, 0)]
    fit = np.where(now < 0, np.finfo(float).min, np.where(np.isfinite(own), own, np.inf))
    starts = [m for m in np.argsort(fit, kind="stable")[:STARTS].tolist() if fit[m] <= least]
    best, most = now, score(now) if starts else 0.0
    for start in starts:
        chains = sorted(_ends(now, start, worth.shape[1], nats, absent), key=lambda one: -one.gain)[:TRIED]
        tried = (*(chain.label for chain in chains), *_exchanged(now, start, worth, absent))
        label = max(tried, key=rough, default=now)
        total = score(label)
        if total > most + 1e-6:
            best, most = label, total
    return best


def _exchanged(now: Ints, start: int, worth: Floats, absent: float) -> list[Ints]:
    """(M) labellings in which a marker and another have each other's name, those of the greatest worth (M, L)."""
    named = np.flatnonzero((now >= 0) & (np.arange(len(now)) != start))
    if now[start] < 0:
        return []
    both = worth[start, now[named]] + worth[named, now[start]] - np.maximum(worth[named, now[named]], -absent)
    out = []
    for other in named[np.argsort(-np.where(np.isfinite(both), both, -np.inf), kind="stable")[:EXCHANGED]]:
        label = now.copy()
        label[[start, other]] = now[[other, start]]
        out.append(label)
    return out


def _ends(now: Ints, start: int, L: int, nats: Nats, absent: float) -> list[Chain]:
    """The chains that begin at a marker, of each length, among L names."""
    first = now.copy()
    first[start] = -1
    going, ends = [Chain(0.0, first, start, np.zeros(L, bool))], []
    for _ in range(LONGEST):
        steps = [step for one in going for step in _steps(now, one, nats, absent)]
        ends += steps
        going = sorted((step for step in steps if step.hand >= 0), key=lambda one: -one.gain)[:BEAM]
        if not going:
            break
    return ends


def _steps(now: Ints, one: Chain, nats: Nats, absent: float) -> list[Chain]:
    """The best names for the marker without one, other than its own in `now`."""
    worth = nats(one.label)
    every, holder = np.arange(worth.shape[1]), np.full(worth.shape[1], -1)
    holder[one.label[one.label >= 0]] = np.flatnonzero(one.label >= 0)
    lost = np.where(holder >= 0, worth[holder, every], -absent)
    free = ~one.given & (every != now[one.hand]) & np.isfinite(worth[one.hand])
    gain = np.where(free, worth[one.hand] - np.where(free, lost, 0.0), -np.inf)
    out = []
    for a in np.argsort(-gain, kind="stable")[:EACH].tolist():
        if free[a]:
            label, had = one.label.copy(), int(holder[a])
            label[one.hand] = a
            if had >= 0:
                label[had] = -1
            out.append(Chain(one.gain + float(gain[a]), label, had, one.given | (every == a)))
    return out
