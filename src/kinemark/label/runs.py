"""Runs of pieces in which two or three markers have each other's names, put right as wholes.

Short pieces hold each other by motion: each goes on well from those before and after that have the same wrong name, so
that none changes alone though distances say so. So of two or three near labels all pieces between two moments, at which
no piece of any is under way, change names together, label a to π(a). With g_k the nats that frame k gains by it
(`exchange` (1)), W the independent frames of the run, and of each of its ends the last piece a of each label before it
and the first one a' after it, that gains

    G = W ‹ g_k ›_k + Σ_a [ c(π(a), a') − c(a, a') ] where it begins + Σ_a [ c(a, π(a)') − c(a, a') ] where it ends (1)

with c how well one piece goes on as another. Each run of the greatest G is exchanged while that is clearly above 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints
from .exchange import Exchanger
from .stretches import Stretches
from .sweeps import places

CLEARLY = 8.0
"""Nats (1) that an exchange must gain; chosen, as sides must that are not undecided."""
MOVES = 30
"""At most, the best first, as each changes what the others gain; chosen, as in `exchange`."""


class Run(NamedTuple):
    """From a frame on, and up to another, labels are exchanged; what that gains, nats."""

    gain: float
    start: int
    stop: int


NOTHING = Run(0.0, 0, 0)
"""Where no moment parts a trial; by definition."""


def runs_put_right(stretches: Stretches, label: Ints, exchanger: Exchanger) -> Ints:
    """(T) labels after runs in which two or three near ones were exchanged.

    Args:
        label: (T) −1 for none. exchanger: of the template, and by what is known after the trial.
    """
    L = len(exchanger.pairs.distance)
    pieces, some = np.bincount(label[label >= 0], minlength=L), exchanger.keeping(stretches.fixed)
    moves = [move for move in (*some.twos, *some.threes) if pieces[list(move[0])].sum() > len(move[0])]
    every = np.arange(L)
    for _ in range(MOVES):
        gains, best, turn = exchanger.of_frames(places(stretches, label, L), moves), NOTHING, every
        for gain, (was, to) in zip(gains, moves, strict=True):
            if (gain > 0).any():
                new = every.copy()
                new[list(was)] = to
                one = best_run(stretches, label, np.flatnonzero(np.isin(label, was)), gain, new)
                best, turn = (one, new) if one.gain > best.gain else (best, turn)
        if best.gain <= CLEARLY:
            break
        of = (label >= 0) & (stretches.start >= best.start) & (stretches.stop <= best.stop)
        label = np.where(of, turn[label], label)
    return label


def best_run(stretches: Stretches, label: Ints, own: Ints, gain: Floats, new: Ints) -> Run:
    """The run of the greatest gain (1) of the pieces `own` of labels that become `new` (L), (K) nats of each frame."""
    F = stretches.seen.shape[1]
    start, stop = stretches.start[own], stretches.stop[own]
    ends = np.unique([0, *start.tolist(), F])
    ends = ends[~((start[:, None] < ends) & (ends < stop[:, None])).any(0)]
    if len(ends) < 3:
        return NOTHING
    begins, stops = np.zeros((2, len(ends)))
    for k, f in enumerate(ends[1:-1].tolist(), 1):
        begins[k], stops[k] = _crossed(stretches, label, own, f, new)
    order = np.argsort(start, kind="stable")
    poses = _up_to(stretches.weight[own][order] - 1.0, np.searchsorted(start[order], ends)) / 2
    row = np.searchsorted(stretches.frame, ends)
    total, count = _up_to(gain, row), _up_to((gain != 0).astype(float), row)
    mean = (total - total[:, None]) / np.maximum(count - count[:, None], 1.0)
    G = (1.0 + poses - poses[:, None]) * mean + begins[:, None] + stops
    G[np.tri(len(ends), dtype=bool)] = G[0, -1] = -np.inf  # the whole trial is for `exchange`
    i, j = np.unravel_index(int(G.argmax()), G.shape)
    return Run(float(G[i, j]), int(ends[i]), int(ends[j]))


def _up_to(values: Floats, row: Ints) -> Floats:
    """Sums of values before each of some rows."""
    return np.asarray(np.concatenate([[0.0], np.cumsum(values)])[row])


def _crossed(stretches: Stretches, label: Ints, own: Ints, at: int, new: Ints) -> tuple[float, float]:
    """Nats that motion gains where labels become `new` from a frame on, and where they do so up to it."""
    before, after = own[stretches.stop[own] <= at], own[stretches.start[own] >= at]
    last = {
        int(a): of[stretches.stop[of].argmax()] for a in np.unique(label[own]) if len(of := before[label[before] == a])
    }
    first = {
        int(a): of[stretches.start[of].argmin()] for a in np.unique(label[own]) if len(of := after[label[after] == a])
    }

    def goes_on(a: int, b: int) -> float:
        return float(stretches.link[last[a], first[b]]) if a in last and b in first else 0.0

    straight = sum(goes_on(a, a) for a in first)
    return sum(goes_on(int(new[a]), a) for a in first) - straight, sum(goes_on(a, int(new[a])) for a in last) - straight
