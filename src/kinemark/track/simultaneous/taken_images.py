"""Images that a track has for a moment, though another track's marker makes them.

Where few cameras see two markers, the image of one may lie where the other is expected too. The track of the latter,
which lacks an image there, takes it, and the former has none, often just for a frame. What the images of that frame say
of either track is the same, but not what was before and comes after. A track j that has images of a camera in at most
AROUND frames before and after, and none between, is expected there at u_j with covariance S_j: by its other images of
that frame, or by its motion on both sides. The track i that has the image x, of variance s², is expected at u_i with
S_i by its motion on both sides and its other images. So

    L = ln N(x; u_j, S_j + s² I) − ln N(x; u_i, S_i + s² I)                               (1)

is the log-likelihood ratio of the image being j's to it being i's. Above 0 it is taken from i, if both tracks are seen
apart (`seen_apart`): pieces of one marker's trajectory expect its images alike. Of a point of two images nothing is
left then, and the second pass looks whose they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ... import native
from ...data.array_types import Floats, Ints
from ...native.image_index import ranges
from .associate import candidates, predict_images
from .detection_index import Images
from .drifting_pairs import MOST_IMAGES
from .kalman_states import KalmanStates, update
from .neighbouring_points import RowsByTrack, TrackPoints, motion_beside
from .second_pass import expected_between
from .seen_apart import SeenApart
from .simultaneous_method import Simultaneous

AROUND = 3
"""Frames before and after, a number; chosen: of 60 scenes of four and six cameras (of seeds 30011 to 31028 of
benchmarks/tracking_scenes.py) it tells 8 of 52 ghosts in tracks of markers, and one image of a marker.
No more than `max_coasting` has: of a plate at 10 Hz three frames make 26 swaps, and one at most 5."""

APART = 6.0
"""px, by which tracks are apart in some camera, of `SeenApart`; chosen: of the 60 scenes 9 images are claimed by tracks
that are not, of which 8 are rightly where they are; of the 34 that others claim one is."""


class _Claims(NamedTuple):
    """N images (N) of points of rows `holder`, by the camera, that the track `other` claims too, and twice
    ln N(x; u_j, …) of (1), but for a constant."""

    holder: Ints
    camera: Ints
    image: Ints
    other: Ints
    said: Floats


def without_taken(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> Ints:
    """The detections (C, P) of points without those that are other tracks' images by (1); frames are T s apart."""
    claims = _claims(points, detection, images, T, method)
    if not len(claims.image):
        return detection
    taken = claims.said > _own(claims, points, detection, images, T, method)
    taken &= SeenApart(points, detection, images.P, APART)(points.id[claims.holder], claims.other)
    out = detection.copy()
    out[claims.camera[taken], claims.holder[taken]] = -1
    return out


def _claims(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> _Claims:
    """What tracks claim that lack an image between others of the same camera; of several on an image the likeliest."""
    around = min(AROUND, round(method.max_coasting / T))
    every = points.plus(expected_between(points, images.n_frames, T, method, look=around))
    c, id, frame = _lacking(points, detection, around)
    row = RowsByTrack.of(every.frame, every.id).at(id, frame)
    which, at = np.unique(row[row >= 0], return_inverse=True)
    every, lacking = every.take(which), np.zeros((len(detection), len(which)), bool)
    lacking[c[row >= 0], at] = True
    holder = np.full(len(images.uv), -1)
    few = np.flatnonzero((detection >= 0).sum(0) <= MOST_IMAGES)
    for own in detection[:, few]:
        holder[own[own >= 0]] = few[own >= 0]
    expected = predict_images(images.P, KalmanStates(every.xyz.T, every.cov.transpose(1, 2, 0)))
    pairs = candidates(images, holder >= 0, every.frame, expected, method.gate)
    c, at = np.divmod(pairs.own, max(len(which), 1))
    good = np.flatnonzero(lacking[c, at] & (points.id[holder[pairs.detection]] != every.id[at]))
    said = -pairs.squared[good] - pairs.log_det[good]
    image = pairs.detection[good]
    order = np.lexsort([-said, image])
    best = order[np.diff(image[order], prepend=-1) > 0]
    return _Claims(holder[image[best]], c[good[best]], image[best], every.id[at[good[best]]], said[best])


def _lacking(points: TrackPoints, detection: Ints, around: int) -> tuple[Ints, Ints, Ints]:
    """Cameras, tracks and frames (n): those in which tracks lack an image of a camera that they have in at most
    `around` frames before and after."""
    order, found = np.lexsort([points.frame, points.id]), []
    for c, own in enumerate(detection[:, order]):
        has = order[own >= 0]
        id, frame = points.id[has], points.frame[has]
        step = np.diff(frame)
        k = np.flatnonzero((np.diff(id) == 0) & (step > 1) & (step <= 2 * around))
        between = ranges(frame[k] + 1, step[k] - 1)
        k = np.repeat(k, step[k] - 1)
        near = (between - frame[k] <= around) & (frame[k + 1] - between <= around)
        found.append(np.stack([np.full(np.count_nonzero(near), c), id[k][near], between[near]]))
    c, id, frame = np.concatenate(found, 1)
    return c, id, frame


def _own(
    claims: _Claims, points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous
) -> Floats:
    """(N) twice ln N(x; u_i, …) of (1), but for the same constant."""
    row, n = claims.holder, np.arange(len(claims.holder))
    rows = RowsByTrack.of(points.frame, points.id)
    motion = motion_beside(points, rows, row, np.ones(len(points.id), bool), T, method)
    others = detection[:, row]
    others[claims.camera, n] = -1
    expected = predict_images(images.P, motion)
    variance = np.where(others >= 0, images.variance[others], np.inf)
    motion = update(motion, *native.information(expected.uv, expected.J, others, variance, images.uv))
    expected = predict_images(images.P, motion)
    x, y = images.uv[claims.image].T - expected.uv[claims.camera, :, n].T
    a, b, d = expected.S[claims.camera, :, n].T
    a, d = a + images.variance[claims.image], d + images.variance[claims.image]
    det = a * d - b * b
    return np.asarray(-(d * x * x - 2 * b * x * y + a * y * y) / det - np.log(det))
