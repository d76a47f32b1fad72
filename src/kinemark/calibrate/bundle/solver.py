"""Least squares over all cameras and all points at once, by Levenberg–Marquardt with the Schur complement.

With r the residual of one image point (px, divided by its standard deviation), A its derivative by the q free
parameters of the camera and B by the D of the body it belongs to, the normal equations are those of `numerics.schur`:
δ are the parameters of all cameras, and each body is a block. Minimised is

    Σ ρ(|r|²),   ρ = |r|²,  or  c² ln(1 + |r|²/c²)                       (1)

the second (Cauchy's, `numerics.robust`) for as long as points may be wrong; there each r, A and B is multiplied by
√ρ' (2).

A camera's free parameters act through a matrix T, d parameters = T δ: a unit vector each (3), but where pixels keep
their shape fy follows fx (4), and where the lens is held in pixels its terms follow the focal length, k_n ∝ f²ⁿ and
p ∝ f (5), since x = px / f. Of what is usual of lenses (`lens_prior`), each counts as one more residual.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...data import Camera
from ...data.array_types import Bools, Floats
from ...geometry import parameter_jacobian, project
from ...numerics.levenberg_marquardt import Damping, minimise
from ...numerics.robust import cauchy_loss, cauchy_weight
from ...numerics.schur import BlockEquations, block_step
from ..resection import moved
from .lens_prior import LensPrior
from .parts import Part, all_points, complete, slices

STEPS = 200  # tries at most; chosen, far more than `benchmarks/bundle.py start` ever takes
DAMPING = Damping(fixed=(0.1, 10.0), hold=True)
"""Without unit; which points a rough fit leaves out hangs on its path: `studies/self_calibration.py` has this one's."""
SETTLED = 1e-7
"""Share of the cost that two tries in turn must neither prediction nor bring; chosen (see benchmarks/bundle.py)."""
FARTHEST = 1e9  # mm, px, or of a lens term: where numbers run away to infinity; chosen (see benchmarks/bundle.py)
POWERS = np.array([2.0, 4.0, 1.0, 1.0, 6.0])  # of f, for k1 k2 p1 p2 k3; by (5), exact
EVERYTHING = np.ones(15, np.bool_)  # all of `data.PARAMETERS`; by definition


class Freedom(NamedTuple):
    """What may change in a camera: free (15) of `data.PARAMETERS`; fy with fx (4); the lens with the focus (5).

    `prior` is what is known of it beforehand; None: nothing.
    """

    free: Bools
    square: bool = True
    lens_in_pixels: bool = False
    prior: LensPrior | None = None

    def about(self, camera: Camera) -> Freedom:
        """What is known beforehand is known about this camera, of terms that may change."""
        if not self.prior:
            return self
        changes = np.append(self.free[:2].any(), self.free[4:9])
        return self._replace(prior=self.prior.about(camera, changes) if changes.any() else None)

    def weighed(self, scale: float) -> Freedom:
        """What is known beforehand, for images whose standard deviations are to be multiplied by `scale`."""
        return self._replace(prior=self.prior and self.prior.weighed(scale))

    def held(self) -> Freedom:
        """Terms that the images need not tell, of which something is known beforehand, stay as they are."""
        if not self.prior:
            return self
        known = self.prior.learned
        free = self.free.copy()
        free[4:9] &= ~known[1:]
        return self._replace(free=free, square=self.square or bool(known[0]))

    def unknowns(self, camera: Camera) -> int:
        """How many parameters there are more than things known of them beforehand."""
        return self.columns(camera).shape[1] - (self.prior.known if self.prior else 0)

    def columns(self, camera: Camera) -> Floats:
        """T (15, q)."""
        T = np.diag(self.free.astype(np.float64))  # (3)
        if self.square and self.free[0]:
            T[1, 0], T[1, 1] = camera.K[1, 1] / camera.K[0, 0], 0.0  # (4)
        if self.lens_in_pixels and self.free[0]:
            T[4:9, 0] = POWERS * camera.distortion / camera.K[0, 0]  # (5)
        return T[:, np.abs(T).any(0)]

    def moved(self, camera: Camera, step: Floats) -> Camera:
        """The camera after a step (q)."""
        p = self.columns(camera) @ step
        if self.lens_in_pixels and self.free[0]:
            p[4:9] = camera.distortion * ((1 + p[0] / camera.K[0, 0]) ** POWERS - 1)  # (5) to all orders
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


