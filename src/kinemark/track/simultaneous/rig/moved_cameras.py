"""Images of a camera that was knocked within a recording, as it would have them had it stayed where it was.

The rig has each camera once. From the knock on a camera stands at R', t' and has the focal lengths of K'
(`turned_camera`), where it stood at R, t and had those of K. An image at the ideal pixel u' (homogeneous), at depth z,
would have been at

    u ~ K (A + (t − A t') (0, 0, 1) / z) K'⁻¹ u',   A = R R'ᵀ                              (1)

(Hartley & Zisserman 2004, section 13.1), with z the median depth of the points. For points nearer or farther by δ, a
knock that moves the camera by s leaves f s δ / z² px: 0.15 px for 3 mm, 500 mm, 4 m and 1600 px. With e what (1) leaves
of n points, images put back are off by a covariance

    S = Σ e eᵀ / n + S_now + S_was                                                        (2)

with what is not known of where the camera stands (`turned_camera` (4)), and stood.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....data import Camera, Detections, Rig, Tracks
from ....data.array_types import Bools, Floats
from ....geometry import project
from ....geometry.camera import distort, undistort
from ....numerics.vectors import homogeneous
from .turned_camera import PutRight, put_right
from .unfitting_stretches import Stretch


class MovedCamera(NamedTuple):
    """A camera, a number, that stands otherwise in frames first to stop − 1; map (3, 3) of (1) from ideal pixels as it
    stands to those as it was calibrated."""

    camera: int
    first: int
    stop: int
    map: Floats

    @classmethod
    def of(cls, number: int, first: int, stop: int, was: Camera, now: Camera, depth: float) -> MovedCamera:
        """By (1), for points at a depth in mm."""
        A = was.R @ now.R.T
        plane = A + np.outer((was.t - A @ now.t) / depth, [0.0, 0.0, 1.0])
        return cls(number, first, stop, was.K @ plane @ np.linalg.inv(now.K))


class PutBack(NamedTuple):
    """A camera that was knocked, and the covariance (2, 2) px² of (2)."""

    moved: MovedCamera
    cov: Floats


def moved_camera(stretch: Stretch, offset: Floats, tracks: Tracks, detections: Detections, rig: Rig) -> PutBack | None:
    """A camera as the points of the others show it in a stretch; None where they cannot tell.

    They show it before the stretch too, or it stood as it was calibrated: what the file is off by stays as it was.

    Args:
        stretch: of the camera. offset: (2) px by which its images lie beside there.
        tracks: of the other cameras, in the whole recording.
        detections, rig: of all cameras, this one as it was calibrated.
    """
    frame, c = tracks.cloud.frame, stretch.camera
    before, during = (_of(tracks, own) for own in (frame < stretch.first, frame >= stretch.first))
    now = put_right(c, offset, during, detections, rig)
    if now is None:
        return None
    was = put_right(c, np.zeros(2), before, detections, rig) or PutRight(rig[c], np.zeros((2, 2)))
    xyz = during.cloud.xyz
    depth = float(np.median(xyz @ now.camera.R[2] + now.camera.t[2]))
    moved = MovedCamera.of(*stretch, was.camera, now.camera, depth)
    left = _left_of(moved, xyz, was.camera, now.camera)
    return PutBack(moved, left.T @ left / len(left) + now.cov + was.cov)  # (2)


def _left_of(moved: MovedCamera, xyz: Floats, was: Camera, now: Camera) -> Floats:
    """(n, 2) px that (1) leaves of points xyz (n, 3) mm, as a camera stood and stands."""
    there, back = (project(replace(one, distortion=np.zeros(5)), xyz) for one in (was, now))
    by_plane = homogeneous(back) @ moved.map.T
    return np.asarray(by_plane[:, :2] / by_plane[:, 2:] - there)


def _of(tracks: Tracks, own: Bools) -> Tracks:
    """Some points (P) of tracks."""
    return Tracks(tracks.cloud.keep(own), tracks.id[own])


def as_calibrated(detections: Detections, rig: Rig, moved: Sequence[MovedCamera]) -> Detections:
    """The same rows, where the cameras as calibrated would have them."""
    if not moved:
        return detections
    uv = detections.uv.copy()
    for one in moved:
        rows = slice(detections.start[one.camera, one.first], detections.start[one.camera, one.stop])
        there = homogeneous(undistort(rig[one.camera], uv[rows])) @ one.map.T
        uv[rows] = distort(rig[one.camera], there[:, :2] / there[:, 2:])
    return replace(detections, uv=uv)
