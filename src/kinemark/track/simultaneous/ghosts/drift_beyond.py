"""Chance meetings of two images, told by where these go on before they meet and after they part.

Images of two markers that two cameras take for one meet within the gate, and part where they have drifted out of it. So
the frames of the track are those in which they drift least, and a short one does not tell. Its images themselves go on
(`image_chains`): of two markers they drift on as they did, while images of one marker end where it is hidden or merges,
as the track would have gone on with them otherwise.

The residuals of a stretch of points of two images of the same cameras, together with those of up to BEYOND before and
after it in which both images go on, without a jump of more than JUMP, are judged by (2) of `drifting_pairs`, in the
same blocks. Where their sum is above CERTAIN, all points of the stretch are given up, if there are fewer than LONG.
Tracks with points of SOUND images are mostly markers, which the calibration may keep as far apart beyond the stretch as
in it. So of them only what changes tells: the square of the median of e − m of the stretch is added to L_0.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....numerics.returned_memory import return_memory
from ....numerics.runs import begins
from ..detection_index import Images
from .drifting_pairs import BLOCK, SOUND, Usual, UsualResiduals, blocks, residual, scores, shared_shift
from .image_chains import alone, expected, images_beyond

LEAST_BEYOND, BEYOND = 8, 0.06
"""Frames before a stretch, and after it, and s of them where these are more; chosen: a third of a block, in which
markers hardly part at 200 Hz. With 0.06 a scene of 200 Hz (seed 5242 of benchmarks/tracking_scenes.py) has 8 ghosts for
36 and the same samples; with 0.08 one of 120 Hz (130122) loses 76 of 4 585."""

LONG = 2 * BLOCK
"""Points of a stretch that are enough by themselves, a number; chosen: of 162 scenes of four cameras (seeds 130000 to
132130 and 137000 to 137129 of benchmarks/tracking_scenes.py) longer ones have 1 ghost of 381, and 258 of 538 points of
markers."""

HOLE = 2
"""Frames from one point of a stretch to the next, a number at most; chosen: one drop-out."""

LOOK = 12
"""Points in which images that merge unmarked came together, a number; chosen: half of a block."""

CERTAIN = float(np.log(100.0))
"""Two markers are then a hundred times likelier than one; chosen: see docs/theory/tracking-ghosts.md."""

JUMP = 3.0
"""Standard deviations of noise alone by which e changes from frame to frame at most; chosen: what drifts is smooth, and
an image that a lamp or a limb moves is not (see docs/theory/tracking-ghosts.md)."""

REACH, LEAST_REACH = 3.0, 1.5
"""Standard deviations of (1) of `image_chains` within which an image goes on, as the stretch itself has them, and of
the least of these, in those of its images; chosen: wider ones find other markers' images."""


class _Stretches(NamedTuple):
    """N stretches of R points of images of two cameras, by track and frame.

    Attributes:
        frame: (R); detection: (2, R); images: of all cameras; F: (3, 3) of the two.
        of: (R) the stretch of each; first, last: (N) rows.
    """

    frame: Ints
    detection: Ints
    images: Images
    F: Floats
    of: Ints
    first: Ints
    last: Ints

    def residual(self, detection: Ints) -> tuple[Floats, Floats]:
        """e (n) px and s² (n) px² of detections (2, n)."""
        return residual(self.images, self.F, detection[0], detection[1])


def drifting_beyond(
    frame: Ints, id: Ints, detection: Ints, images: Images, usual: UsualResiduals, r: float, gate: float, T: float
) -> Bools:
    """(P) the points of two images of tracks id (P), of detections (C, P), given up, T s from frame to frame; merged
    images do not count. r px is that of `image_chains`."""
    detection = images.own(detection)
    out, number, most = np.zeros(len(frame), bool), (detection >= 0).sum(0), max(LEAST_BEYOND, round(BEYOND / T))
    never = np.bincount(id, number >= SOUND) == 0
    order = np.flatnonzero(number == 2)
    order = order[np.lexsort([frame[order], id[order]])]
    own = detection[:, order] >= 0
    for (a, b), one in usual.of.items():
        rows = order[own[a] & own[b]]
        return_memory()
        e = residual(images, usual.F[a, b], detection[a, rows], detection[b, rows])[0]
        there = one.shifted(shared_shift(e - one.median, id[rows], images.uv[detection[a, rows]]))
        of = _stretch(frame[rows], id[rows])
        rows = rows[np.bincount(of)[of] < LONG]
        if len(rows):
            stretches = _stretches(frame[rows], id[rows], detection[[a, b]][:, rows], images, usual.F[a, b])
            shift = np.where(never[id[rows[stretches.first]]], 0.0, _medians(stretches, there))
            out[rows] = (_totals(stretches, there.shifted(shift), r, gate, most) > CERTAIN)[stretches.of]
    return out


def _stretches(frame: Ints, id: Ints, detection: Ints, images: Images, F: Floats) -> _Stretches:
    of = _stretch(frame, id)
    first = np.flatnonzero(begins(of))
    return _Stretches(frame, detection, images, F, of, first, np.append(first[1:], len(frame)) - 1)


