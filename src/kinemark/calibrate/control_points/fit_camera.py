"""One camera from control points: what is fitted, and which points take part (UM²AS 2.3.3, 2.4, B).

A direct linear transformation (UM²AS eq. 2.4) starts the camera; its eleven parameters are one too many for a
camera, whose pixel axes are at right angles, and know no lens. `Dlt` stops there. `ControlPoints` finds the camera's
own parameters by least squares (`resection`), the lens terms among them, as far as the points support them:

    a camera with p free parameters needs p points                      (1)

so that at least as many equations are left over as are used up. Focal lengths, principal point, rotation and
place, p = 10, are always free and need the six points of the DLT; with eleven points k1 joins them, with
twelve k2, and so on, up to what `ControlPoints` allows. Where the lens is known from a linearisation, it is kept as it
is in pixels, and one focal length and the pose, p = 7, are found.

A point whose residual exceeds `reject` standard deviations, estimated from the median,

    s² = median(d²) / (2 ln 2) · 2 n / (2 n − p)                         (2)

(half of all χ² of two degrees of freedom are below 2 ln 2), was misread or mistaken for another: the largest one
is left out and the camera fitted again, until none is left or too few would remain to judge by.

The DLT's covariance: the eleventh parameter, an angle of the pixel axes other than 90°, has no place among those of a
camera. Over n points the fitted projections have variances that add up to 11 σ², and ten parameters alone would have
10 σ²; so theirs are taken larger by 11 / 10 (3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...data import Camera, KinemarkError
from ...data.array_types import Bools, Floats, Ints
from ...data.method import Method, parameter
from ...geometry import camera_about, decompose, fit_dlt, from_dlt, origin_near, parameter_jacobian, project, undistort
from ...numerics.robust import plane_scale
from ...numerics.scaled import scaled_inverse
from ...numerics.small_sample import variance_factor
from ..resection import ResectionFit, lens_covariance, resect
from ..stage import CALIBRATE

RADIAL = (4, 5, 8)  # places of k1, k2, k3 in `data.PARAMETERS`; by definition
TANGENTIAL = (6, 7)  # places of p1, p2 in `data.PARAMETERS`; by definition
IMPLAUSIBLE = (
    0.1  # of the images' spread; a residual beyond is no calibration; chosen (see studies/calibration_quality.py)
)
POSE_AND_FOCUS = (0, 1, 2, 3, 9, 10, 11, 12, 13, 14)  # places in `data.PARAMETERS`; by definition
ZOOM_AND_POSE = (0, 1, 9, 10, 11, 12, 13, 14)  # places in `data.PARAMETERS`; by definition

SURVEYED = ("control_points", "control_frame")
"""The ways of calibrating that have points at known places."""


@dataclass(frozen=True, slots=True)
class ControlPoints(Method):
    """The DLT of Abdel-Aziz and Karara (1971), refined over the camera's own parameters and its lens."""

    radial: int = parameter(
        1, unit="lens terms", low=0, high=3, meaning="at most so many radial lens terms are fitted: k1, k2, k3"
    )
    tangential: bool = parameter(False, meaning="p1 and p2 are fitted as well")
    reject: float = parameter(
        5.0, unit="standard deviations", low=3, high=math.inf,
        meaning="outliers: points so far off are left out; infinite keeps them all",
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Dlt(Method):
    """The eleven parameters by linear least squares and nothing else.

    Source: UM²AS eq. 2.4. All points count alike; the lens is taken for ideal, and pixel axes may be at any angle.
    """

    reject: float = parameter(
        5.0, unit="standard deviations", low=3, high=math.inf,
        meaning="outliers: points so far off are left out; infinite keeps them all",
    )  # fmt: skip


CameraMethod = ControlPoints | Dlt


class CameraSolution(NamedTuple):
    """What a method makes of one camera's points: the fit, which of `data.PARAMETERS` (15) were free, and how many."""

    fit: ResectionFit
    free: Bools
    parameters: int


class FittedCamera(NamedTuple):
    """A camera; which points (N) took part; and what of it was free: `data.PARAMETERS` (15), `tied` as in `resect`."""

    camera: Camera
    kept: Bools
    free: Bools
    tied: bool
    parameters: int

    @property
    def freedom(self) -> int:
        """Equations left over."""
        return 2 * int(self.kept.sum()) - self.parameters


def fit_camera(
    name: str, size: Ints, xyz: Floats, uv: Floats, cov: Floats, *, method: CameraMethod, lens: Camera | None = None
) -> FittedCamera:
    """One camera from points (N, 3) mm that it sees at (N, 2) px with covariance (N, 2, 2), its lens known or not.

    Raises:
        KinemarkError: as in `calibrate_control_points`, without the camera's name.
    """
    kept, origin = np.ones(len(xyz), np.bool_), origin_near(xyz)
    xyz = xyz - origin
    while True:
        fitted, fit = fit_all(name, size, xyz, uv, cov, kept, method, lens)
        base = min(fitted.parameters, len(POSE_AND_FOCUS))
        outlier = _outlier(fit, fitted.parameters, base, method.reject)
        if outlier is None:
            _check_plausible(fit, uv[kept])
            return fitted._replace(camera=camera_about(fitted.camera, -origin))
        if kept.sum() - 1 < max(len(xyz) / 2, base):
            raise KinemarkError(
                f"Of {len(xyz)} control points, {(~kept).sum()} did not fit the others and were left out, and the rest "
                "still disagrees. Check the order of the points and their places, or allow more lens terms."
            )
        kept[np.flatnonzero(kept)[outlier]] = False


def free_parameters(n: int, method: ControlPoints) -> Bools:
    """(15) which of `data.PARAMETERS` n points determine, by (1)."""
    free = np.zeros(15, np.bool_)
    free[list(POSE_AND_FOCUS)] = True
    for term in RADIAL[: method.radial]:
        free[term] = n > free.sum()
    if method.tangential and n > free.sum() + 1:
        free[list(TANGENTIAL)] = True
    return free


def fit_all(
    name: str, size: Ints, xyz: Floats, uv: Floats, cov: Floats, kept: Bools, method: CameraMethod, lens: Camera | None
) -> tuple[FittedCamera, ResectionFit]:
    """The camera of the kept points, none left out, with their residuals (2).

    Raises:
        KinemarkError: there is none.
    """
    x, u, Q = xyz[kept], uv[kept], cov[kept]
    ideal = u if lens is None else undistort(lens, u)
    K, R, t = decompose(from_dlt(fit_dlt(x, ideal)), front=x.mean(0) if len(x) else (0.0, 0.0, 0.0))
    start = Camera(name, size, K, R, t)
    fit, free, p = CALIBRATE.function(method)(start, x, u, Q, lens=lens, method=method)
    if not np.isfinite(fit.residual).all():
        raise KinemarkError(
            "No camera has all control points before it and sees them where they were seen. "
            "Check the order of the points and their places."
        )
    return FittedCamera(fit.camera, kept.copy(), free, lens is not None, p), fit


@CALIBRATE.method("control_points", ControlPoints, source="Abdel-Aziz and Karara 1971", ways=SURVEYED)
def refined_camera(
    start: Camera, xyz: Floats, uv: Floats, cov: Floats, *, method: ControlPoints, lens: Camera | None
) -> CameraSolution:
    """A camera's own parameters by least squares, from that of the DLT; the lens' are kept where it is known."""
    begin, tied = _straight(start) if lens is None else _through(lens, start), lens is not None
    free = free_parameters(len(xyz), method)
    if tied:
        free[:] = np.isin(np.arange(15), ZOOM_AND_POSE)
    return CameraSolution(resect(begin, xyz, uv, cov, free=free, tied=tied), free, int(free.sum()) - tied)


@CALIBRATE.method("dlt", Dlt, source="UM²AS, eq. 2.4", ways=SURVEYED)
def linear_camera(
    start: Camera, xyz: Floats, uv: Floats, cov: Floats, *, method: Dlt, lens: Camera | None
) -> CameraSolution:
    """The camera of the DLT as it is, with its covariance (3); the images' own covariances do not count."""
    return CameraSolution(_with_covariance(start, xyz, uv), np.zeros(15, np.bool_), 11)


def _straight(camera: Camera) -> Camera:
    """With pixel axes at right angles."""
    K = camera.K.copy()
    K[0, 1] = 0.0
    return replace(camera, K=K)


def _through(lens: Camera, start: Camera) -> Camera:
    """The linearised lens at the pose and focal length of a DLT."""
    if np.sign(lens.K[1, 1]) != np.sign(start.K[1, 1]):
        raise KinemarkError(
            "The control points are mirrored against the linearised camera. Count v downwards in both, and check the "
            "order of the points."
        )
    m = float(np.mean([start.K[k, k] / lens.K[k, k] for k in (0, 1)]))
    K = lens.K @ np.diag([m, m, 1.0])
    terms = lens.distortion * m ** np.array([2, 4, 1, 1, 6])
    camera = replace(start, K=K, distortion=terms)
    return replace(camera, cov=lens_covariance(lens, camera))


def _with_covariance(camera: Camera, xyz: Floats, uv: Floats) -> ResectionFit:
    """The DLT's camera with residuals and covariance, by (3)."""
    residual = uv - project(camera, xyz)
    chosen = list(POSE_AND_FOCUS)
    J = parameter_jacobian(camera, xyz)[..., chosen].reshape(-1, len(chosen))
    nu = max(2 * len(xyz) - 11, 1)
    scale = float((residual**2).sum()) / nu * variance_factor(nu)  # `resection` (3)
    cov = np.zeros((15, 15))
    cov[np.ix_(chosen, chosen)] = scaled_inverse(J.T @ J) * scale * 11 / 10  # (3)
    rms = float(np.sqrt((residual**2).sum(1).mean()))
    if np.isfinite(cov).all():
        camera = replace(camera, cov=cov, residual=rms)
    return ResectionFit(camera, residual, np.linalg.norm(residual, axis=1))


def _check_plausible(fit: ResectionFit, uv: Floats) -> None:
    """No lens and no surveyor is so bad that a camera is further off its points than this."""
    spread = float(np.sqrt(uv.var(0).sum()))
    if fit.camera.residual > IMPLAUSIBLE * spread:
        raise KinemarkError(
            f"The best camera misses its control points by {fit.camera.residual:.1f} px RMS, and they spread over only "
            f"{spread:.0f} px. Check the order of the points and their places."
        )


def _outlier(fit: ResectionFit, p: int, base: int, reject: float) -> int | None:
    """The point that fits worst, if it is an outlier and enough points are there to say so."""
    n = len(fit.normalised)
    if n <= base:
        return None
    s = plane_scale(fit.normalised) * np.sqrt(2 * n / (2 * n - p))  # (2)
    largest = int(fit.normalised.argmax())
    return largest if fit.normalised[largest] > reject * s + 1e-6 else None
