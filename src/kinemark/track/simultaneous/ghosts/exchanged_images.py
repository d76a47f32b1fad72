"""Two tracks that have exchanged images: each has one of either of two markers.

Where two markers lie near each other's lines, and two cameras alone see the track of either, both tracks can have the
wrong images: a and b of one, c and d of the other, where a and c are one marker's, and b and d. No image is left over
that would tell it (`chance_meetings`), but with the score (2) of `drifting_pairs`, the log-likelihood ratio of two
markers to one, over the frames that stretches of both have in common,

    S = score(a, b) + score(c, d) − score(a, c) − score(b, d)                             (1)

says how much likelier the other pairs are. Above CERTAIN, and where either of these is rather one marker's, the images
change their tracks. Which pair is whose is told by the points that the tracks have before and after these frames: of
both ways that with the smaller sum of distances is taken (2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....numerics.runs import begins
from ..detection_index import Images
from ..following.candidate_points import intersect
from .chance_meetings import usual_of_two
from .drift_of_runs import scores_of_runs
from .drifting_pairs import UsualResiduals, residual
from .rival_pairs import stretches

LEAST = 6
"""Frames that both stretches have in common, a number at least; chosen: of four or five, all fit (137010, 141068 of
benchmarks/tracking_scenes.py: scores of markers up to 5.1)."""

CERTAIN = float(np.log(100.0))
"""The other pairs are then a hundred times likelier; chosen, as in `drift_beyond`."""


class _Stretches(NamedTuple):
    """K stretches of points of two images: their rows, one stretch after the other; where each begins among these and
    its first and last frames, all (K)."""

    rows: Ints
    begin: Ints
    first: Ints
    last: Ints

    def row(self, stretch: Ints, frame: Ints) -> Ints:
        """The row of a stretch in a frame of it."""
        return self.rows[self.begin[stretch] + frame - self.first[stretch]]


class _Exchanges(NamedTuple):
    """N pairs of stretches (2, N) that may have exchanged images, and their common frames, from `first` to `last` (N);
    whether the first image of the one belongs to the first of the other, or to the second (N)."""

    stretch: Ints
    first: Ints
    last: Ints
    straight: Bools

    def take(self, which: Bools | Ints) -> _Exchanges:
        """Only these."""
        return _Exchanges(self.stretch[:, which], self.first[which], self.last[which], self.straight[which])


def with_exchanged(frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, gate: float) -> Ints:
    """The detections (C, P) of points of tracks id (P), those of tracks that have exchanged images changed back."""
    usual = usual_of_two(id, detection, images, usual)
    number = stretches(frame, id, detection, LEAST)
    rows = np.flatnonzero(number >= 0)
    rows = rows[np.lexsort([frame[rows], number[rows]])]
    if not len(rows):
        return detection
    begin = np.flatnonzero(begins(number[rows]))
    end = np.append(begin[1:], len(rows)) - 1
    each = _Stretches(rows, begin, frame[rows[begin]], frame[rows[end]])
    held = np.sort(np.argsort(detection[:, rows] < 0, axis=0, kind="stable")[:2], axis=0)
    two = np.full((2, detection.shape[1]), -1)
    two[:, rows] = np.take_along_axis(detection[:, rows], held, 0)
    possible = _possible(each, two, id, images, usual, gate)
    return _changed(frame, id, detection, two, each, possible, images, usual, gate)


def _possible(each: _Stretches, two: Ints, id: Ints, images: Images, usual: UsualResiduals, gate: float) -> _Exchanges:
    """Stretches of different tracks, of detections two (2, P), whose images fit one another in the middle of the frames
    that they have in common."""
    order = np.argsort(each.first, kind="stable")
    until = np.searchsorted(each.first[order], each.last[order] - LEAST + 2)
    many = np.maximum(until - np.arange(len(order)) - 1, 0)
    one = np.repeat(np.arange(len(order)), many)
    other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(many) - many, many)
    stretch = np.sort(order[np.stack([one, other])], axis=0)
    first, last = each.first[stretch].max(0), each.last[stretch].min(0)
    both = _Exchanges(stretch, first, last, np.ones(len(first), bool))
    both = both.take((last - first + 1 >= LEAST) & (np.diff(id[each.rows[each.begin[stretch]]], axis=0)[0] != 0))
    ways = []
    for straight in (True, False):
        middle = (both.first + both.last) // 2
        a, b = two[:, each.row(both.stretch[0], middle)]
        c, d = two[:: 1 if straight else -1, each.row(both.stretch[1], middle)]
        good = _fit(np.stack([a, c]), images, usual, gate) & _fit(np.stack([b, d]), images, usual, gate)
        ways.append(both._replace(straight=both.straight == straight).take(good))
    return _Exchanges(*(np.concatenate(column, -1) for column in zip(*ways, strict=True)))


def _fit(pair: Ints, images: Images, usual: UsualResiduals, gate: float) -> Bools:
    """(n) whether images (2, n) are of two cameras that are judged, lie within the gate, and are not merged."""
    pair = np.where(images.camera[pair[0]] < images.camera[pair[1]], pair, pair[::-1])
    camera, out = images.camera[pair], np.zeros(pair.shape[1], bool)
    for (a, b), one in usual.of.items():
        some = np.flatnonzero((camera[0] == a) & (camera[1] == b))
        e, squared = residual(images, usual.F[a, b], *pair[:, some])
        out[some] = (e - one.median) ** 2 < gate**2 * squared
    return out & ~images.merged[pair].any(0)


def _changed(
    frame: Ints,
    id: Ints,
    detection: Ints,
    two: Ints,
    each: _Stretches,
    possible: _Exchanges,
    images: Images,
    usual: UsualResiduals,
    gate: float,
) -> Ints:
    """The detections (C, P), those of the likeliest exchanges by (1) changed back, each row once."""
    if not len(possible.first):
        return detection
    many = possible.last - possible.first + 1
    of = np.repeat(np.arange(len(many)), many)
    common = possible.first[of] + np.arange(len(of)) - np.repeat(np.cumsum(many) - many, many)
    row, other = (each.row(stretch[of], common) for stretch in possible.stretch)
    (a, b), (c, d) = two[:, row], np.where(possible.straight[of], two[:, other], two[::-1, other])
    pairs = [np.stack(pair) for pair in ((a, b), (c, d), (a, c), (b, d))]
    own, its, new, rest = (scores_of_runs(pair, common, of, len(many), images, usual, gate) for pair in pairs)
    merged = np.bincount(of, images.merged[np.stack([a, b, c, d])].any(0)) > 0
    S = np.where((new < 0) & (rest < 0) & ~merged, own + its - new - rest, -np.inf)  # (1)
    out, used = detection.copy(), np.zeros(detection.shape[1], bool)
    for k in np.argsort(-S, kind="stable")[: np.count_nonzero(S > CERTAIN)].tolist():
        some = of == k
        both = np.stack([row[some], other[some]])
        if not used[both].any():
            used[both] = True
            new_pairs = np.stack([pairs[2][:, some], pairs[3][:, some]], 1)
            out[:, both] = _whose(frame, id, detection, both, new_pairs, images)
    return out


def _whose(frame: Ints, id: Ints, detection: Ints, row: Ints, pair: Ints, images: Images) -> Ints:
    """(C, 2, n) the detections of rows (2, n) of two tracks, of pairs of images (2, 2, n), the second axis telling the
    one from the other, by (2)."""
    n = row.shape[1]
    own = np.full((len(images.P), 2, n), -1)
    for image in pair:
        own[images.camera[image], np.arange(2)[:, None], np.arange(n)] = image
    xyz = intersect(images, own.reshape(len(own), -1)).xyz.reshape(3, 2, n)
    beside = [_beside(frame, id, one) for one in row]
    far = np.array([[_apart(images, detection, near, place) for place in xyz.swapaxes(0, 1)] for near in beside])
    return own if far.trace() <= far[::-1].trace() else own[:, ::-1]


def _beside(frame: Ints, id: Ints, row: Ints) -> list[Ints]:
    """The row, if any, of the last point of a track before its rows (n), and of the first after them."""
    track = np.flatnonzero(id == id[row[0]])
    track = track[np.argsort(frame[track])]
    return [track[frame[track] < frame[row[0]]][-1:], track[frame[track] > frame[row[-1]]][:1]]


def _apart(images: Images, detection: Ints, beside: list[Ints], xyz: Floats) -> float:
    """mm from places (3, n) at either end to the points `beside` them."""
    ends = [
        intersect(images, detection[:, near]).xyz - xyz[:, [end]] for near, end in zip(beside, (0, -1), strict=True)
    ]
    return float(sum(np.linalg.norm(off, axis=0).sum() for off in ends))
