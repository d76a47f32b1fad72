"""Least squares over all cameras and all points at once: Levenberg and Marquardt's method with the Schur complement.

With r the residual of one image point (px, divided by its standard deviation), A its derivative by the q free
parameters of the camera and B by the D of the piece it belongs to, the normal equations are

    [U  W ] [δ]   [g]      U = Σ AᵀA,  V = Σ BᵀB,  W = Σ AᵀB
    [Wᵀ V ] [ε] = [h]      g = Σ Aᵀr,  h = Σ Bᵀr                          (1)

V has one D × D block a piece, so that ε leaves (1) at little cost (Brown 1958; Triggs et al. 2000, section 6.1):

    (U − W V⁻¹ Wᵀ) δ = g − W V⁻¹ h,   ε = V⁻¹ (h − Wᵀ δ)                 (2)

with U and V enlarged by λ times their diagonals. A step is taken where it lowers

    Σ ρ(|r|²),   ρ = |r|²,  or  c² ln(1 + |r|²/c²)                       (3)

the second (Cauchy's) for as long as points may be wrong; there each r, A and B is multiplied by √ρ' (4).

A camera's free parameters act through a matrix T, d parameters = T δ: a unit vector each (5), but where pixels keep
their shape fy follows fx (6), and where the lens is held in pixels its terms follow the focal length, k_n ∝ f²ⁿ and
p ∝ f (7), since x = px / f.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import Camera
from ...data.array_types import Bools, Floats
from ...geometry import parameter_jacobian, project
from ..resection import moved
from .parts import Part, all_points, complete, slices

STEPS = 200
SETTLED = 1e-7
FARTHEST = 1e9
POWERS = np.array([2.0, 4.0, 1.0, 1.0, 6.0])
EVERYTHING = np.ones(15, np.bool_)


class Freedom(NamedTuple):
    """What may change in a camera: free (15) of `data.PARAMETERS`; fy with fx (6); the lens with the focus (7)."""

    free: Bools
    square: bool = True
    lens_in_pixels: bool = False

    def columns(self, camera: Camera) -> Floats:
        """T (15, q)."""
        T = np.diag(self.free.astype(np.float64))  # (5)
        if self.square and self.free[0]:
            T[1, 0], T[1, 1] = camera.K[1, 1] / camera.K[0, 0], 0.0  # (6)
        if self.lens_in_pixels and self.free[0]:
            T[4:9, 0] = POWERS * camera.distortion / camera.K[0, 0]  # (7)
        return T[:, np.abs(T).any(0)]

    def moved(self, camera: Camera, step: Floats) -> Camera:
        """The camera after a step (q)."""
        p = self.columns(camera) @ step
        if self.lens_in_pixels and self.free[0]:
            p[4:9] = camera.distortion * ((1 + p[0] / camera.K[0, 0]) ** POWERS - 1)  # (7) to all orders
        return moved(camera, EVERYTHING, p)


class BundleState(NamedTuple):
    """Cameras (C) and parts."""

    cameras: tuple[Camera, ...]
    parts: tuple[Part, ...]


class ImageObservations(NamedTuple):
    """uv (C, N, 2) px; whiten (C, N, 2, 2), whose product with a residual has unit variance; used (C, N)."""

    uv: Floats
    whiten: Floats
    used: Bools


class Normal(NamedTuple):
    """(1): U (Q, Q), g (Q); for each part V (n, D, D), W (n, D, Q), transposed, and h (n, D)."""

    U: Floats
    g: Floats
    V: list[Floats]
    W: list[Floats]
    h: list[Floats]


def solve(
    state: BundleState,
    seen: ImageObservations,
    freedoms: tuple[Freedom, ...],
    *,
    soft: float | None = None,
    steps: int = STEPS,
    settled: float = SETTLED,
) -> BundleState:
    """The state near `state` with the least (3), once two steps in turn lower it by less than the share `settled`.

    `soft` is c; None means ρ = |r|².
    """
    best, damping, small, failed = cost(state, seen, soft), 1e-4, 0, False
    normal: Normal | None = None
    for _ in range(steps if np.isfinite(best) else 0):
        normal = normal or normal_equations(state, seen, freedoms, soft=soft)
        tried = _stepped(state, freedoms, normal, damping)
        lower = cost(tried, seen, soft)
        if lower < best:
            small = small + 1 if best - lower <= settled * best else 0
            damping = damping if failed else max(damping / 10, 1e-12)  # else every other step would fail in a valley
            state, best, normal, failed = tried, lower, None, False
        elif damping > 1e8 or (damping > 1e-2 and small):
            break
        else:
            damping, failed = 10 * damping, True
        if small >= 2:
            break
    return state


def residuals(state: BundleState, uv: Floats) -> Floats:
    """(C, N, 2) seen minus reprojected, px; NaN where not seen, behind the camera, or where the point is unknown."""
    xyz = all_points(state.parts)
    return np.stack([seen - project(camera, xyz) for camera, seen in zip(state.cameras, uv, strict=True)])


def normalised_residuals(state: BundleState, seen: ImageObservations) -> Floats:
    """(C, N) |r|, in standard deviations; infinite behind a camera, NaN where not seen or the point is unknown."""
    with np.errstate(all="ignore"):  # a first guess may send a point that fits nothing very far away
        r = (seen.whiten @ residuals(state, seen.uv)[..., None])[..., 0]
        d = np.sqrt((r**2).sum(-1))
    xyz = all_points(state.parts)
    there = complete(seen.uv) & complete(xyz)
    return np.where(there & ~np.isfinite(d), np.inf, d)


def cost(state: BundleState, seen: ImageObservations, soft: float | None = None) -> float:
    """(3) with what is known beforehand; infinite where a used point is behind its camera."""
    if not all(_believable(camera) for camera in state.cameras):
        return float("inf")
    with np.errstate(all="ignore"):
        total = sum(part.prior()[2] for part in state.parts)
        xyz = all_points(state.parts)
        for camera, uv, whiten, used in zip(state.cameras, *seen, strict=True):
            r = (whiten[used] @ (uv[used] - project(camera, xyz[used]))[..., None])[..., 0]
            d2 = (r**2).sum(1)
            total += float((d2 if soft is None else soft**2 * np.log1p(d2 / soft**2)).sum())
    return total if np.isfinite(total) else float("inf")


def _believable(camera: Camera) -> bool:
    """Whether its numbers are not on their way to infinity, as they are where nothing fits."""
    return bool(1 < abs(camera.K[0, 0]) < FARTHEST and (np.abs([*camera.t, *camera.distortion]) < FARTHEST).all())


def normal_equations(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], *, soft: float | None = None
) -> Normal:
    """(1), all of a camera's points of one kind and place in their pieces at a time."""
    T = [freedom.columns(camera) for freedom, camera in zip(freedoms, state.cameras, strict=True)]
    at = np.cumsum([0] + [t.shape[1] for t in T])
    U, g = np.zeros((at[-1], at[-1])), np.zeros(at[-1])
    V, W, h = [], [], []
    for part, rows in zip(state.parts, slices(state.parts), strict=True):
        xyz, tangents = part.xyz, part.tangents()
        n, K = xyz.shape[:2]
        own, pull, _ = part.prior()
        V_part, h_part, W_part = own.copy(), pull.copy(), np.zeros((n, part.degrees, at[-1]))
        for c, camera in enumerate(state.cameras):
            uv, whiten, used = (x[c, rows].reshape(n, K, *x.shape[2:]) for x in seen)
            free = slice(at[c], at[c + 1])
            for k in range(K):
                i = np.flatnonzero(used[:, k])
                r, A, X = _linear(camera, xyz[i, k], uv[i, k], whiten[i, k], soft)
                B = X @ tangents[i, k]
                A = A @ T[c]
                flat = A.reshape(2 * len(i), A.shape[-1])
                U[free, free] += flat.T @ flat
                g[free] += flat.T @ r.ravel()
                Bt = B.transpose(0, 2, 1)
                V_part[i] += Bt @ B
                h_part[i] += (Bt @ r[..., None])[..., 0]
                W_part[i, :, free] += Bt @ A
        V.append(V_part)
        W.append(W_part)
        h.append(h_part)
    return Normal(U, g, V, W, h)