def _stretch(frame: Ints, id: Ints) -> Ints:
    """(R) the number of the stretch of rows by track and frame."""
    return np.asarray(np.cumsum(begins(id) | (np.diff(frame, prepend=frame[:1]) > HOLE)) - 1)


def _medians(one: _Stretches, usual: Usual) -> Floats:
    """(N) the median of e − m of each stretch, px."""
    e = one.residual(one.detection)[0] - usual.median
    low, high = ((one.first + one.last + odd) // 2 for odd in (0, 1))
    ordered = e[np.lexsort([e, one.of])]
    return np.asarray((ordered[low] + ordered[high]) / 2)


def _totals(one: _Stretches, usual: Usual, r: float, gate: float, most: int) -> Floats:
    """(N) the sum of the scores of each of the stretches that are judged, by its own L (N, DEGREES); or 0."""
    parts = [(one.of, one.frame, one.detection), *_beyond(one, usual, r, most)]
    goes_on = np.isin(np.arange(len(one.first)), np.concatenate([stretch for stretch, _, _ in parts[1:]]))
    stretch, frame = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    order = np.lexsort([frame, stretch])
    stretch, frame = stretch[order], frame[order]
    e, squared = one.residual(np.concatenate([detection for _, _, detection in parts], 1)[:, order])
    total = np.zeros(len(one.first))
    for block in blocks(frame, stretch):
        which = stretch[block[:, 0]]
        own = usual._replace(lasting=usual.lasting[which])
        np.add.at(total, which, scores(e[block] - usual.median, squared[block].mean(1) * gate**2, own))
    return np.where(goes_on, total, 0.0)


def _beyond(one: _Stretches, usual: Usual, r: float, most: int) -> Iterator[tuple[Ints, Ints, Ints]]:
    """Stretch (K), frame (K) and detections (2, K) in which both images of a stretch go on, after it and before it."""
    reach, near = [_reach(one, detection) for detection in one.detection], _near_others(one, r)
    for step, end in ((1, one.last), (-1, one.first)):
        some = np.flatnonzero(_has_three(one, end, step) & ~near[end])
        three = end[some][:, None] - step * np.arange(2, -1, -1)
        each = zip(one.detection, reach, strict=True)
        both = np.array([images_beyond(one.images, d[three], step, px[some], r, most) for d, px in each])
        on = (both >= 0).all(0) & ~_jumps(one, np.concatenate([one.detection[:, end[some], None], both], 2), usual)
        which, k = np.nonzero(np.logical_and.accumulate(on, axis=1))
        yield some[which], one.frame[end[some[which]]] + step * (k + 1), both[:, which, k]


def _jumps(one: _Stretches, detection: Ints, usual: Usual) -> Bools:
    """(n, m − 1) whether e changes by more than JUMP from one of the detections (2, n, m) to the next."""
    e = one.residual(detection.reshape(2, -1))[0].reshape(detection.shape[1:])
    return np.asarray(np.abs(np.diff(e, axis=1)) > JUMP * np.sqrt(2 * usual.factor * usual.white))


def _has_three(one: _Stretches, end: Ints, step: int) -> Bools:
    """(N) whether the three points at the end of each stretch are of frames that follow each other."""
    third = end - 2 * step
    inside = (third >= one.first) & (third <= one.last)
    return inside & (np.abs(one.frame[np.where(inside, third, end)] - one.frame[end]) == 2)


def _near_others(one: _Stretches, r: float) -> Bools:
    """(R) whether one of the LOOK points of a stretch up to each, or from it on, comes or goes beside another image."""
    i = np.arange(1, len(one.frame))
    i = i[one.of[i] == one.of[i - 1]]
    beside = np.zeros(len(one.frame), bool)
    for d in one.detection if r else ():
        beside[i] |= ~alone(one.images, d[i], d[i - 1], r) | ~alone(one.images, d[i - 1], d[i], r)
    before, k = np.concatenate([[0], np.cumsum(beside)]), np.arange(len(beside))
    low, high = np.maximum(k - LOOK, one.first[one.of]), np.minimum(k + LOOK, one.last[one.of])
    return before[high + 1] > before[low]


def _reach(one: _Stretches, detection: Ints) -> Floats:
    """(N) px within which the images (R) of each stretch go on."""
    N, uv = len(one.first), one.images.uv[detection]
    mean = np.bincount(one.of, one.images.variance[detection], N) / np.bincount(one.of, minlength=N)
    i = np.arange(3, len(one.frame))
    i = i[(one.of[i] == one.of[i - 3]) & (one.frame[i] - one.frame[i - 3] == 3)]
    squared = ((uv[i] - expected(uv[i - 3], uv[i - 2], uv[i - 1])) ** 2).sum(1)
    number = np.bincount(one.of[i], minlength=N)
    usual = 20 / 3 * mean  # of (1), in both axes
    known = np.bincount(one.of[i], squared, N) / np.maximum(number, 1)
    return REACH * np.sqrt(np.maximum(np.where(number > 2, known, usual), LEAST_REACH**2 * mean))
