"""How well cameras see control points that took no part in their calibration.

The least squares of a camera with residuals r, derivatives J_i and covariances Q_i of its points has the normal matrix
A = Σ J_iᵀ Q_i⁻¹ J_i. Without point i its parameters change by

    δ = −A⁻¹ J_iᵀ (Q_i − M_i)⁻¹ r_i,    M_i = J_i A⁻¹ J_iᵀ               (1)

which is exact where the projection is linear (Cook & Weisberg 1982, 2.2), and the camera so moved misses the point by
its error left out, e_i (2), whose covariance is, with s² = χ² / ν,

    C_i = s² Q_i (Q_i − M_i)⁻¹ Q_i,    or s² (Q_i + M_i) for a point that took no part        (3)

The leverage h_i, the largest eigenvalue of Q_i⁻¹ M_i, is 1 where no other point tells what i does: then the error is
unknown (4). Where it exceeds `LEVERAGE` the step is so long that the projection's curvature may count, and a few steps
of the fit itself follow (5): below it (1) is within 1 % of fitting anew, and in calibrations as bad as 10 px mostly
within 3 %. The eleven parameters of the DLT are found anew from its equations less the two of the point, 12 × 12 (6).

In space, a point is reconstructed from the cameras that were all fitted without it, as any marker will be. Such a
camera sees the place x_i at e_i from the image, so that all the points are found at once, by all points' cameras, from
the images project(x_i) + e_i with covariances C_i (7). Images that were left out of the fit take part only where fewer
than two others would: then they all were, and the question is where the cameras see the point together (8).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Rig
from ...data.array_types import Floats
from ...geometry import parameter_jacobian, project, refine, triangulate, undistort
from ...geometry.dlt import equations
from ...numerics.scaled import scaled_inverse
from ..resection import directions, moved, resect
from .checks import FEWEST
from .fit_camera import POSE_AND_FOCUS, CameraMethod, Dlt, FittedCamera

LEVERAGE = 0.5
"""Of 1, above which a point left out is solved anew; chosen: the linear step is then some 3 % off (see
studies/calibration_quality.py)."""
STEPS = 8  # tries from a start that is near; chosen (see studies/calibration_quality.py)
SINGULAR = 1e-6  # below 1; a leverage so near 1 leaves nothing without the point; conventional
MOST = 0.98  # leverage at most in 1 / (1 − h); chosen, lest one point outweigh all (see studies/calibration_quality.py)


class LeftOutPoints(NamedTuple):
    """Errors of points that took no part: error (C, N, 2) px, seen minus reprojected; xyz (N, 3) mm, found minus known.

    cov (N, 3, 3) mm² is what the cameras expect of `xyz`.
    """

    error: Floats
    xyz: Floats
    cov: Floats


def leave_one_out(
    fits: list[FittedCamera], xyz: Floats, uv: Floats, cov: Floats, *, method: CameraMethod
) -> LeftOutPoints:
    """Each of N points by C cameras fitted without it; NaN where unseen, or where the others determine no camera.

    Args:
        fits: the cameras and what was free in them, `kept` over all N points.
        xyz: (N, 3) mm.
        uv: (C, N, 2) px, NaN where not seen.
        cov: (C, N, 2, 2) px².
        method: by which they were fitted.
    """
    error, spread = np.full(uv.shape, np.nan), np.full(cov.shape, np.nan)
    for c, fitted in enumerate(fits):
        rows = np.flatnonzero(np.isfinite(uv[c]).all(1) & np.isfinite(xyz).all(1))
        here = fitted._replace(kept=fitted.kept[rows])
        error[c, rows], spread[c, rows] = errors_without(here, xyz[rows], uv[c, rows], cov[c, rows], method=method)
    taken = np.stack([f.kept for f in fits])
    known = np.isfinite(error[..., 0]) & (taken | (taken.sum(0) < 2))  # (8)
    rig = Rig(tuple(f.camera for f in fits)).as_known()  # (3) has their share already
    images = np.stack([project(camera, xyz) for camera in rig]) + error
    images[~known] = np.nan
    ideal = np.stack([undistort(camera, image) for camera, image in zip(rig, images, strict=True)], 1)
    start = triangulate(ideal, rig.P)
    found = refine(rig, start, images.transpose(1, 0, 2), spread.transpose(1, 0, 2, 3))  # (7)
    return LeftOutPoints(error, found.xyz - xyz, found.cov)


def errors_without(
    fitted: FittedCamera, xyz: Floats, uv: Floats, cov: Floats, *, method: CameraMethod
) -> tuple[Floats, Floats]:
    """Of points (n, 3) mm that a camera sees at (n, 2) px: errors (n, 2) px and covariances (n, 2, 2) px², (2), (3)."""
    kept, camera, linear = fitted.kept, fitted.camera, isinstance(method, Dlt)
    root = np.linalg.cholesky(cov)
    whiten = np.linalg.inv(root)
    B = np.eye(15)[:, list(POSE_AND_FOCUS)] if linear else directions(camera, fitted.free, fitted.tied)
    J = whiten @ parameter_jacobian(camera, xyz) @ B  # (n, 2, p)
    used = J[kept].reshape(-1, B.shape[1])
    inverse = scaled_inverse(used.T @ used) * (fitted.parameters / B.shape[1])  # `camera` (3)
    H = J @ inverse @ J.transpose(0, 2, 1)
    error = uv - project(camera, xyz)
    r = np.einsum("nij,nj->ni", whiten, error)
    if kept.sum() <= FEWEST:
        error[kept] = np.nan
    elif linear:
        error[kept] = _dlt_errors(xyz[kept], uv[kept])
    else:
        error[kept] = _refined_errors(fitted, xyz, uv, cov, r, J, inverse, H)
    nu = fitted.freedom
    scale = float((r[kept] ** 2).sum()) / max(nu, 1) * max(nu, 3) / (max(nu, 3) - 2)
    values, vectors = np.linalg.eigh(H)
    values = np.where(kept[:, None], 1 / (1 - np.minimum(values, MOST)), 1 + values)
    factor = root @ vectors
    return error, max(scale, 1e-12) * (factor * values[:, None]) @ factor.transpose(0, 2, 1)  # (3)


def _refined_errors(
    fitted: FittedCamera, xyz: Floats, uv: Floats, cov: Floats, r: Floats, J: Floats, inverse: Floats, H: Floats
) -> Floats:
    """(2) of the kept points."""
    camera, free, tied = fitted.camera, fitted.free, fitted.tied
    leverage = np.linalg.eigvalsh(H)[:, -1]
    errors = []
    for i in np.flatnonzero(fitted.kept):
        if leverage[i] > 1 - SINGULAR:  # (4)
            errors.append(np.full(2, np.nan))
            continue
        step = -inverse @ J[i].T @ np.linalg.solve(np.eye(2) - H[i], r[i])  # (1)
        other = moved(camera, free, step, tied=tied)
        if leverage[i] > LEVERAGE:  # (5)
            rest = fitted.kept & (np.arange(len(xyz)) != i)
            other = resect(other, xyz[rest], uv[rest], cov[rest], free=free, tied=tied, steps=STEPS).camera
        errors.append(uv[i] - project(other, xyz[i]))
    return np.array(errors)


def _dlt_errors(xyz: Floats, uv: Floats) -> Floats:
    """(2) by (6)."""
    A, T, U = equations(xyz, uv)
    each = A.transpose(0, 2, 1) @ A
    _, vectors = np.linalg.eigh(each.sum(0) - each)
    P = np.linalg.inv(U) @ vectors[..., 0].reshape(-1, 3, 4) @ T
    x = np.einsum("nij,nj->ni", P, np.column_stack([xyz, np.ones(len(xyz))]))
    return np.asarray(uv - x[:, :2] / x[:, 2:])
