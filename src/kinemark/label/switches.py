"""Where tracks go over from one marker to another.

What a sample of a track tells of each label is e_k(t, a), (1) of `sweeps` for a single frame k. A track that is a until
it is b has two stretches, so the best sequence of labels is sought where each change costs C:

    max over a_1 … a_K of  Σ_k e_k(t, a_k) − C · (number of changes)                                              (1)

Where another track u has the name b meanwhile, it must leave it, so that a change gains over its frames

    G = Σ_k [ e_k(t, b) − e_k(t, a) ] + max over c ≠ b of Σ_k [ e_k(u, c) − e_k(u, b) ]                           (2)

with "none" among the c, worth 0. A posture that is new pulls at single markers, but not at those whose places they
would take. A name that is free meanwhile has nobody to speak against it, so that twice as much is asked. Frames are
looked at 15 times a second; between two of them a change is placed by the evidence of every frame. Where two tracks
take each other's name, as after a gap that was filled from one marker to the other, both change in the same frame.

A track may also be a marker in a part of it alone, and go on as a merged point while the marker's own track begins
anew. "None" is among the a_k of (1) for that. For tracks without a name it is worth 0, and they are no label that
another track has meanwhile. For tracks with a name it is worth what the best track u without one gains as that label,
max over u of e_k(u, a), and nothing where there is no such u: the name stays where nobody else claims it.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats, Ints
from .evidence import PairScore, Single
from .stretches import FREE, Stretches, stretches_of
from .sweeps import expectation, places
from .template import Template

COST = 40.0
"""C of (1), nats; chosen on the tuned rows of benchmarks/labelling.py: no whole track is cut by it."""
IF_FREE = 2.0
"""How many times as much is asked where the name is free; chosen."""
FITS = 0.5
"""Least evidence of the new name, as a share of what the template expects; chosen."""
OTHERS = 0.5
"""Most that the other track may lose, as a share of what the first gains; chosen."""
TOGETHER_S = 0.25
"""Time between two changes that are one exchange, at most, s; chosen: tracks go over in a few frames."""
LEAST_ROWS = 3
"""Frames that are looked at, at least, in a part that alone is a marker, or none; chosen: among 20 further markers on a
body pieces of 0.1 s looked like others' (labelling_shreds.py, crowded), and they are soon gone anyway."""
HELD = 1e3
"""Nats a frame by which a nameless track is no label that another one has; chosen: more than any evidence."""


class Turn(NamedTuple):
    """A track is the label `was` before this row of the frames that are looked at, and `to` from there on."""

    row: int
    was: int
    to: int


def find_turns(tracks: Trajectories, label: Ints, template: Template, fixed: Ints) -> list[tuple[int, int, bool]]:
    """(track, frame) before which tracks should be cut, and whether they are none on one side.

    Args:
        tracks: T of a recording. label: (T) that they have, −1 for none. template: of the subject.
        fixed: (T) as `Stretches.fixed`; tracks of which a name was stated are not cut.
    """
    stretches, pairs = stretches_of(tracks, template.size), PairScore.of_template(template)
    nats = _with_none(frame_evidence(stretches, label, pairs), stretches, label)
    least = FITS * np.pad(expectation(stretches, label, pairs), ((0, 0), (0, 1)))
    found: list[tuple[int, int, Turn]] = []
    for t in np.flatnonzero(fixed == FREE).tolist():
        rows = np.flatnonzero(np.isfinite(stretches.xyz[t, :, 0]))
        turns = _turns(nats, t, rows, label, least[t]) if len(rows) > 1 else []
        found += [(t, _frame_of(tracks, stretches, t, turn, label, pairs), turn) for turn in turns]
    near, none = TOGETHER_S * tracks.rate, len(template)
    return [(t, _at_once(t, frame, turn, found, near), none in (turn.was, turn.to)) for t, frame, turn in found]


def _at_once(t: int, frame: int, turn: Turn, found: list[tuple[int, int, Turn]], near: float) -> int:
    """The frame of a change, or the middle of it and that of the track with which this one is exchanged."""
    other = [
        at for u, at, one in found if u != t and (one.was, one.to) == (turn.to, turn.was) and abs(at - frame) <= near
    ]
    return (frame + other[0]) // 2 if len(other) == 1 else frame


