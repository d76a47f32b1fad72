"""Images that a track has for a moment, though another track's marker makes them.

Where few cameras see two markers, the image of one may lie where the other is expected too. The track of the latter,
which lacks an image there, takes it, and the former has none, often just for a frame. What the images of that frame say
of either track is the same, but not what was before and comes after. A track j that has images of a camera in at most
AROUND frames before and after, and none between, is expected there at u_j with covariance S_j: by its other images of
that frame, or by its motion on both sides. The track i that has the image x, of variance s², is expected at u_i with
S_i by its motion on both sides and its other images. So

    L = ln N(x; u_j, S_j + s² I) − ln N(x; u_i, S_i + s² I)                               (1)

is the log-likelihood ratio of the image being j's to it being i's. Above 0 it is taken from i, if both tracks are seen
apart (`seen_apart`). Of a point of one image nothing is left; the second pass looks whose the images are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ... import native
from ...data.array_types import Bools, Floats, Ints
from .associate import candidates, predict_images
from .detection_index import Images
from .drifting_pairs import MOST_IMAGES
from .kalman_states import KalmanStates, update
from .neighbouring_points import RowsByTrack, TrackPoints, motion_beside
from .second_pass import expected_between
from .seen_apart import SeenApart
from .simultaneous_method import Simultaneous

AROUND = 3
"""Frames before and after, a number; chosen: of 35 scenes of four and six cameras (of seeds 30000 to 31029 of
benchmarks/tracking_scenes.py) it tells 8 of 55 ghosts in tracks of markers, and one image of a marker."""


class _Claims(NamedTuple):
    """N images (N) of points of rows `holder`, by the camera, that another track claims too, and twice ln N(x; u_j, …)
    of (1), but for a constant."""

    holder: Ints
    camera: Ints
    image: Ints
    other: Ints
    said: Floats

    def take(self, which: Bools | Ints) -> _Claims:
        """Only these."""
        return _Claims(*(column[which] for column in self))


def without_taken(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> Ints:
    """The detections (C, P) of points without those that are other tracks' images by (1); frames are T s apart."""
    claims = _claims(points, detection, images, T, method)
    if not len(claims.image):
        return detection
    good = claims.said > _own(claims, points, detection, images, T, method)
    claims = claims.take(good)
    apart = SeenApart(points, detection, images.P, 0.0)
    claims = claims.take(apart(points.id[claims.holder], claims.other))
    out = detection.copy()
    out[claims.camera, claims.holder] = -1
    return out


def _claims(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> _Claims:
    """What tracks claim that lack an image between others of the same camera; of several on an image the likeliest."""
    unseen = expected_between(points, images.n_frames, T, method, look=AROUND)
    every, C = points.plus(unseen), len(images.P)
    lacking = _lacking(points, detection, every)
    which = np.flatnonzero(lacking.any(0))
    every, lacking = every.take(which), lacking[:, which]
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
    claims = _Claims(holder[image], c[good], image, every.id[at[good]], said)
    order = np.lexsort([-said, image])
    return claims.take(order[np.diff(image[order], prepend=-1) > 0])


def _lacking(points: TrackPoints, detection: Ints, every: TrackPoints) -> Bools:
    """(C, N) whether tracks in frames of `every`, the points (P) first, lack an image of a camera that they have in at
    most AROUND frames before and after."""
    out = np.zeros((len(detection), len(every.id)), bool)
    for own, lacks in zip(detection, out, strict=True):
        has = np.flatnonzero(own >= 0)
        rows = RowsByTrack.of(points.frame[has], points.id[has])
        steps = np.arange(1, AROUND + 1)[:, None]
        before, after = ((rows.at(every.id, every.frame + way * steps) >= 0).any(0) for way in (-1, 1))
        lacks[:] = before & after
        lacks[has] = False
    return out


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