def solve(
    state: BundleState,
    seen: ImageObservations,
    freedoms: tuple[Freedom, ...],
    *,
    soft: float | None = None,
    steps: int = STEPS,
    tolerance: float = SETTLED,
) -> BundleState:
    """The state near `state` with the least (1), to the share `tolerance` of it.

    `soft` is c; None means ρ = |r|².
    """
    return minimise(_Adjustment(seen, freedoms, soft), state, steps=steps, relative=tolerance, damping=DAMPING)


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


def cost(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], soft: float | None = None
) -> float:
    """(1) with what is known beforehand; infinite where a used point is behind its camera."""
    if not all(_finite_camera(camera) for camera in state.cameras):
        return float("inf")
    with np.errstate(all="ignore"):
        total = sum(part.prior()[2] for part in state.parts)
        total += sum(f.prior.cost(camera) for f, camera in zip(freedoms, state.cameras, strict=True) if f.prior)
        xyz = all_points(state.parts)
        for camera, uv, whiten, used in zip(state.cameras, *seen, strict=True):
            r = (whiten[used] @ (uv[used] - project(camera, xyz[used]))[..., None])[..., 0]
            d2 = (r**2).sum(1)
            total += float((d2 if soft is None else cauchy_loss(d2, soft)).sum())
    return total if np.isfinite(total) else float("inf")


def _finite_camera(camera: Camera) -> bool:
    """Whether its numbers are not on their way to infinity, as they are where nothing fits."""
    return bool(1 < abs(camera.K[0, 0]) < FARTHEST and (np.abs([*camera.t, *camera.distortion]) < FARTHEST).all())


def normal_equations(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], *, soft: float | None = None
) -> BlockEquations:
    """(1) of `numerics.schur`, all of a camera's points of one kind and place in their bodies at a time."""
    T = [freedom.columns(camera) for freedom, camera in zip(freedoms, state.cameras, strict=True)]
    at = np.cumsum([0] + [t.shape[1] for t in T])
    U, g = np.zeros((at[-1], at[-1])), np.zeros(at[-1])
    for c, (freedom, camera) in enumerate(zip(freedoms, state.cameras, strict=True)):
        if freedom.prior:
            free = slice(at[c], at[c + 1])
            normal, pull = freedom.prior.equations(camera)
            U[free, free], g[free] = T[c].T @ normal @ T[c], T[c].T @ pull
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
    return BlockEquations(U, g, V, W, h)


def _linear(
    camera: Camera, xyz: Floats, uv: Floats, whiten: Floats, soft: float | None
) -> tuple[Floats, Floats, Floats]:
    """r (i, 2), its derivatives by the camera's parameters (i, 2, 15) and by the point (i, 2, 3), with (2)."""
    J = parameter_jacobian(camera, xyz)
    r = (whiten @ (uv - project(camera, xyz))[..., None])[..., 0]
    if soft is not None:
        root = np.sqrt(cauchy_weight((r**2).sum(1), soft))  # (2)
        whiten, r = whiten * root[:, None, None], r * root[:, None]
    J = whiten @ J
    return r, J, J[..., 12:15] @ camera.R


@dataclass(frozen=True, slots=True)
class _Adjustment:
    """The problem of `solve` for `minimise`."""

    seen: ImageObservations
    freedoms: tuple[Freedom, ...]
    soft: float | None

    def cost(self, state: BundleState) -> float:
        """(1)."""
        return cost(state, self.seen, self.freedoms, self.soft)

    def equations(self, state: BundleState) -> BlockEquations:
        """One block a body."""
        return normal_equations(state, self.seen, self.freedoms, soft=self.soft)

    def step(self, state: BundleState, equations: BlockEquations, damping: float) -> tuple[BundleState, float]:
        """Cameras and bodies after the step."""
        delta, epsilon, predicted = block_step(equations, damping)
        parts = tuple(part.moved(step) for part, step in zip(state.parts, epsilon, strict=True))
        ends = np.cumsum([f.columns(c).shape[1] for f, c in zip(self.freedoms, state.cameras, strict=True)])[:-1]
        cameras = tuple(
            freedom.moved(camera, step) if len(step) else camera
            for freedom, camera, step in zip(self.freedoms, state.cameras, np.split(delta, ends), strict=True)
        )
        return BundleState(cameras, parts), predicted


def placed(camera: Camera, R: Floats, t: Floats, scale: float = 1.0) -> Camera:
    """The camera in a world where X is scale · R X + t; its covariance is left as it is."""
    turned = camera.R @ R.T
    return replace(camera, R=turned, t=scale * camera.t - turned @ t)
