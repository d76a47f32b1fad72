"""A camera's focal lengths, centre and lens from points of planes, whose places before the camera are unknown.

View v shows points (x, y, 0) of a plane, mm, through the camera K, k1 … k3 from the pose R_v, t_v
(`data.rig`, (1)–(4)). All are fitted together, after the start of Zhang (2000): the homography H of a view, pixels from
plane, has the columns K (r1, r2, t) up to scale, so that with the centre moved to zero

    h1ᵀ ω h2 = 0,    h1ᵀ ω h1 = h2ᵀ ω h2,    ω = diag(1/f², 1/f², 1)       (1)

are two linear equations for 1/f² a view. They say nothing where the plane faces the camera: f then cannot be known, but
the lens, as a map of pixels, can. For the fit not to care, it moves along the focal length by a *zoom* ε,

    fx, fy, t_z ← e^ε (fx, fy, t_z),   k1 ← e^2ε k1,   p1, p2 ← e^ε (p1, p2),   k2 ← e^4ε k2,   k3 ← e^6ε k3        (2)

under which the picture of a plane that faces the camera, lens and all, stays as it is. The parameters are ε, the ratio
ln(fy/fx), the centre, the lens terms, and six for each pose; with whitened residuals r and their Jacobian J,
Levenberg–Marquardt (`numerics.levenberg_marquardt`) lowers

    χ² = Σ |r|² + s² Σ ((θ − θ0) / τ)²                                    (3)

whose last part says what is known of any camera: focal length within a factor e of `nominal`, pixels about square,
centre within a quarter of the image's width of its middle, and p1, p2 about `DECENTRED`. (In one view that faces the
camera, p1 and p2, a turn of the plane and a shift of the centre look almost the same.) s² = Σ |r|² / ν is the noise as
found (4), so where the points say anything at all, this part has no weight. The covariance is

    s² ν / (ν − 2) (JᵀJ + s² diag τ⁻²)⁻¹                                  (5)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from ...data import Camera
from ...data.array_types import Bools, Floats, Ints
from ...geometry import parameter_jacobian, project
from ...geometry.dlt import normalising
from ...numerics.levenberg_marquardt import damped_step, minimise
from ...numerics.scaled import scaled_inverse

SHARED = 9  # parameters that all views share: ε, ln(fy/fx), centre, five lens terms; by definition
POSE = 6  # parameters of a view's pose; by definition
ZOOM = np.array([1.0, 1.0, 0.0, 0.0, 2.0, 4.0, 1.0, 1.0, 6.0])
"""Powers of e^ε by which (2) multiplies fx, fy, cx, cy, k1, k2, p1, p2, k3; by definition."""
STEPS = 60  # tries at most; chosen (see studies/linearisation.py)
SETTLED = 1e-4  # of s²: a hundredth of a standard deviation; chosen (see studies/linearisation.py)
FURTHEST = 3.0  # a zoom beyond e³ is no step but a fall; chosen (see studies/linearisation.py)
START_NOISE = 1e-2  # px², the s² of the first pass; chosen: a tenth of a pixel (see studies/linearisation.py)
DECENTRED = 1e-3  # standard deviation of p1 and p2 of any lens, without unit; chosen (see studies/linearisation.py)
STARTS = (1.0, 0.5, 2.0)  # times the nominal focal length; chosen


class PlanePoints(NamedTuple):
    """Points of all views, sorted by view (N): xyz (N, 3) mm with z = 0, uv (N, 2) px, whiten (N, 2, 2).

    A residual times `whiten` has unit noise.
    """

    view: Ints
    xyz: Floats
    uv: Floats
    whiten: Floats

    def part(self, rows: Bools) -> PlanePoints:
        """The points where `rows` (N) is true."""
        return PlanePoints(self.view[rows], self.xyz[rows], self.uv[rows], self.whiten[rows])


class Planes(NamedTuple):
    """A camera (its own R and t mean nothing) and the poses R (V, 3, 3), t (V, 3) mm of planes before it."""

    camera: Camera
    R: Floats
    t: Floats


class KnownOptics(NamedTuple):
    """What is known of any camera: its middle (2) px, nominal focal length px, and τ (9) of (3)."""

    image_centre: Floats
    nominal: float
    tau: Floats


class PlaneFit(NamedTuple):
    """Fitted planes, which lens terms (5) were fitted, degrees of freedom ν, and χ² of the points alone.

    χ² is infinite if points lie behind the camera.
    """

    planes: Planes
    lens: Bools
    nu: int
    chi2: float

    @property
    def noise(self) -> float:
        """s² of (4)."""
        return self.chi2 / self.nu + 1e-16


def known_of(size: Ints, uv: Floats) -> KnownOptics:
    """What is known of a camera with images of this size (2) px, (0, 0) where unknown, that has seen points (N, 2)."""
    side = size.astype(np.float64) if size.all() else uv.max(0) - uv.min(0)
    image_centre = (side - 1) / 2 if size.all() else (uv.max(0) + uv.min(0)) / 2
    nominal = float(side.max())
    tau = np.array([1.0, 1.0, nominal / 4, nominal / 4, np.inf, np.inf, DECENTRED, DECENTRED, np.inf])
    return KnownOptics(image_centre, nominal, tau)


def fit_homography(xy: Floats, uv: Floats) -> Floats:
    """H (3, 3) of unit norm with (uv, 1) ~ H (xy, 1) for points (N, 2), N ≥ 4, by normalised linear least squares."""
    T, U = normalising(xy), normalising(uv)
    X = np.column_stack([xy, np.ones(len(xy))]) @ T.T
    u, v, _ = U @ np.column_stack([uv, np.ones(len(uv))]).T
    zero = np.zeros_like(X)
    A = np.concatenate([np.hstack([X, zero, -u[:, None] * X]), np.hstack([zero, X, -v[:, None] * X])])
    H = np.linalg.inv(U) @ np.linalg.svd(A, full_matrices=len(A) < 9)[2][-1].reshape(3, 3) @ T
    return np.asarray(H / np.linalg.norm(H))


def start_planes(name: str, size: Ints, points: PlanePoints, known: KnownOptics) -> list[Planes]:
    """Planes to begin with, for some focal lengths: that of (1), and the nominal one and its like."""
    each = [points.part(points.view == v) for v in range(int(points.view.max()) + 1)]
    flat = [fit_homography(p.xyz[:, :2], p.uv - known.image_centre) for p in each]
    rows = [
        row
        for h in flat
        for row in (
            [h[0, 0] * h[0, 1] + h[1, 0] * h[1, 1], h[2, 0] * h[2, 1]],
            [(h[:2, 0] ** 2 - h[:2, 1] ** 2).sum(), h[2, 0] ** 2 - h[2, 1] ** 2],
        )
    ]
    a, b = np.array(rows).T
    inverse = -(a @ b) / max(a @ a, 1e-300)  # (1)
    focals = [known.nominal * factor for factor in STARTS]
    if (4 * known.nominal) ** -2 < inverse < (known.nominal / 4) ** -2:
        focals.insert(0, float(inverse**-0.5))
    starts = []
    for focal in focals:
        K = np.array([[focal, 0.0, known.image_centre[0]], [0.0, focal, known.image_centre[1]], [0.0, 0.0, 1.0]])
        R, t = (np.array(part) for part in zip(*(_pose(h, focal) for h in flat), strict=True))
        starts.append(Planes(Camera(name, size, K, np.eye(3), np.zeros(3)), R, t))
    return starts


def fit_planes(
    start: Planes,
    points: PlanePoints,
    *,
    lens: Bools,
    known: KnownOptics,
    noise: float | None = None,
    steps: int = STEPS,
) -> PlaneFit:
    """Step to the least of (3) from `start`; `lens` (5) tells which of k1, k2, p1, p2, k3 are fitted.

    Where `noise` is None, s² is found first.
    """
    free = _free(lens, len(start.t))
    nu = max(2 * len(points.uv) - int(free.sum()), 1)
    planes = start._replace(camera=replace(start.camera, distortion=np.where(lens, start.camera.distortion, 0.0)))
    for given in (START_NOISE, None) if noise is None else (noise,):
        s2 = _chi2(planes, points) / nu + 1e-16 if given is None else given
        planes = minimise(_PlaneProblem(points, free, known, s2), planes, steps=steps, absolute=SETTLED * s2)
    chi2 = _chi2(planes, points)
    return PlaneFit(planes, lens, nu, chi2 if np.isfinite(chi2) else float("inf"))


def shared_covariance(fit: PlaneFit, points: PlanePoints, known: KnownOptics) -> Floats:
    """(5) (9, 9) of ε, ln(fy/fx), cx, cy, k1, k2, p1, p2, k3, with zero rows for lens terms that are held."""
    free = _free(fit.lens, len(fit.planes.t))
    A, _ = _normal(fit.planes, points, free, known, fit.noise)
    cov = np.zeros((len(free), len(free)))
    cov[np.ix_(free, free)] = scaled_inverse(A) * fit.noise * max(fit.nu, 3) / (max(fit.nu, 3) - 2)  # (5)
    return cov[:SHARED, :SHARED]


def seen_at(planes: Planes, points: PlanePoints) -> Floats:
    """(N, 2) px where the camera has the points; NaN behind it."""
    return project(planes.camera, _before_camera(planes, points))


def normalised_residuals(planes: Planes, points: PlanePoints) -> Floats:
    """(N) lengths of the residuals in units of their standard deviation."""
    residual = (points.whiten @ (points.uv - seen_at(planes, points))[..., None])[..., 0]
    return np.asarray(np.linalg.norm(residual, axis=1))


def zoomed(planes: Planes, epsilon: float) -> Planes:
    """(2)."""
    power = np.exp(epsilon * ZOOM)
    K = planes.camera.K.copy()
    K[0, 0], K[1, 1] = K[0, 0] * power[0], K[1, 1] * power[1]
    camera = replace(planes.camera, K=K, distortion=planes.camera.distortion * power[4:])
    return planes._replace(camera=camera, t=planes.t * np.array([1.0, 1.0, power[0]]))


def moved(planes: Planes, step: Floats) -> Planes:
    """The planes after a step (9 + 6 V) of all parameters."""
    camera, R, t = zoomed(planes, step[0])
    pose = step[SHARED:].reshape(-1, POSE)
    K = camera.K.copy()
    K[1, 1] *= np.exp(step[1])
    K[:2, 2] += step[2:4]
    turned = scipy.spatial.transform.Rotation.from_rotvec(pose[:, :3]).as_matrix() @ R
    return Planes(replace(camera, K=K, distortion=camera.distortion + step[4:9]), turned, t + pose[:, 3:])


def plane_jacobian(planes: Planes, points: PlanePoints) -> Floats:
    """d uv / d (shared parameters, pose of the point's view) (N, 2, 15) of `moved`."""
    camera, t = planes.camera, planes.t[points.view]
    x_cam = _before_camera(planes, points)
    J = parameter_jacobian(camera, x_cam)
    by_point = J[..., 12:]
    J[..., 9:12] = np.cross((x_cam - t)[:, None], by_point)  # as (7) of `geometry.camera`
    zoom = J[..., :SHARED] @ (ZOOM * shared_values(camera)) + J[..., 14] * t[:, None, 2]
    J[..., 1] *= camera.K[1, 1]
    J[..., 0] = zoom
    return J


def shared_values(camera: Camera) -> Floats:
    """(9) fx, fy, cx, cy, k1, k2, p1, p2, k3."""
    return np.concatenate([[camera.K[0, 0], camera.K[1, 1]], camera.K[:2, 2], camera.distortion])


def _free(lens: Bools, views: int) -> Bools:
    """(9 + 6 V) which parameters are fitted."""
    return np.concatenate([np.ones(4, np.bool_), lens, np.ones(POSE * views, np.bool_)])


def _before_camera(planes: Planes, points: PlanePoints) -> Floats:
    return (planes.R[points.view] @ points.xyz[..., None])[..., 0] + planes.t[points.view]


@dataclass(frozen=True, slots=True)
class _PlaneProblem:
    """The problem of `fit_planes` for `minimise`, with s² = `noise`."""

    points: PlanePoints
    free: Bools
    known: KnownOptics
    noise: float

    def cost(self, planes: Planes) -> float:
        """(3); infinite where a point lies behind the camera."""
        prior = float(((_from_known(planes.camera, self.known) / self.known.tau) ** 2).sum())
        total = _chi2(planes, self.points) + self.noise * prior
        return total if np.isfinite(total) else float("inf")

    def equations(self, planes: Planes) -> tuple[Floats, Floats]:
        """JᵀJ and Jᵀr of (3), of the free parameters."""
        return _normal(planes, self.points, self.free, self.known, self.noise)

    def step(self, planes: Planes, equations: tuple[Floats, Floats], damping: float) -> tuple[Planes | None, float]:
        """The planes after the step, None where it goes too far."""
        step = np.zeros(len(self.free))
        step[self.free], predicted = damped_step(*equations, damping)
        return moved(planes, step) if np.abs(step[:2]).max() < FURTHEST else None, predicted


def _normal(
    planes: Planes, points: PlanePoints, free: Bools, known: KnownOptics, noise: float
) -> tuple[Floats, Floats]:
    """JᵀJ and Jᵀr of (3), of the free parameters."""
    A, g = np.zeros((len(free), len(free))), np.zeros(len(free))
    J = points.whiten @ plane_jacobian(planes, points)
    r = (points.whiten @ (points.uv - seen_at(planes, points))[..., None])[..., 0]
    ends = np.searchsorted(points.view, np.arange(len(planes.t) + 1))
    for v, (first, last) in enumerate(pairwise(ends)):
        at = np.concatenate([np.arange(SHARED), SHARED + POSE * v + np.arange(POSE)])
        part = J[first:last].reshape(-1, len(at))
        A[np.ix_(at, at)] += part.T @ part
        g[at] += part.T @ r[first:last].ravel()
    shared = np.arange(SHARED)
    A[shared, shared] += noise / known.tau**2
    g[shared] -= noise * _from_known(planes.camera, known) / known.tau**2
    return A[np.ix_(free, free)], g[free]


def _from_known(camera: Camera, known: KnownOptics) -> Floats:
    """(9) θ − θ0 of (3)."""
    fx, fy = camera.K[0, 0], camera.K[1, 1]
    return np.concatenate(
        [[np.log(fx / known.nominal), np.log(fy / fx)], camera.K[:2, 2] - known.image_centre, camera.distortion]
    )


def _chi2(planes: Planes, points: PlanePoints) -> float:
    return float((normalised_residuals(planes, points) ** 2).sum())


def _pose(H: Floats, focal: float) -> tuple[Floats, Floats]:
    """R (3, 3) and t (3) mm of a plane with this homography about the centre, for square pixels."""
    columns = H / np.array([[focal], [focal], [1.0]])
    columns = columns / np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    columns = columns * (np.sign(columns[2, 2]) or 1.0)  # the plane lies before the camera
    r1, r2, t = columns.T
    U, _, Vt = np.linalg.svd(np.column_stack([r1, r2, np.cross(r1, r2)]))
    return U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt, t
