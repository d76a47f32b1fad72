"""Runs of pieces in which two markers have each other's names, put right as wholes.

Short pieces hold each other by motion: each goes on well from those before and after that have the same wrong name, so
that none changes alone though distances say so. So of two near labels all pieces between two moments, at which no piece
of either is under way, change names together. With g_k the nats that frame k gains by it (`exchange` (1)), W the
independent frames of the run, and of each of its ends the last pieces a, b before it and the first ones a', b' after
it, that gains

    G = W ‹ g_k ›_k + Σ over both ends of  c(a, b') + c(b, a') − c(a, a') − c(b, b')                              (1)

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
ROUNDS = 3
"""In which all pairs are looked at; chosen: what hid behind one exchange is found the second time."""


class Run(NamedTuple):
    """From a frame on, and up to another, two labels are exchanged; what that gains, nats."""

    gain: float
    start: int
    stop: int


NOTHING = Run(0.0, 0, 0)
"""Where no moment parts a trial; by definition."""


def runs_put_right(stretches: Stretches, label: Ints, exchanger: Exchanger) -> Ints:
    """(T) labels after runs in which two near ones were exchanged.

    Args:
        label: (T) −1 for none. exchanger: of the template, and by what is known after the trial.
    """
    L = len(exchanger.pairs.distance)
    pieces = np.bincount(label[label >= 0], minlength=L)
    moves = [move for move in exchanger.keeping(stretches.fixed).twos if pieces[list(move[0])].sum() > 2]
    for _ in range(ROUNDS):
        gains, before = exchanger.of_frames(places(stretches, label, L), moves), label
        for gain, (two, _) in zip(gains, moves, strict=True):
            own = np.flatnonzero(np.isin(label, two))
            best = best_run(stretches, label, own, gain) if (gain > 0).any() else NOTHING
            if best.gain > CLEARLY:
                of = own[(stretches.start[own] >= best.start) & (stretches.stop[own] <= best.stop)]
                label = np.array(label)
                label[of] = sum(two) - label[of]
        if (label == before).all():
            break
    return label


def best_run(stretches: Stretches, label: Ints, own: Ints, gain: Floats) -> Run:
    """The run of the greatest gain (1) of the pieces `own` of two labels, (K) nats of each frame."""
    F = stretches.seen.shape[1]
    start, stop = stretches.start[own], stretches.stop[own]
    ends = np.unique([0, *start.tolist(), F])
    ends = ends[~((start[:, None] < ends) & (ends < stop[:, None])).any(0)]
    if len(ends) < 3:
        return NOTHING
    cross = np.array([0.0, *(_crossed(stretches, label, own, int(f)) for f in ends[1:-1]), 0.0])
    order = np.argsort(start, kind="stable")
    poses = _up_to(stretches.weight[own][order] - 1.0, np.searchsorted(start[order], ends)) / 2
    row = np.searchsorted(stretches.frame, ends)
    total, count = _up_to(gain, row), _up_to((gain != 0).astype(float), row)
    mean = (total - total[:, None]) / np.maximum(count - count[:, None], 1.0)
    G = (1.0 + poses - poses[:, None]) * mean + cross + cross[:, None]
    G[np.tri(len(ends), dtype=bool)] = G[0, -1] = -np.inf  # the whole trial is for `exchange`
    i, j = np.unravel_index(int(G.argmax()), G.shape)
    return Run(float(G[i, j]), int(ends[i]), int(ends[j]))


def _up_to(values: Floats, row: Ints) -> Floats:
    """Sums of values before each of some rows."""
    return np.asarray(np.concatenate([[0.0], np.cumsum(values)])[row])


def _crossed(stretches: Stretches, label: Ints, own: Ints, at: int) -> float:
    """Nats that motion gains where two labels are exchanged from a frame on."""
    before, after = own[stretches.stop[own] <= at], own[stretches.start[own] >= at]
    nats = 0.0
    for a in np.unique(label[before]):
        for b in np.unique(label[after]):
            was, new = before[label[before] == a], after[label[after] == b]
            last, first = was[stretches.stop[was].argmax()], new[stretches.start[new].argmin()]
            nats += float(stretches.link[last, first]) * (1.0 if a != b else -1.0)
    return nats
