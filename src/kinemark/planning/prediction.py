"""What cameras at given places will measure: coverage and standard deviation, in the volume and on a walking body.

The standard deviation is that of `calibrate.quality.predicted_covariance`: of the noise of centroids, and of the
calibration as far as a camera states its covariance. The volume is that of a single marker with nobody in the way; on
the body, limbs hide markers and images run together (`sight`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..calibrate.quality import (
    VolumeMap,
    covariance_from,
    joint_of,
    points_of,
    views,
    volume_grid,
)
from ..calibrate.quality.predicted_covariance import CameraViews
from ..calibrate.quality.volume import deviation, largest_axis_deviation, ray_angle
from ..data import Rig
from ..data.array_types import Bools, Floats, Ints
from ..numerics.finite import finite_median
from ..synth import Subject
from .room import Room
from .sight import free_of_limbs, seen_alone, seen_on_bodies


class BodyCoverage(NamedTuple):
    """A walking body of M markers at F instants.

    names (M); views (M, F) how many cameras measure each marker, −1 where it is outside the volume; sd (M, F) mm of one
    axis, NaN with fewer than two; without (C, 2): without each camera, the share of samples that two measure, and the
    median of sd.
    """

    names: tuple[str, ...]
    views: Ints
    sd: Floats
    without: Floats

    def share(self, least: int) -> float:
        """Share of the samples within the volume that at least so many cameras measure; NaN where there are none."""
        inside = self.views >= 0
        return float((self.views[inside] >= least).mean()) if inside.any() else float("nan")


class Prediction(NamedTuple):
    """What a rig will measure: a single marker in the volume, and the markers of a body (None without one)."""

    volume: VolumeMap
    body: BodyCoverage | None


def predict(
    rig: Rig, room: Room, bodies: Sequence[Subject], *, diameter_mm: float, least_px: float, centroid_sd: float
) -> Prediction:
    """What the rig will measure in the room's volume and of bodies in it.

    Args:
        rig: the cameras; their covariances count where they state them.
        room: with the volume.
        bodies: subjects of the same markers, one passage each; none, where only places are asked for.
        diameter_mm: of a marker.
        least_px: diameter of the smallest image that is detected.
        centroid_sd: standard deviation of a centroid along u and v, px.
    """
    return Prediction(_volume(rig, room, diameter_mm, least_px, centroid_sd), _body(rig, bodies, least_px, centroid_sd))


def _volume(rig: Rig, room: Room, diameter_mm: float, least_px: float, centroid_sd: float) -> VolumeMap:
    axes = volume_grid(room.volume)
    shape, xyz = tuple(len(axis) for axis in axes), points_of(axes)
    seen = np.array([seen_alone(camera, xyz, diameter_mm=diameter_mm, least_px=least_px) for camera in rig])
    said, joint = _seen_views(rig, xyz, seen, centroid_sd), joint_of(rig)
    cov = covariance_from(said, joint)
    without = [deviation(covariance_from(said, joint, without=(c,))).reshape(shape) for c in range(len(rig))]
    return VolumeMap(
        axes=axes,
        seen=seen.sum(0).reshape(shape),
        angle=ray_angle(rig, xyz, seen).reshape(shape),
        sd=deviation(cov).reshape(shape),
        sd_largest_axis=largest_axis_deviation(cov).reshape(shape),
        without=np.array(without).reshape(len(rig), *shape),
    )


def _body(rig: Rig, bodies: Sequence[Subject], least_px: float, centroid_sd: float) -> BodyCoverage | None:
    if not bodies:
        return None
    xyz = np.concatenate([body.xyz.reshape(-1, 3) for body in bodies])
    free = [[free_of_limbs(camera.centre, body) for body in bodies] for camera in rig]
    seen = np.array(
        [seen_on_bodies(camera, bodies, own, least_px=least_px) for camera, own in zip(rig, free, strict=True)]
    )
    inside = np.isfinite(xyz).all(1)
    said, joint = _seen_views(rig, np.where(inside[:, None], xyz, 0.0), seen, centroid_sd), joint_of(rig)
    sd = deviation(covariance_from(said, joint))
    without = np.array([_lost(said, joint, inside, c) for c in range(len(rig))])
    views_of = np.where(inside, seen.sum(0), -1)
    return BodyCoverage(bodies[0].names, _by_marker(views_of, bodies), _by_marker(sd, bodies), without)


def _lost(said: CameraViews, joint: Floats, inside: Bools, c: int) -> tuple[float, float]:
    """Share of samples that two cameras measure without camera c, and the median of sd, mm."""
    sd = deviation(covariance_from(said, joint, without=(c,)))[inside]
    return float(np.isfinite(sd).mean()) if len(sd) else np.nan, finite_median(sd)


def _seen_views(rig: Rig, xyz: Floats, seen: Bools, centroid_sd: float) -> CameraViews:
    """`views` of those places only that are seen (C, N)."""
    said = views(rig, xyz, centroid_sd=centroid_sd)
    information, noise, pull = (
        np.where(seen[..., None, None], part, 0.0) for part in (said.information, said.noise, said.pull)
    )
    return CameraViews(information, noise, pull, seen)


def _by_marker(values: NDArray[Any], bodies: Sequence[Subject]) -> NDArray[Any]:
    """(M, F of all bodies) of values that stand body after body (N)."""
    ends = np.cumsum([body.xyz.shape[0] * body.n_frames for body in bodies])[:-1]
    parts = [part.reshape(len(body), -1) for part, body in zip(np.split(values, ends), bodies, strict=True)]
    return np.concatenate(parts, 1)