def _with_none(nats: Single, stretches: Stretches, label: Ints) -> Single:
    """(T, K, L + 1) nats (T, K, L) with those of "none"; of nameless tracks −∞ for labels that others have.

    Held is a label within the frames about a row, half of the way to its neighbours.
    """
    T, K, L = nats.shape
    out = np.concatenate([nats, np.zeros((T, K, 1), np.float32)], axis=2)
    holders = np.full((K, L), -np.inf, np.float32)
    held, claimed = np.zeros((L, stretches.seen.shape[1]), bool), np.zeros((K, L), np.float32)
    for t in range(T):
        if label[t] >= 0:
            held[label[t]] |= stretches.seen[t]
            holders[:, label[t]] = np.fmax(holders[:, label[t]], nats[t, :, label[t]])
        else:
            claimed = np.fmax(claimed, nats[t])
    begins = np.r_[0, (stretches.frame[:-1] + stretches.frame[1:] + 1) // 2]
    for t in np.flatnonzero(np.isfinite(nats[..., 0]).sum(1) >= LEAST_ROWS).tolist():
        if label[t] < 0:
            both = np.logical_or.reduceat(held & stretches.seen[t], begins, axis=1).T
            out[t, :, :-1][both & (holders >= OTHERS * nats[t])] = -np.inf  # else the holder may leave it
        else:
            own = claimed[:, label[t]]
            out[t, :, -1] = np.where(own > 0, own, -np.inf)
    return out


def _turns(nats: Single, t: int, rows: Ints, label: Ints, least: Floats) -> list[Turn]:
    """The changes of a track that gain enough."""
    own = nats[t, rows]
    whole = int(own.sum(0).argmax())
    if own.max(1).sum() - own[:, whole].sum() < COST:
        return []
    sequence = best_sequence(own, COST)
    ends = [0, *(np.flatnonzero(np.diff(sequence)) + 1).tolist(), len(rows)]
    for a, b in pairwise(ends):
        to = int(sequence[a])
        if to != whole and not _gains(nats, t, rows[a:b], whole, to, label, least):
            sequence[a:b] = whole
    return [Turn(int(rows[k]), int(sequence[k - 1]), int(sequence[k])) for k in np.flatnonzero(np.diff(sequence)) + 1]


def _gains(nats: Single, t: int, rows: Ints, was: int, to: int, label: Ints, least: Floats) -> bool:
    """Whether a track is another marker in these rows, by (2)."""
    own = nats[t, rows]
    if own[:, to].mean() < least[to]:
        return False
    if len(least) - 1 in (was, to) and len(rows) < LEAST_ROWS:  # none is the last
        return False
    gain = float(own[:, to].sum() - own[:, was].sum())
    others = [u for u in np.flatnonzero(label == to).tolist() if u != t and np.isfinite(nats[u, rows, 0]).any()]
    if not others:
        return gain >= IF_FREE * COST
    lost = 0.0
    for u in others:
        there = np.nansum(nats[u, rows], axis=0)
        lost += there[to] - max(float(np.delete(there, to).max()), 0.0)
    return gain - lost >= COST and lost < OTHERS * gain


def frame_evidence(stretches: Stretches, label: Ints, pairs: PairScore) -> Single:
    """(T, K, L) nats of each track as each label in each frame, by all that is labelled; NaN where it is not seen."""
    L = len(pairs.distance)
    labelled = places(stretches, label, L)
    out = np.full((len(stretches), len(stretches.frame), L), np.nan, np.float32)
    for k in range(len(stretches.frame)):
        here = np.flatnonzero(np.isfinite(stretches.xyz[:, k, 0]))
        out[here, k] = pairs.of_points(stretches.xyz[here, k], labelled[k], label[here])
    return out


def best_sequence(nats: Single, cost: float) -> Ints:
    """(n) labels by (1), from the evidence (n, L)."""
    n, L = nats.shape
    back = np.zeros((n, L), np.int64)
    score = nats[0].astype(float)
    for k in range(1, n):
        best = int(score.argmax())
        stay = score >= score[best] - cost
        back[k] = np.where(stay, np.arange(L), best)
        score = np.where(stay, score, score[best] - cost) + nats[k]
    out = np.zeros(n, np.int64)
    out[-1] = int(score.argmax())
    for k in range(n - 1, 0, -1):
        out[k - 1] = back[k, out[k]]
    return out


def _frame_of(tracks: Trajectories, stretches: Stretches, t: int, turn: Turn, label: Ints, pairs: PairScore) -> int:
    """The frame of a change: the one before which the old label and from which on the new one has most evidence."""
    rows = np.flatnonzero(np.isfinite(stretches.xyz[t, :, 0]))
    at = int(np.searchsorted(rows, turn.row))
    low, high = (int(stretches.frame[rows[np.clip(k, 0, len(rows) - 1)]]) for k in (at - 2, at + 1))
    frames = low + np.flatnonzero(stretches.seen[t, low : high + 1])
    gain = np.array([_gain(tracks, t, int(f), turn, label, pairs) for f in frames])
    after = np.cumsum(gain[::-1])[::-1]
    return int(frames[1 + int(after[1:].argmax())])


def _gain(tracks: Trajectories, t: int, frame: int, turn: Turn, label: Ints, pairs: PairScore) -> float:
    """Nats by which a track is the new label, or none, rather than the old one in a frame.

    Whoever has one of these two meanwhile is no neighbour: it may be the other half of an exchange.
    """
    own = tracks.paths[t].xyz[frame]
    there = [u for u, path in enumerate(tracks) if u != t and np.isfinite(path.xyz[frame, 0])]
    labelled, held = np.full((len(pairs.distance), 3), np.nan, np.float32), np.zeros(len(pairs.distance))
    nameless = [u for u in there if label[u] < 0]
    for u in there:
        if label[u] in (turn.was, turn.to):
            held[label[u]] = HELD * (label[t] < 0)
        elif label[u] >= 0:
            labelled[label[u]] = tracks.paths[u].xyz[frame] - own
    at = np.array([own, *(tracks.paths[u].xyz[frame] for u in nameless)]) - own
    nats = pairs.of_points(at.astype(np.float32), labelled, np.full(len(at), -1))
    none = max(0.0, nats[1:, label[t]].max(initial=0.0)) if label[t] >= 0 else 0.0
    each = np.append(nats[0] - held, none)
    return float(each[turn.to] - each[turn.was])
