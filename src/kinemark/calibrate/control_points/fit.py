"""Cameras from control points, markers whose places in the laboratory were surveyed (UM²AS 2.3.3, 2.4, B).

Each camera is fitted by itself (`camera`). The centroid of a sphere's image is not the image of its centre
(`geometry.sphere_offset`), by an offset that depends on the camera sought; so cameras and offsets are found in turn,
the offsets from the cameras before (1). Twice is enough, as an offset is a small part of a pixel and a change of the
camera that it brings a still smaller part.

`control_point_quality` gives besides what a judgement of the calibration needs (`judgement`): residuals of all points,
and their errors in images and in space where they took no part (`left_out`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...data import Camera, Finding, KinemarkError, Rig
from ...data.array_types import Bools, Floats, Ints
from ...geometry import camera_about, origin_near, project, sphere_offset
from .checks import check_extent, check_points, labels
from .fit_camera import CameraMethod, ControlPoints, Dlt, FittedCamera, fit_camera, free_parameters
from .left_out import leave_one_out
from .mistaken import mistaken_points
from .shared_survey import with_shared_survey

__all__ = [
    "CameraMethod",
    "ControlFit",
    "ControlPoints",
    "Dlt",
    "calibrate_control_points",
    "control_point_quality",
    "fit_camera",
    "free_parameters",
]

CORRECTIONS = 2
"""Rounds in which spheres' centroids are corrected; chosen: the second changes next to nothing (see
studies/calibration_quality.py)."""


class ControlFit(NamedTuple):
    """A rig of C cameras and the N control points that it was calibrated from.

    Attributes:
        rig: the cameras.
        points: (N) the points' names.
        xyz: (N, 3) where they were surveyed, mm.
        uv: (C, N, 2) their centres as seen, px; NaN where not seen.
        cov: (C, N, 2, 2) covariance of `uv`, px², right in proportion; the same for all where nothing states it.
        stated: (C) whether `cov` was stated.
        residual: (C, N, 2) seen minus reprojected, px, whether or not the point took part; NaN where not seen.
        kept: (C, N) which took part.
        left_out_error: (C, N, 2) the same, px, of the camera fitted without the point; NaN where that is no camera.
        left_out_xyz: (N, 3) mm, the point reconstructed from cameras that were all fitted without it, minus its
            survey; NaN where fewer than two see it. Images that did not take part count only for points that
            fewer than two cameras kept.
        left_out_cov: (N, 3, 3) mm², what the cameras' own residuals let expect of it.
        freedom: (C) equations more than parameters.
        method: by which the cameras were fitted.
        lenses: the linearised cameras, where they were given.
    """

    rig: Rig
    points: tuple[str, ...]
    xyz: Floats
    uv: Floats
    cov: Floats
    stated: Bools
    residual: Floats
    kept: Bools
    left_out_error: Floats
    left_out_xyz: Floats
    left_out_cov: Floats
    freedom: Ints
    method: CameraMethod
    lenses: tuple[Camera, ...] | None


def calibrate_control_points(
    names: Sequence[str],
    sizes: ArrayLike,
    xyz: Floats,
    uv: Floats,
    *,
    cov: Floats | None = None,
    method: CameraMethod | None = None,
    lenses: Sequence[Camera] | None = None,
    diameter: float | None = None,
    points: Sequence[str] | None = None,
) -> Rig:
    """Cameras of these names and image sizes (C, 2) px from N control points.

    Args:
        names: (C).
        sizes: (C, 2) width and height, px; (0, 0) where unknown.
        xyz: (N, 3) places of the points, mm; a point without one takes no part.
        uv: (C, N, 2) where each camera sees them, px; NaN where it does not.
        cov: (C, N, 2, 2) covariance of `uv`, px², right in proportion; without it, or where it is NaN for a point
            that a camera sees, all points of that camera count alike.
        method: what to fit, `ControlPoints` or `Dlt`.
        lenses: (C) linearised cameras. Their lens terms and principal points are kept as they are in pixels, and
            so is the ratio of focal lengths; the focal length itself and the pose are found.
        diameter: of the markers where they are spheres, mm: their centroids are corrected for perspective.
        points: (N) names of the points for messages; their numbers from 1 without.

    Returns:
        The rig, with covariances and residuals; its volume is the box around the points.

    Raises:
        ValueError: the arrays do not fit each other, or lenses were given for `Dlt`.
        KinemarkError: a camera sees fewer than six points, or points that repeat or lie in a plane, or too few that
            fit together; or the places are not in mm.
    """
    fits, centres, spread = _fits(names, sizes, xyz, uv, cov, method, lenses, diameter, labels(points, len(xyz)))
    return _rig(fits, centres, spread, xyz)


def control_point_quality(
    names: Sequence[str],
    sizes: ArrayLike,
    xyz: Floats,
    uv: Floats,
    *,
    cov: Floats | None = None,
    method: CameraMethod | None = None,
    lenses: Sequence[Camera] | None = None,
    diameter: float | None = None,
    points: Sequence[str] | None = None,
) -> ControlFit:
    """The rig of `calibrate_control_points`, with residuals and errors of points left out; arguments as there."""
    called = labels(points, len(xyz))
    fits, centres, spread = _fits(names, sizes, xyz, uv, cov, method, lenses, diameter, called)
    stated = np.array([cov is not None and _stated(cov[c][f.kept]) for c, f in enumerate(fits)], np.bool_)
    held = tuple(lenses) if lenses is not None else None
    return _examined(fits, called, xyz, centres, spread, stated, method or ControlPoints(), held)


def refitted(fit: ControlFit, *, without: Bools) -> ControlFit:
    """The calibration again without some of the points (N), and how well it sees them."""
    uv = np.where(without[:, None], np.nan, fit.uv)
    cov = np.where(fit.stated[:, None, None, None], fit.cov, np.nan)
    sizes = [camera.size for camera in fit.rig]
    method = replace(fit.method, reject=np.inf)
    fits, _, _ = _fits(fit.rig.names, sizes, fit.xyz, uv, cov, method, fit.lenses, None, fit.points)
    return _examined(fits, fit.points, fit.xyz, fit.uv, fit.cov, fit.stated, method, fit.lenses)


def _examined(
    fits: list[FittedCamera],
    points: tuple[str, ...],
    xyz: Floats,
    uv: Floats,
    cov: Floats,
    stated: Bools,
    method: CameraMethod,
    lenses: tuple[Camera, ...] | None,
) -> ControlFit:
    local = xyz - origin_near(xyz)
    left = leave_one_out(fits, local, uv, cov, method=method)
    return ControlFit(
        rig=_rig(fits, uv, cov, xyz),
        points=points,
        xyz=xyz,
        uv=uv,
        cov=cov,
        stated=stated,
        residual=uv - np.stack([project(f.camera, local) for f in fits]),
        kept=np.stack([f.kept for f in fits]),
        left_out_error=left.error,
        left_out_xyz=left.xyz,
        left_out_cov=left.cov,
        freedom=np.array([f.freedom for f in fits], np.int64),
        method=method,
        lenses=lenses,
    )


def _fits(
    names: Sequence[str],
    sizes: ArrayLike,
    xyz: Floats,
    uv: Floats,
    cov: Floats | None,
    method: CameraMethod | None,
    lenses: Sequence[Camera] | None,
    diameter: float | None,
    points: tuple[str, ...],
) -> tuple[list[FittedCamera], Floats, Floats]:
    """Each camera about `origin_near` of the points, with `kept` over all N of them; the centres (C, N, 2) px that it
    was fitted to, and their weights."""
    sizes = np.asarray(sizes, np.int64).reshape(-1, 2)
    _check_shapes(names, sizes, xyz, uv, cov, lenses)
    method = method or ControlPoints()
    if lenses is not None and isinstance(method, Dlt):
        raise ValueError("lenses were given for Dlt, whose principal point is its own; wanted ControlPoints")
    check_extent(xyz)
    fits, local = [], xyz - origin_near(xyz)
    centres = np.where(np.isfinite(xyz.sum(1))[:, None] & np.isfinite(uv.sum(-1, keepdims=True)), uv, np.nan)
    spread = np.tile(np.eye(2), (*uv.shape[:2], 1, 1))
    for c, name in enumerate(names):
        seen = np.isfinite(centres[c, :, 0])
        if cov is not None and _stated(cov[c][seen]):
            spread[c, seen] = cov[c, seen]
        here = [point for point, s in zip(points, seen, strict=True) if s]
        lens = lenses[c] if lenses is not None else None
        try:
            check_points(xyz[seen], centres[c, seen], here)
        except KinemarkError as error:
            raise KinemarkError(f"Camera {name}: {error}") from None
        try:
            fitted, centres[c, seen] = _corrected_fit(
                name, sizes[c], local[seen], centres[c, seen], spread[c, seen], method, lens, diameter
            )
        except KinemarkError as error:
            mistaken = mistaken_points(xyz[seen], centres[c, seen], here, camera=name)
            raise _unfitted(name, error, mistaken) from None
        kept = seen.copy()
        kept[seen] = fitted.kept
        fits.append(fitted._replace(kept=kept))
    return fits, centres, spread


def _unfitted(name: str, error: KinemarkError, mistaken: Finding | None) -> KinemarkError:
    """The error of a camera that does not fit, with the points that may be to blame."""
    if mistaken is None:
        return KinemarkError(f"Camera {name}: {error}")
    points = mistaken.values.get("points_list") or (mistaken.values["point"],)
    assert isinstance(points, tuple)
    return KinemarkError(
        f"Camera {name}: {error} Check control points {', '.join(map(str, points))}.", findings=[mistaken]
    )


def _corrected_fit(
    name: str,
    size: Ints,
    xyz: Floats,
    uv: Floats,
    cov: Floats,
    method: CameraMethod,
    lens: Camera | None,
    diameter: float | None,
) -> tuple[FittedCamera, Floats]:
    """A camera and the centres (N, 2) px of the spheres that it sees at `uv`, by (1)."""
    fitted, centres = fit_camera(name, size, xyz, uv, cov, method=method, lens=lens), uv
    for _ in range(CORRECTIONS if diameter is not None and np.isfinite(diameter) else 0):
        assert diameter is not None
        centres = uv - sphere_offset(fitted.camera, xyz, diameter=diameter)
        fitted = fit_camera(name, size, xyz, centres, cov, method=method, lens=lens)
    return fitted, centres


def _rig(fits: list[FittedCamera], centres: Floats, spread: Floats, xyz: Floats) -> Rig:
    known = xyz[np.isfinite(xyz).all(1)]
    volume = np.stack([known.min(0), known.max(0)]) if len(known) else np.full((2, 3), np.nan)
    out = (np.isfinite(centres[..., 0]).sum(1) - np.array([f.kept.sum() for f in fits], int)) if fits else []
    left_out = [f"{f.camera.name} {n}" for f, n in zip(fits, out, strict=True) if n]
    linear = all(f.parameters == 11 and not f.free.any() for f in fits)
    words = f"control points: {'DLT' if linear else 'DLT and least squares'}, {len(known)} points"
    words += "; lenses as linearised" if any(f.tied for f in fits) else ""
    words += f"; left out: {', '.join(left_out)}" if left_out else ""
    origin = origin_near(xyz)
    cameras = with_shared_survey(fits, xyz - origin, centres, spread)
    return Rig(tuple(camera_about(camera, -origin) for camera in cameras), words, volume)


def _stated(cov: Floats) -> bool:
    """Whether the covariance (n, 2, 2) is known for all points."""
    return bool(len(cov) and np.isfinite(cov).all())


def _check_shapes(
    names: Sequence[str], sizes: Ints, xyz: Floats, uv: Floats, cov: Floats | None, lenses: Sequence[Camera] | None
) -> None:
    c, n = len(names), len(xyz)
    found = {"sizes": (sizes.shape, (c, 2)), "xyz": (xyz.shape, (n, 3)), "uv": (uv.shape, (c, n, 2))}
    if cov is not None:
        found["cov"] = (cov.shape, (c, n, 2, 2))
    if lenses is not None:
        found["lenses"] = ((len(lenses),), (c,))
    for what, (have, want) in found.items():
        if have != want:
            raise ValueError(f"{what} has shape {have}, wanted {want} for {c} cameras and {n} points")
