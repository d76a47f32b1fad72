"""What a wand's poses say of a calibration that has not seen them.

The poses are cut into blocks of neighbouring frames, since neighbours are nearly the same pose, and the blocks dealt
to so many folds. The bundle is adjusted again without a fold, from where all poses had led; the cameras then
reconstruct the fold's markers, each from its own images as in any trial, and the wand's known lengths and the images
judge them:

    length error = |X_{k+1} − X_k| − (along_{k+1} − along_k)             (1)
    residual     = uv − project(X)                                       (2)

A point takes three of the 2 n coordinates of its n images, so that (2) is smaller than the error of an image by
√((2 n − 3) / 2 n) (3).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import Camera, KinemarkError, Rig
from ...data.array_types import Bools, Floats
from ...geometry import project_all, refine, triangulate
from ...geometry.camera import undistort_all
from ..bundle import Bundle, BundleFit, Freedom, FreePoints, Part, bundle, sticks_through

FOLDS = 3  # parts of the cross-validation; chosen (see studies/calibration_quality.py)
BLOCKS_A_FOLD = 6  # stretches of time in each part; chosen, as neighbouring poses are alike


class LeftOutPoses(NamedTuple):
    """Poses judged by cameras that did not see them: lengths (F, K − 1) mm and residual (C, F, K, 2) px by (2)."""

    lengths: Floats
    residual: Floats


def seen_by(fit: BundleFit, markers: int) -> Floats:
    """(C, F, K, 2) px the images that took part in a fit of poses with so many markers; NaN for the others."""
    uv = np.where(fit.kept[..., None], fit.residual + project_all(fit.rig, fit.xyz), np.nan)
    return uv.reshape(len(fit.rig), -1, markers, 2)


def judge_poses(
    fit: BundleFit, along: Floats, *, method: Bundle, lens_held: bool = False, folds: int = FOLDS
) -> LeftOutPoses:
    """Cross-validation over the poses of a stick, or of a single marker; NaN where nothing can be said.

    Args:
        fit: of all poses, in any world.
        along: (K) mm where the markers are along the stick; (1) for a single marker.
        method: by which it was found.
        lens_held: whether lenses were known beforehand.
        folds: how many.
    """
    uv = seen_by(fit, len(along))
    lengths, residual = np.full((uv.shape[1], len(along) - 1), np.nan), np.full(uv.shape, np.nan)
    for out in folds_of((np.isfinite(uv).all((-1, -2)).sum(0) >= 2), folds):
        if (again := refitted(fit, along, ~out, method, lens_held)) is None:  # too few poses without the fold
            continue
        xyz, misfit = reconstructed(again.rig, uv[:, out])
        lengths[out], residual[:, out] = np.linalg.norm(np.diff(xyz, axis=1), axis=-1), misfit
    return LeftOutPoses(lengths, residual)


def refitted(fit: BundleFit, along: Floats, poses: Bools, method: Bundle, lens_held: bool) -> BundleFit | None:
    """The bundle again, of some poses (F) and the images that took part in a fit of all; None where they are too few.

    The rest as in `judge_poses`.
    """
    uv = seen_by(fit, len(along))
    places = fit.xyz.reshape(uv.shape[1], len(along), 3)
    known = poses & np.isfinite(places).all((1, 2))
    part: Part = sticks_through(places[known], along) if len(along) > 1 else FreePoints(places[known, 0])
    freedoms = tuple(freedom_of(camera, method, lens_held) for camera in fit.rig)
    flat = uv[:, known].reshape(len(uv), -1, 2)
    try:
        return bundle(fit.rig, [part], flat, freedoms=freedoms, method=replace(method, reject=np.inf))
    except KinemarkError:
        return None


def freedom_of(camera: Camera, method: Bundle, lens_held: bool) -> Freedom:
    """What the bundle fitted in a camera: where a lens was known beforehand, pose and focal length."""
    if not lens_held:
        return method.freedom
    free = np.zeros(len(camera.cov), np.bool_)
    free[[0, 1]] = camera.cov[0, 0] > 0
    free[9:] = True
    return Freedom(free, True, True)


def folds_of(usable: Bools, folds: int) -> list[Bools]:
    """(F) masks, one a fold, that share the usable frames (F) out by blocks."""
    frames = np.flatnonzero(usable)
    block = np.arange(len(frames)) * folds * BLOCKS_A_FOLD // max(len(frames), 1)
    masks = np.zeros((folds, len(usable)), np.bool_)
    masks[block % folds, frames] = True
    return list(masks)


def reconstructed(rig: Rig, uv: Floats) -> tuple[Floats, Floats]:
    """Markers (F, K, 3) mm seen at (C, F, K, 2) px, each by itself, and their residuals (C, F, K, 2) px by (2)."""
    c, f, k, _ = uv.shape
    seen = uv.reshape(c, f * k, 2).transpose(1, 0, 2)
    ideal = undistort_all(rig, seen)
    alike = np.broadcast_to(np.eye(2), (*seen.shape, 2))
    point = refine(rig.as_known(), triangulate(ideal, rig.P), seen, alike, steps=2)
    return point.xyz.reshape(f, k, 3), point.residual.transpose(1, 0, 2).reshape(uv.shape)


def image_errors(residual: Floats) -> Floats:
    """Lengths (C, N) px of residuals (C, N, 2), enlarged by (3) to those of the images; NaN for fewer than two."""
    n = np.isfinite(residual[..., 0]).sum(0)
    enlarged = np.sqrt(2 * n / np.where(n >= 2, 2 * n - 3, np.nan))
    return np.linalg.norm(residual, axis=-1) * enlarged