def _linear(
    camera: Camera, xyz: Floats, uv: Floats, whiten: Floats, soft: float | None
) -> tuple[Floats, Floats, Floats]:
    """r (i, 2), its derivatives by the camera's parameters (i, 2, 15) and by the point (i, 2, 3), with (4)."""
    J = parameter_jacobian(camera, xyz)
    r = (whiten @ (uv - project(camera, xyz))[..., None])[..., 0]
    if soft is not None:
        root = 1 / np.sqrt(1 + (r**2).sum(1) / soft**2)  # (4)
        whiten, r = whiten * root[:, None, None], r * root[:, None]
    J = whiten @ J
    return r, J, J[..., 12:15] @ camera.R


def _stepped(state: BundleState, freedoms: tuple[Freedom, ...], normal: Normal, damping: float) -> BundleState:
    """The state after the step of (2)."""
    inverses = [piece_inverses(V, damping) for V in normal.V]
    S, b = reduced(normal, inverses, damping)
    scale = 1 / np.sqrt(np.maximum(np.diag(S), 1e-300))
    delta = scale * np.linalg.lstsq(S * scale * scale[:, None], b * scale, rcond=1e-15)[0] if len(b) else b
    parts = tuple(
        part.moved((inverse @ (h - W @ delta)[..., None])[..., 0])
        for part, inverse, W, h in zip(state.parts, inverses, normal.W, normal.h, strict=True)
    )
    ends = np.cumsum([f.columns(c).shape[1] for f, c in zip(freedoms, state.cameras, strict=True)])[:-1]
    cameras = tuple(
        freedom.moved(camera, step) if len(step) else camera
        for freedom, camera, step in zip(freedoms, state.cameras, np.split(delta, ends), strict=True)
    )
    return BundleState(cameras, parts)


