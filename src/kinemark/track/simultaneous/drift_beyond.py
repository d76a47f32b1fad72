"""Chance meetings of two images, told by where these go on before they meet and after they part.

Images of two markers that two cameras take for one meet within the gate, and part where they have drifted out of it. So
the frames of the track are those in which they drift least, and a short one does not tell. Its images themselves go on
(`image_chains`): of two markers they drift on as they did, while images of one marker end where it is hidden or merges,
as the track would have gone on with them otherwise.

The residuals of a stretch of points of two images of the same cameras, together with those of up to MOST_BEYOND frames
before and after it in which both images go on, are judged by (2) of `drifting_pairs`, in the same blocks. Where their
sum is above CERTAIN, all points of the stretch are given up, if there are fewer than LONG and no point of their track
has SOUND images: those of others are a marker's that has lost one of its images more often.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...numerics.runs import begins
from .detection_index import Images
from .drifting_pairs import BLOCK, SOUND, Usual, UsualResiduals, blocks, residual, scores, shared_shift
from .image_chains import alone, expected, images_beyond

MOST_BEYOND = 8
"""Frames before a stretch, and after it; chosen: a third of a block."""

LONG = 2 * BLOCK
"""Points of a stretch that are enough by themselves, a number; chosen: of 162 scenes of four cameras (seeds 130000 to
132130 and 137000 to 137129 of benchmarks/tracking_scenes.py) longer ones have 1 ghost of 381, and 258 of 538 points of
markers."""

HOLE = 2
"""Frames from one point of a stretch to the next, a number at most; chosen: one drop-out."""

LOOK = 12
"""Points in which images that merge unmarked came together, a number; chosen: half of a block."""

CERTAIN = float(np.log(100.0))
"""Two markers are then a hundred times likelier than one; chosen: see docs/theory/simultaneous-tracking.md."""

REACH, LEAST_REACH = 3.0, 1.5
"""Standard deviations of (1) of `image_chains` within which an image goes on, as the stretch itself has them, and of
the least of these, in those of its images; chosen: wider ones find other markers' images."""


class _Stretches(NamedTuple):
    """N stretches of R rows of points: the stretch (R) of each row, and the first row and the last (N) of each."""

    of: Ints
    first: Ints
    last: Ints

    @classmethod
    def of_rows(cls, frame: Ints, id: Ints) -> _Stretches:
        """Of rows by track and frame."""
        new = begins(id) | (np.diff(frame, prepend=frame[:1]) > HOLE)
        first = np.flatnonzero(new)
        return cls(np.cumsum(new) - 1, first, np.append(first[1:], len(frame)) - 1)


def drifting_beyond(
    frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, r: float, gate: float
) -> Bools:
    """(P) the points of two images of tracks id (P), of detections (C, P), that are given up; r px of `image_chains`."""
    out, number = np.zeros(len(frame), bool), (detection >= 0).sum(0)
    never = np.bincount(id, number >= SOUND) == 0
    order = np.flatnonzero(number == 2)
    order = order[np.lexsort([frame[order], id[order]])]
    own = (detection[:, order] >= 0) & ~images.merged[detection[:, order]]
    for (a, b), one in usual.of.items():
        rows = order[own[a] & own[b]]
        e = residual(images, usual.F[a, b], detection[a, rows], detection[b, rows])[0]
        there = one.shifted(shared_shift(e - one.median, id[rows]))
        rows = rows[never[id[rows]]]
        if len(rows):
            stretches = _Stretches.of_rows(frame[rows], id[rows])
            pair = detection[[a, b]][:, rows]
            total = _totals(frame[rows], pair, stretches, images, usual.F[a, b], there, r, gate)
            out[rows] = (total > CERTAIN)[stretches.of]
    return out


def _totals(
    frame: Ints, pair: Ints, stretches: _Stretches, images: Images, F: Floats, usual: Usual, r: float, gate: float
) -> Floats:
    """(N) the sum of the scores of each stretch of detections (2, R) whose images go on, 0 of the others."""
    radius, near = [_radius(frame, images, one, stretches) for one in pair], _near_others(images, pair, stretches, r)
    of, when, both = [stretches.of], [frame], [pair]
    for step, end in ((1, stretches.last), (-1, stretches.first)):
        some = np.flatnonzero(_has_three(frame, stretches, end, step) & ~near[end])
        three = end[some][:, None] - step * np.arange(2, -1, -1)
        beyond = np.array(
            [
                images_beyond(images, one[three], step, reach[some], r, MOST_BEYOND)
                for one, reach in zip(pair, radius, strict=True)
            ]
        )
        which, k = np.nonzero(np.logical_and.accumulate((beyond >= 0).all(0), axis=1))
        of.append(some[which])
        when.append(frame[end[some[which]]] + step * (k + 1))
        both.append(beyond[:, which, k])
    judged = np.isin(np.arange(len(stretches.first)), np.concatenate(of[1:]))
    judged &= stretches.last - stretches.first + 1 < LONG
    stretch, when, detection = np.concatenate(of), np.concatenate(when), np.concatenate(both, 1)
    order = np.lexsort([when, stretch])
    stretch, when, detection = stretch[order], when[order], detection[:, order]
    e, squared = residual(images, F, detection[0], detection[1])
    total = np.zeros(len(stretches.first))
    for block in blocks(when, stretch):
        score = scores(e[block] - usual.median, squared[block].mean(1) * gate**2, usual)
        np.add.at(total, stretch[block[:, 0]], score)
    return np.where(judged, total, 0.0)


def _has_three(frame: Ints, stretches: _Stretches, end: Ints, step: int) -> Bools:
    """(N) whether the three points at the end of each stretch are of frames that follow each other."""
    third = end - 2 * step
    inside = (third >= stretches.first) & (third <= stretches.last)
    return inside & (np.abs(frame[np.where(inside, third, end)] - frame[end]) == 2)


def _near_others(images: Images, pair: Ints, stretches: _Stretches, r: float) -> Bools:
    """(R) whether one of the LOOK points of a stretch up to each, or from it on, comes or goes beside another image."""
    i = np.arange(1, pair.shape[1])
    i = i[stretches.of[i] == stretches.of[i - 1]]
    beside = np.zeros(pair.shape[1], bool)
    for one in pair if r else ():
        beside[i] |= ~alone(images, one[i], one[i - 1], r) | ~alone(images, one[i - 1], one[i], r)
    before = np.concatenate([[0], np.cumsum(beside)])
    k = np.arange(len(beside))
    low, high = np.maximum(k - LOOK, stretches.first[stretches.of]), np.minimum(k + LOOK, stretches.last[stretches.of])
    return before[high + 1] > before[low]


def _radius(frame: Ints, images: Images, detection: Ints, stretches: _Stretches) -> Floats:
    """(N) px within which the images (R) of each stretch go on."""
    N, uv = len(stretches.first), images.uv[detection]
    mean = np.bincount(stretches.of, images.variance[detection], N) / np.bincount(stretches.of, minlength=N)
    i = np.arange(3, len(frame))
    i = i[(stretches.of[i] == stretches.of[i - 3]) & (frame[i] - frame[i - 3] == 3)]
    squared = ((uv[i] - expected(uv[i - 3], uv[i - 2], uv[i - 1])) ** 2).sum(1)
    number = np.bincount(stretches.of[i], minlength=N)
    usual = 20 / 3 * mean  # of (1), in both axes
    known = np.bincount(stretches.of[i], squared, N) / np.maximum(number, 1)
    return REACH * np.sqrt(np.maximum(np.where(number > 2, known, usual), LEAST_REACH**2 * mean))
