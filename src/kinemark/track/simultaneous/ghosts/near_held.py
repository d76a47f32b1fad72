"""Images that one track has where another is expected: of both markers, or of one while the other is hidden."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ....native import ImageIndex
from ..detection_index import Images
from ..following.associate import predict_images
from ..following.kalman_states import KalmanStates
from ..points.neighbouring_points import TrackPoints, parts_of_frames

REACH = 0.65
"""Of r: how far a common image lies from either marker at most, as that has `unmarked_merging.SHARE` more of the other;
chosen."""

AT_ONCE = 20_000
"""Points that are looked at in one go; more would take memory and no less time; chosen."""


class NearHeld(NamedTuple):
    """N places of points without an image in a camera, and images near them that others hold: rows of the points
    (other) and of the holders, camera and image, all (N); where the point is expected, uv (2, N) px, variance (N) px².
    """

    holder: Ints
    other: Ints
    camera: Ints
    image: Ints
    uv: Floats
    variance: Floats

    def take(self, which: Bools | Ints) -> NearHeld:
        """Only these."""
        row, other, camera, image, uv, variance = self
        return NearHeld(row[which], other[which], camera[which], image[which], uv[:, which], variance[which])


def near_held(
    points: TrackPoints, detection: Ints, images: Images, r: float, unseen: TrackPoints | None = None
) -> Iterator[NearHeld]:
    """The images of points, of detections (C, P), that lie where another point, which lacks one, is expected: part by
    part, an image being in one part alone. In other parts, where `unseen` ones are, whose rows come after those (P)."""
    holder = np.full(len(images.uv), -1, np.int32)  # half the memory of a column that long recordings make long
    for camera in detection:
        holder[camera[camera >= 0]] = np.flatnonzero(camera >= 0)
    held = images.by_cell.keep(holder >= 0)
    for part in parts_of_frames(points.frame, AT_ONCE) or [np.arange(0)]:
        near = _near_held(points.take(part), detection[:, part], images, held, r)
        yield near._replace(holder=holder[near.image].astype(np.int64), other=part[near.other])
    unseen = points.take(np.zeros(0, np.int64)) if unseen is None else unseen
    for part in parts_of_frames(unseen.frame, AT_ONCE):
        near = _near_held(unseen.take(part), np.full((len(detection), len(part)), -1), images, held, r)
        other = len(points.id) + part[near.other]
        yield near._replace(holder=holder[near.image].astype(np.int64), other=other)


def _near_held(points: TrackPoints, detection: Ints, images: Images, held: ImageIndex, r: float) -> NearHeld:
    """Of these points, by the images that points have; holders are left out."""
    C, xyz, cov = len(images.P), points.xyz.T, points.cov.transpose(1, 2, 0)
    expected = predict_images(images.P, KalmanStates(xyz, cov))
    variance = (expected.S[:, 0] + expected.S[:, 2]) / 2
    lacks = (detection < 0) & np.isfinite(expected.uv[:, 0]) & (variance < (r / 4) ** 2)
    c, other = np.nonzero(lacks)
    reach = REACH * r + 2 * np.sqrt(variance[c, other])
    at, image = held.near(points.frame[other] * C + c, expected.uv[c, 0, other], reach)
    apart = np.hypot(*(expected.uv[c[at], :, other[at]] - images.uv[image]).T)
    at, image = at[apart < reach[at]], image[apart < reach[at]]
    c, other = c[at], other[at]
    return NearHeld(image, other, c, image, expected.uv[c, :, other].T, variance[c, other])
