"""One camera from points with known places: least squares over the camera's own parameters.

With r_i the residual of point i (px), Q_i its covariance and J_i the derivative of its projection by the p
free ones of `data.PARAMETERS`, Levenberg and Marquardt's step

    (A + λ diag A) δ = g,    A = Σ J_iᵀ Q_i⁻¹ J_i,    g = Σ J_iᵀ Q_i⁻¹ r_i    (1)

lowers χ² = Σ r_iᵀ Q_i⁻¹ r_i (2) until it no longer falls. The parameters' covariance is

    Σ = A⁻¹ · χ² / ν · ν / (ν − 2),    ν = 2 n − p                        (3)

χ² / ν measures how much larger the true errors are than Q says, which need only be right in proportion. It is
itself uncertain: an error divided by its root is distributed as t with ν degrees of freedom, whose
variance is ν / (ν − 2), so the last factor keeps the stated variance true on average when points are few. For ν
below 3 that variance does not exist, and the factor stays at that of ν = 3.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..data import Camera
from ..geometry import parameter_jacobian, project

STEPS = 100


class Fit(NamedTuple):
    """A fitted camera, its residuals r (N, 2) px, and d (N), their lengths in units of their standard deviation."""

    camera: Camera
    residual: NDArray[np.float64]
    normalised: NDArray[np.float64]


def resect(
    start: Camera,
    xyz: NDArray[np.float64],
    uv: NDArray[np.float64],
    cov: NDArray[np.float64],
    *,
    free: NDArray[np.bool_],
    steps: int = STEPS,
) -> Fit:
    """The camera near `start` that sees points (N, 3) mm at pixels (N, 2) of covariance (N, 2, 2).

    `free` (15) tells which of `data.PARAMETERS` may change. `Camera.cov` and `Camera.residual` are set. Where `start`
    has points behind it, it is returned as it is, with residuals of NaN.
    """
    whiten = np.linalg.inv(np.linalg.cholesky(cov))  # whiten · r has unit covariance
    camera, chi2, damping = start, _chi2(start, xyz, uv, whiten), 1e-3
    for _ in range(steps if np.isfinite(chi2) else 0):
        A, g = _normal(camera, xyz, uv, whiten, free)
        step = np.asarray(np.linalg.lstsq(A + damping * np.diag(np.diag(A)), g)[0], np.float64)  # (1)
        tried = moved(camera, free, step)
        lower = _chi2(tried, xyz, uv, whiten)
        if lower < chi2:
            settled = chi2 - lower <= 1e-13 * chi2
            camera, chi2, damping = tried, lower, damping / 10
            if settled:
                break
        elif damping > 1e8:
            break
        else:
            damping *= 10
    residual = uv - project(camera, xyz)
    if not np.isfinite(chi2):
        return Fit(camera, residual, np.full(len(xyz), np.nan))
    A, _ = _normal(camera, xyz, uv, whiten, free)
    camera = replace(
        camera,
        cov=_covariance(A, chi2, 2 * len(xyz), free),
        residual=float(np.sqrt((residual**2).sum(1).mean())),
    )
    return Fit(camera, residual, np.linalg.norm(np.einsum("nij,nj->ni", whiten, residual), axis=1))


def moved(camera: Camera, free: NDArray[np.bool_], step: NDArray[np.float64]) -> Camera:
    """The camera with `step` added to its free parameters."""
    p = np.zeros(15)
    p[free] = step
    K = camera.K.copy()
    K[0, 0], K[1, 1] = K[0, 0] + p[0], K[1, 1] + p[1]
    K[:2, 2] += p[2:4]
    R = Rotation.from_rotvec(p[9:12]).as_matrix() @ camera.R
    return replace(camera, K=K, distortion=camera.distortion + p[4:9], R=R, t=camera.t + p[12:])


def _chi2(camera: Camera, xyz: NDArray[np.float64], uv: NDArray[np.float64], whiten: NDArray[np.float64]) -> float:
    """(2); infinite where a point lies behind the camera."""
    d = np.einsum("nij,nj->ni", whiten, uv - project(camera, xyz))
    total = float((d**2).sum())
    return total if np.isfinite(total) else float("inf")


def _normal(
    camera: Camera,
    xyz: NDArray[np.float64],
    uv: NDArray[np.float64],
    whiten: NDArray[np.float64],
    free: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A (p, p) and g (p) of (1)."""
    J = (whiten @ parameter_jacobian(camera, xyz)[..., free]).reshape(2 * len(xyz), -1)
    r = np.einsum("nij,nj->ni", whiten, uv - project(camera, xyz)).ravel()
    return J.T @ J, J.T @ r


def _covariance(A: NDArray[np.float64], chi2: float, n: int, free: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(15, 15) with zero rows for what is held, from n equations."""
    scale = 1 / np.sqrt(np.maximum(np.diag(A), 1e-300))  # the parameters differ by 10⁸ in size
    inverse = scale[:, None] * np.linalg.pinv(A * scale * scale[:, None], hermitian=True) * scale
    nu = n - int(free.sum())
    cov = np.zeros((15, 15))
    cov[np.ix_(free, free)] = inverse * chi2 / max(nu, 1) * max(nu, 3) / (max(nu, 3) - 2)  # (3)
    return cov