def reduced(normal: Normal, inverses: list[Floats], damping: float = 0.0) -> tuple[Floats, Floats]:
    """The matrix and the right side of (2) for the cameras."""
    S, b = normal.U + damping * np.diag(np.diag(normal.U)), normal.g.copy()
    for inverse, W, h in zip(inverses, normal.W, normal.h, strict=True):
        if W.size:
            flat = W.reshape(-1, W.shape[2])
            half = (_roots(inverse) @ W).reshape(flat.shape)
            S -= half.T @ half
            b -= flat.T @ (inverse @ h[..., None]).ravel()
    return S, b


def _roots(inverse: Floats) -> Floats:
    """L with LᵀL = V⁻¹ (n, D, D): half the work of a product, as BLAS knows that it is symmetric."""
    lost = np.diagonal(inverse, axis1=-2, axis2=-1).min(-1) <= 0
    safe = np.where(lost[:, None, None], np.eye(inverse.shape[-1]), inverse)
    roots = np.linalg.cholesky(safe).transpose(0, 2, 1)
    return np.where(lost[:, None, None], 0.0, roots)


def piece_inverses(V: Floats, damping: float = 0.0) -> Floats:
    """(V + λ diag V)⁻¹ (n, D, D); zero for pieces that nobody sees."""
    diagonal = np.diagonal(V, axis1=-2, axis2=-1)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    eye = np.eye(V.shape[-1])
    scaled = V * scale[:, None] * scale[..., None] + damping * eye
    seen = np.asarray((diagonal > 0).all(-1) if V.shape[-1] else np.zeros(len(V), np.bool_))
    scaled = np.where(seen[:, None, None], scaled + 1e-14 * eye, eye)
    inverse = np.linalg.inv(scaled) * scale[:, None] * scale[..., None]
    return np.where(seen[:, None, None], inverse, 0.0)


def placed(camera: Camera, R: Floats, t: Floats, scale: float = 1.0) -> Camera:
    """The camera in a world where X is scale · R X + t; its covariance is left as it is."""
    turned = camera.R @ R.T
    return replace(camera, R=turned, t=scale * camera.t - turned @ t)
