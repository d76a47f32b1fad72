"""Names for all tracks, from one labelled frame: outwards in time, then in sweeps until nothing changes.

The evidence that track t is label a is the mean over its frames k of

    e(t, a) = ‹ Σ_b l(|x_t − y_b|; D_ab, σ_ab) ›_k                                                               (1)

over all labelled neighbours b, with l of `evidence` (1) and y_b the place of the track that is b in that frame. A track
takes the label with the most of w_t e(t, a) + c(t, a), where w_t counts its independent frames and c says how well its
ends meet those of the label's own tracks before and after; tracks seen at the same time take labels together, as one
assignment, and one that no label explains better than chance stays unnamed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats, Ints
from ..numerics.evenly import evenly_rounded
from .evidence import PairScore, Single, distances
from .stretches import FREE, Stretches

NONE = -1
"""The label of a track without one; by definition."""
GOES_ON = 10.0
"""Nats from which on a track goes on as another marker's, and half of it as no other's; chosen: pieces that were
cut from a marker have more, ghosts that pass by less."""


def places(stretches: Stretches, label: Ints, L: int) -> Single:
    """(K, L, 3) where each label is in each frame; NaN where no track is it."""
    out = np.full((len(stretches.frame), L, 3), np.nan, np.float32)
    t, k = np.nonzero(np.isfinite(stretches.xyz[..., 0]) & (label >= 0)[:, None])
    out[k, label[t]] = stretches.xyz[t, k]
    return out


def evidence(stretches: Stretches, label: Ints, pairs: PairScore) -> Floats:
    """(T, L) nats (1) of each track as each label, by all that is labelled."""
    L = len(pairs.distance)
    labelled = places(stretches, label, L)
    total, count = np.zeros((len(stretches), L)), np.zeros(len(stretches))
    for k in range(len(stretches.frame)):
        here = np.flatnonzero(np.isfinite(stretches.xyz[:, k, 0]))
        total[here] += pairs.of_points(stretches.xyz[here, k], labelled[k], label[here])
        count[here] += 1
    return total / np.maximum(count, 1)[:, None]


def continuity(stretches: Stretches, label: Ints, L: int, tracks: Ints | None = None) -> Floats:
    """(T, L) nats: how well a track goes on from, and into, the tracks that have each label now; of some tracks."""
    tracks = np.arange(len(stretches)) if tracks is None else tracks
    return _of_neighbours(stretches.into, label, L, tracks) + _of_neighbours(stretches.link, label, L, tracks)


def _of_neighbours(link: scipy.sparse.csr_array, label: Ints, L: int, tracks: Ints) -> Floats:
    """(n, L) nats of rows of tracks, those of columns with the same label added up; SciPy's product takes its time."""
    first, n = link.indptr[tracks], link.indptr[tracks + 1] - link.indptr[tracks]
    at = np.arange(n.sum()) + np.repeat(first - np.cumsum(n) + n, n)
    cell = np.repeat(np.arange(len(tracks)) * (L + 1) + 1, n) + label[link.indices[at]]  # the first is of no label
    total = np.bincount(cell, link.data[at], len(tracks) * (L + 1))
    return np.asarray(total.reshape(-1, L + 1)[:, 1:], np.float64)


@dataclass
class Decided:
    """What has been decided: the label of each track, and in which frames a label is taken."""

    label: Ints
    taken: NDArray[np.bool_]

    @classmethod
    def nothing(cls, stretches: Stretches, L: int) -> Decided:
        """No track has a label, but those of which one was stated."""
        found = cls(np.full(len(stretches), NONE), np.zeros((L, stretches.seen.shape[1]), bool))
        stated = np.flatnonzero(stretches.fixed >= 0)
        found.give(stretches, stated, stretches.fixed[stated])
        return found

    def give(self, stretches: Stretches, tracks: Ints, labels: Ints) -> None:
        """These tracks take these labels."""
        self.label[tracks] = labels
        for t, a in zip(tracks.tolist(), labels.tolist(), strict=True):
            self.taken[a, stretches.start[t] : stretches.stop[t]] |= stretches.seen[
                t, stretches.start[t] : stretches.stop[t]
            ]

    def free(self, stretches: Stretches, tracks: Ints) -> NDArray[np.bool_]:
        """(n, L) whether a label is free wherever a track is seen."""
        lo, hi = stretches.start[tracks].min(), stretches.stop[tracks].max()
        seen, taken = (some.astype(np.float32) for some in (stretches.seen[tracks, lo:hi], self.taken[:, lo:hi].T))
        with np.errstate(invalid="ignore"):  # all are 0 or 1; BLAS may flag what it reads beyond them, and throws away
            both = seen @ taken
        return both == 0

    def assign(self, stretches: Stretches, tracks: Ints, score: Floats) -> None:
        """Tracks (n) seen together take free labels, with the greatest sum of scores (n, L) above 0."""
        open_ = self.free(stretches, tracks) & (stretches.fixed[tracks] == FREE)[:, None]
        gain = np.where(open_, np.maximum(score, 0.0), 0.0)
        rows, columns = scipy.optimize.linear_sum_assignment(-gain)
        good = gain[rows, columns] > 0
        self.give(stretches, tracks[rows[good]], columns[good])


