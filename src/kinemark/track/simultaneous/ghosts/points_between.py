"""Points between two markers: merged images of both, of several cameras, taken for a third marker.

Where cameras stand side by side, two markers run together in more than one of them at once, and their common images
meet half way between them, as well as those of one marker do. In files that mark merged images they say nothing; in
others they make a track. It is told by cameras that have no image of the point itself, but one on either side of the
places where the point is expected: at a and a′ from them, in one camera or in two, c and c′. Two markers at x ± d make
them, if

    a = J_c d,  a′ = −J_c′ d,   covariance S_c + ((s_a² + s_a′²) / 4 + (2 SHARE |a|)²) I,   |2a|, |2a′| > r      (1)

by least squares. One camera leaves open what d is along its ray: that by which both are nearest to each other in the
cameras k of the point. They run together in each of these if

    |2 J_k d| < r                                                                            (2)

and so do not if either image is of a track that has an image of its own there. Often a limb hides one of both for a
while. So where (1) and (2) hold in some frame of a track, in others one image by (2) is enough, with a = J_c d, that is
too far off to be the point's (3).

A point that has two images beside it by (1) and (2), or one by (3), is given up, if MOST of its track lies so. GATE
standard deviations are allowed for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....native.image_index import ranges
from ....numerics.runs import equal_runs
from ..detection_index import Images
from ..following.associate import PredictedImages, predict_images
from ..following.kalman_states import KalmanStates
from ..points.neighbouring_points import TrackPoints, parts_of_frames
from .near_held import AT_ONCE
from .unmarked_merging import SHARE

GATE = 3.0
"""Standard deviations of (1); chosen: as many as an image of both is hardly ever off."""

REACH = 3.0
"""Of r: how far a and a′ are looked for from q; chosen: of 14 scenes whose images merge at 10 px (of seeds 300003 to
350141 of benchmarks/tracking_scenes.py) 3 and 4 give up 44 ghosts more than 2, and 4 of 47 725 samples."""

MOST = 0.5
"""Of a track, a share; chosen: single points given up break tracks of markers, as one of `gait9` that then goes over to
another marker for 90 frames."""

ONE_RAY = 1e-3
"""Radians between rays of two cameras, or what follows from rounding alone, that count as one ray; chosen."""


def between_markers(points: TrackPoints, detection: Ints, images: Images, r: float) -> Bools:
    """(P) the points with detections (C, P) that lie between two others, where images nearer than r px are one."""
    both, one = np.zeros((2, len(points.id)), bool)
    if not r:
        return both
    for part in parts_of_frames(points.frame, AT_ONCE):
        both[part], one[part] = _seen_beside(points.take(part), detection[:, part], images, r)
    out = both | (one & (np.bincount(points.id, both) > 0)[points.id])
    return out & (np.bincount(points.id, out) >= MOST * np.bincount(points.id))[points.id]


def _pairs(group: Ints) -> tuple[Ints, Ints]:
    """Places of any two of the same group, groups (n) being sorted."""
    cuts = equal_runs(group)
    after = np.repeat(cuts[1:], np.diff(cuts)) - 1 - np.arange(len(group))
    return np.repeat(np.arange(len(group)), after), ranges(np.arange(1, len(group) + 1), after)


def _seen_beside(points: TrackPoints, detection: Ints, images: Images, r: float) -> tuple[Bools, Bools]:
    """(P) the points that have two images beside them by (1) and (2), and those that have one by (3)."""
    expected = predict_images(images.P, KalmanStates(points.xyz.T, points.cov.transpose(1, 2, 0)))
    known = np.isfinite(expected.uv[:, 0]) & (np.maximum(expected.S[:, 0], expected.S[:, 2]) < (r / 2) ** 2)
    c, row = np.nonzero((detection < 0) & known)
    at, image = images.near(points.frame[row] * len(images.P) + c, expected.uv[c, 0, row], np.full(len(c), REACH * r))
    c, row = c[at], row[at]
    off = images.uv[image] - expected.uv[c, :, row]
    good = (np.hypot(*off.T) < REACH * r) & ~_sees_both(detection, row, image, len(images.uv))
    good &= 2 * np.hypot(*off.T) > r
    good &= ~_within(off, expected.S[c, :, row], images.variance[image])
    order = np.flatnonzero(good)[np.argsort(row[good], kind="stable")]
    beside = _Beside(row[order], c[order], off[order], images.variance[image[order]])
    i, j = _pairs(beside.row)
    both, one = np.zeros((2, len(points.id)), bool)
    both[beside.row[i[_on_both_sides(expected, detection, beside.take(i), beside.take(j), r)]]] = True
    J = np.tile(expected.J[beside.camera, :, :, beside.row], (1, 2, 1))
    d = _displacement(J, np.tile(beside.off, 2))
    one[beside.row[_apart(expected, detection, beside.row, J, d) < r]] = True  # (3)
    return both, one


class _Beside(NamedTuple):
    """N images beside points: row of the point and camera (N), off (N, 2) px from the point, variance (N) px²."""

    row: Ints
    camera: Ints
    off: Floats
    variance: Floats

    def take(self, which: Ints) -> _Beside:
        """Only these."""
        return _Beside(self.row[which], self.camera[which], self.off[which], self.variance[which])


def _on_both_sides(expected: PredictedImages, detection: Ints, one: _Beside, other: _Beside, r: float) -> Bools:
    """(N) whether images lie on either side of their points by (1) and (2)."""
    J, S = ([of[each.camera, ..., each.row] for each in (one, other)] for of in (expected.J, expected.S))
    both, h = np.concatenate(J, axis=1), np.concatenate([one.off, -other.off], axis=1)
    d = _displacement(both, h)
    seen = np.einsum("nij,nj->ni", both, d)
    room = (one.variance + other.variance) / 4 + 2 * SHARE**2 * (seen**2).sum(1)
    good = _within((h - seen)[:, :2], S[0], room) & _within((h - seen)[:, 2:], S[1], room)
    return np.asarray(good & (_apart(expected, detection, one.row, both, d) < r))


def _within(off: Floats, S: Floats, room: Floats) -> Bools:
    """(n) whether places off (n, 2) px lie within GATE standard deviations, by S (n, 3) and room (n) px²."""
    x, y = off.T
    a, b, d = S.T + np.stack([room, 0 * room, room])
    return np.asarray(d * x * x - 2 * b * x * y + a * y * y < GATE**2 * (a * d - b * b))


def _sees_both(detection: Ints, row: Ints, image: Ints, D: int) -> Bools:
    """(n) whether a camera has an image of each of a point and of the point that has another image."""
    holder = np.full(D, -1, np.int32)
    for camera in detection:
        holder[camera[camera >= 0]] = np.flatnonzero(camera >= 0)
    other = holder[image]
    return np.asarray((other >= 0) & ((detection[:, row] >= 0) & (detection[:, other] >= 0)).any(0))


def _displacement(J: Floats, h: Floats) -> Floats:
    """d (n, 3) mm, the least of those for which J (n, 4, 3) d is nearest to h (n, 4) px."""
    return np.asarray(np.einsum("nij,nj->ni", np.linalg.pinv(J, rcond=ONE_RAY), h))


def _apart(expected: PredictedImages, detection: Ints, row: Ints, J: Floats, d: Floats) -> Floats:
    """(n) px of (2) in that camera of a point, of those that have an image of it, in which it is most; with d (n, 3) mm
    that follows from J (n, 4, 3), which may leave it open along one ray."""
    _, size, axes = np.linalg.svd(J)
    ray = axes[:, 2] * (size[:, 2] < ONE_RAY * size[:, 0])[:, None]
    has, of_all = detection[:, row] >= 0, expected.J[..., row]
    across, along = (np.where(has[:, None], np.einsum("kijn,nj->kin", of_all, v), 0.0) for v in (d, ray))
    along_ray = -(across * along).sum((0, 1)) / np.maximum((along * along).sum((0, 1)), np.finfo(float).tiny)
    return np.asarray(2 * np.linalg.norm(across + along_ray * along, axis=1).max(0))
