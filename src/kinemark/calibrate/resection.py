"""One camera from points with known places: least squares over the camera's own parameters.

With r_i the residual of point i (px), Q_i its covariance and J_i the derivative of its projection by the p
free ones of `data.PARAMETERS`, Levenberg–Marquardt (`numerics.levenberg_marquardt`) with

    A = Σ J_iᵀ Q_i⁻¹ J_i,    g = Σ J_iᵀ Q_i⁻¹ r_i                         (1)

lowers χ² = Σ r_iᵀ Q_i⁻¹ r_i (2) until it no longer falls. The parameters' covariance is

    Σ = A⁻¹ · χ² / ν · ν / (ν − 2),    ν = 2 n − p                        (3)

χ² / ν measures how much larger the true errors are than Q says, which need only be right in proportion. It is
itself uncertain, so the last factor keeps the stated variance true on average when points are few. For ν below 3 it is
another (`numerics.small_sample`).

The lens of a linearised camera is known in pixels, and its focal length is not. With f ← m f for both focal lengths and

    k1 ← m² k1,   k2 ← m⁴ k2,   p1 ← m p1,   p2 ← m p2,   k3 ← m⁶ k3      (4)

the lens bends pixels as before, since x ← x / m on the normalised plane. Then ln m takes the place of fx and fy:
`tied`. What the linearisation itself leaves open, Σ_L of the held parameters, moves the fitted ones along, by
(B A⁻¹ Bᵀ Jᵀ Q⁻¹ J − 1) δ_L (5), with B = ∂ parameters / ∂ free ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from ..data import Camera
from ..data.array_types import Bools, Floats
from ..geometry import parameter_jacobian, project
from ..numerics.levenberg_marquardt import damped_step, minimise
from ..numerics.scaled import scaled_inverse
from ..numerics.small_sample import variance_factor

STEPS = 100  # tries at most; chosen, more than DLT starts take
SETTLED = 1e-13  # share of χ²; conventional: some hundred roundings
FOCAL_POWERS = np.array([1.0, 1, 0, 0, 2, 4, 1, 1, 6, 0, 0, 0, 0, 0, 0])
"""Of m in each of `data.PARAMETERS`, (4); by definition."""


class ResectionFit(NamedTuple):
    """A fitted camera, its residuals r (N, 2) px, and d (N), their lengths in units of their standard deviation."""

    camera: Camera
    residual: Floats
    normalised: Floats


def resect(
    start: Camera,
    xyz: Floats,
    uv: Floats,
    cov: Floats,
    *,
    free: Bools,
    tied: bool = False,
    steps: int = STEPS,
) -> ResectionFit:
    """The camera near `start` that sees points (N, 3) mm at pixels (N, 2) of covariance (N, 2, 2).

    `free` (15) tells which of `data.PARAMETERS` may change; where `tied`, the focal lengths do by (4), and `start.cov`
    is that of the held lens. `Camera.cov` and `Camera.residual` are set. Where `start`
    has points behind it, it is returned as it is, with residuals of NaN.
    """
    whiten = np.linalg.inv(np.linalg.cholesky(cov))  # whiten · r has unit covariance
    problem = _Resection(xyz, uv, whiten, free, tied)
    camera = minimise(problem, start, steps=steps, relative=SETTLED)
    residual, chi2 = uv - project(camera, xyz), problem.cost(camera)
    if not np.isfinite(chi2):
        return ResectionFit(camera, residual, np.full(len(xyz), np.nan))
    camera = replace(
        camera,
        cov=_covariance(camera, start, xyz, whiten, chi2, free, tied),
        residual=float(np.sqrt((residual**2).sum(1).mean())),
    )
    return ResectionFit(camera, residual, np.linalg.norm(np.einsum("nij,nj->ni", whiten, residual), axis=1))


def directions(camera: Camera, free: Bools, tied: bool) -> Floats:
    """B (15, p): how `data.PARAMETERS` change with the free ones, or with ln m and the rest of them."""
    if not tied:
        return np.eye(15)[:, free]
    values = np.concatenate([[camera.K[0, 0], camera.K[1, 1], 0, 0], camera.distortion, np.zeros(6)])
    rest = free.copy()
    rest[:9] = False
    return np.column_stack([FOCAL_POWERS * values, np.eye(15)[:, rest]])


def moved(camera: Camera, free: Bools, step: Floats, *, tied: bool = False) -> Camera:
    """The camera with `step` (n) added to its free parameters (15); where `tied`, the first is ln m."""
    p, K, distortion = np.zeros(15), camera.K.copy(), camera.distortion
    if tied:
        m = np.exp(np.clip(step[0], -1, 1))  # no step changes the focal length more than e times
        K[:2, :2] *= m
        distortion = distortion * m ** FOCAL_POWERS[4:9]  # (4)
        p[9:][free[9:]] = step[1:]
    else:
        p[free] = step
        K[0, 0], K[1, 1] = K[0, 0] + p[0], K[1, 1] + p[1]
        K[:2, 2] += p[2:4]
    R = scipy.spatial.transform.Rotation.from_rotvec(p[9:12]).as_matrix() @ camera.R
    return replace(camera, K=K, distortion=distortion + p[4:9], R=R, t=camera.t + p[12:])


@dataclass(frozen=True, slots=True)
class _Resection:
    """The problem of `resect` for `minimise`."""

    xyz: Floats
    uv: Floats
    whiten: Floats
    free: Bools
    tied: bool

    def cost(self, camera: Camera) -> float:
        """(2); infinite where a point lies behind the camera."""
        d = np.einsum("nij,nj->ni", self.whiten, self.uv - project(camera, self.xyz))
        total = float((d**2).sum())
        return total if np.isfinite(total) else float("inf")

    def equations(self, camera: Camera) -> tuple[Floats, Floats]:
        """A (p, p) and g (p) of (1)."""
        B = directions(camera, self.free, self.tied)
        J = (self.whiten @ parameter_jacobian(camera, self.xyz) @ B).reshape(2 * len(self.xyz), -1)
        r = np.einsum("nij,nj->ni", self.whiten, self.uv - project(camera, self.xyz)).ravel()
        return J.T @ J, J.T @ r

    def step(self, camera: Camera, equations: tuple[Floats, Floats], damping: float) -> tuple[Camera, float]:
        """The camera after the step δ."""
        step, predicted = damped_step(*equations, damping)
        return moved(camera, self.free, step, tied=self.tied), predicted


def _covariance(
    camera: Camera,
    start: Camera,
    xyz: Floats,
    whiten: Floats,
    chi2: float,
    free: Bools,
    tied: bool,
) -> Floats:
    """(15, 15) with zero rows for what is held and known."""
    J = (whiten @ parameter_jacobian(camera, xyz)).reshape(-1, 15)
    B = directions(camera, free, tied)
    inverse = scaled_inverse(B.T @ J.T @ J @ B)
    nu = len(J) - B.shape[1]
    cov = B @ inverse @ B.T * (chi2 / max(nu, 1) * variance_factor(nu))  # (3)
    if tied and start.cov.any():
        along = B @ inverse @ B.T @ J.T @ J - np.eye(15)  # (5)
        cov = cov + along @ lens_covariance(start, camera) @ along.T
    return np.asarray(cov)


def lens_covariance(lens: Camera, camera: Camera) -> Floats:
    """(15, 15) of the held parameters of `camera`, as its linearised `lens` left them open; that of ln m is taken out.

    An error of the lens's own focal length, d ln f, does not move its pixels if the terms follow by (4), so that only
    δk − power · k · d ln f counts, and of fx and fy what sets them apart.
    """
    f = np.array([lens.K[0, 0], lens.K[1, 1]])
    values = np.concatenate([f, [0, 0], lens.distortion, np.zeros(6)])
    mean_focal = np.zeros(15)
    mean_focal[:2] = 0.5 / f
    m = float(np.mean([camera.K[0, 0], camera.K[1, 1]] / f))
    T = (m**FOCAL_POWERS)[:, None] * (np.eye(15) - np.outer(FOCAL_POWERS * values, mean_focal))
    T[9:] = 0.0
    return np.asarray(T @ lens.cov @ T.T)