def outwards(stretches: Stretches, key: int, tracks: Ints, labels: Ints, pairs: PairScore) -> Ints:
    """(T) labels from those of some tracks in key frame `key`, first forwards, then backwards in time."""
    L, K = len(pairs.distance), len(stretches.frame)
    done = Decided.nothing(stretches, L)
    done.give(stretches, tracks, labels)
    for k in [*range(key + 1, K), *range(key - 1, -1, -1)]:
        here = np.flatnonzero(np.isfinite(stretches.xyz[:, k, 0]))
        new = here[done.label[here] < 0]
        old = here[done.label[here] >= 0]
        if not len(new) or not len(old):
            continue
        labelled = np.full((L, 3), np.nan, np.float32)
        labelled[done.label[old]] = stretches.xyz[old, k]
        nats = pairs.of_points(stretches.xyz[new, k], labelled, np.full(len(new), NONE))
        done.assign(stretches, new, nats + continuity(stretches, done.label, L, new))
    return done.label


def sweep(stretches: Stretches, label: Ints, pairs: PairScore, least_fit: float, *, take_over: bool = False) -> Ints:
    """(T) labels decided anew by the evidence of the present ones; none below `least_fit` of what is expected.

    But where a track goes on as the label's own: a posture that is new for a moment is no other marker.

    Args:
        take_over: tracks that are left without a label then take those of tracks that score less; see `_taken_over`.
    """
    nats = evidence(stretches, label, pairs)
    goes_on = continuity(stretches, label, nats.shape[1])
    score = stretches.weight[:, None] * nats + goes_on
    off = (nats < least_fit * expectation(stretches, label, pairs)) & (goes_on < GOES_ON)
    score = np.where(off, 0.0, score)
    done = Decided.nothing(stretches, score.shape[1])
    waiting = stretches.stop > stretches.start
    best = score.max(1)
    waiting &= best > 0
    load = np.where(waiting, best, 0.0)
    while waiting.any():
        first = int(load.argmax())
        middle = _fullest(stretches, waiting, first)
        batch = np.flatnonzero(waiting & stretches.seen[:, middle])
        done.assign(stretches, batch, score[batch])
        waiting[batch], load[batch] = False, 0.0
    return _taken_over(stretches, done.label, score) if take_over else done.label


def _taken_over(stretches: Stretches, label: Ints, score: Floats) -> Ints:
    """(T) labels after tracks without one took those of tracks whose scores (T, L) are less in the sum.

    Tracks are named by the frame in which most are seen, so that one that had begun, a ghost beside a marker, may have
    taken the label of one that scores more. What lost its label may take another's, or is named by the next sweep.
    """
    waiting = np.flatnonzero((label < 0) & (stretches.fixed == FREE) & (score.max(1) > 0)).tolist()
    while waiting:  # ends, as the sum of scores rises each time that a label changes hands
        u = waiting.pop()
        meets = (stretches.start < stretches.stop[u]) & (stretches.stop > stretches.start[u]) & (label >= 0)
        others = np.flatnonzero(meets)
        others = others[(stretches.seen[others] & stretches.seen[u]).any(1)]
        held = np.bincount(label[others], score[others, label[others]], score.shape[1])
        held[label[others[stretches.fixed[others] != FREE]]] = np.inf
        gain = np.where(score[u] > 0, score[u] - held, 0.0)
        a = int(gain.argmax())
        if gain[a] > 0:
            out = others[label[others] == a]
            label[out], label[u] = NONE, a
            waiting += out.tolist()
    return label


def expectation(stretches: Stretches, label: Ints, pairs: PairScore) -> Floats:
    """(T, L) nats that the evidence of each track as each label is where the template holds.

    From as many neighbours as are seen with that track: where few cameras see a part of the body, few are.
    """
    present = np.isfinite(places(stretches, label, len(pairs.distance))[..., 0]).astype(float)
    own = np.isfinite(stretches.xyz[..., 0]).astype(float)
    return np.asarray((own @ present / np.maximum(own.sum(1), 1)[:, None]) @ pairs.expected)


def total_score(stretches: Stretches, label: Ints, pairs: PairScore) -> tuple[float, float]:
    """Nats a frame of all pairs of labelled tracks, and what the template expects of as many."""
    L = len(pairs.distance)
    labelled, every = places(stretches, label, L), np.arange(L)
    some = evenly_rounded(len(labelled), 40)
    total = expected = 0.0
    for y in labelled[some]:
        seen = np.isfinite(y[:, 0])
        total += float(pairs.at(distances(y, y), every[:, None], every[None]).sum()) / 2
        total += pairs.hands.total(y) if pairs.hands is not None else 0.0
        expected += float(pairs.expected[np.ix_(seen, seen)].sum()) / 2
    return total / max(len(some), 1), expected / max(len(some), 1)


def _fullest(stretches: Stretches, waiting: NDArray[np.bool_], track: int) -> int:
    """The frame of a track in which most of those that wait are seen."""
    own = np.flatnonzero(stretches.seen[track])
    own = own[:: max(1, len(own) // 20)]
    return int(own[stretches.seen[np.ix_(waiting, own)].sum(0).argmax()])
