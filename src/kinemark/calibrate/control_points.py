"""Cameras from control points, markers whose places in the laboratory were surveyed (UM²AS 2.3.3, 2.4, B).

A direct linear transformation (UM²AS eq. 2.4) starts each camera; its eleven parameters are one too many for a
camera, whose pixel axes are at right angles, and know no lens. So the camera's own parameters follow by
least squares (`resection`), the lens terms among them, as far as the points support them:

    a camera with p free parameters needs p points                      (1)

so that at least as many equations are left over as are used up. Focal lengths, principal point, rotation and
place, p = 10, are always free and need the six points of the DLT; with eleven points k1 joins them, with
twelve k2, and so on, up to what `ControlPoints` allows.

A point whose residual exceeds `reject` standard deviations, estimated from the median,

    s² = median(d²) / (2 ln 2) · 2 n / (2 n − p)                         (2)

(half of all χ² of two degrees of freedom are below 2 ln 2), was misread or mistaken for another: the worst one
is left out and the camera fitted again, until none is left or (1) would no longer hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..data import Camera, KinemarkError, Rig
from ..geometry import decompose, fit_dlt, from_dlt
from .resection import Fit, resect

RADIAL = (4, 5, 8)
TANGENTIAL = (6, 7)
ABSURD = 0.1
POSE_AND_FOCUS = (0, 1, 2, 3, 9, 10, 11, 12, 13, 14)


@dataclass(frozen=True, slots=True)
class ControlPoints:
    """The DLT of Abdel-Aziz and Karara (1971), refined over the camera's own parameters.

    Attributes:
        radial: at most so many radial lens terms, 0 … 3: k1, k2, k3.
        tangential: whether p1 and p2 are fitted as well.
        reject: points this many standard deviations off are left out; infinite keeps them all.
    """

    radial: int = 1
    tangential: bool = False
    reject: float = 5.0

    def __post_init__(self) -> None:
        if self.radial not in (0, 1, 2, 3):
            raise ValueError(f"radial is {self.radial}, wanted 0, 1, 2 or 3 lens terms")
        if not self.reject >= 3:
            raise ValueError(f"reject is {self.reject}, wanted at least 3 standard deviations")


def calibrate_control_points(
    names: Sequence[str],
    sizes: ArrayLike,
    xyz: NDArray[np.float64],
    uv: NDArray[np.float64],
    *,
    cov: NDArray[np.float64] | None = None,
    method: ControlPoints | None = None,
) -> Rig:
    """Cameras of these names and image sizes (C, 2) px from N control points.

    Args:
        names: (C).
        sizes: (C, 2) width and height, px; (0, 0) where unknown.
        xyz: (N, 3) places of the points, mm.
        uv: (C, N, 2) where each camera sees them, px; NaN where it does not.
        cov: (C, N, 2, 2) covariance of `uv`, px², right in proportion; without it, or where it is NaN for a point
            that a camera sees, all points of that camera count alike.
        method: what to fit.

    Returns:
        The rig, with covariances and residuals; its volume is the box around the points.

    Raises:
        ValueError: the arrays do not fit each other.
        KinemarkError: a camera sees fewer than six points, or points in a plane, or too few that fit together.
    """
    sizes = np.asarray(sizes, np.int64).reshape(-1, 2)
    _check_shapes(names, sizes, xyz, uv, cov)
    method = method or ControlPoints()
    cameras, left_out = [], []
    for c, name in enumerate(names):
        seen = np.isfinite(xyz).all(1) & np.isfinite(uv[c]).all(1)
        spread = _usable(cov[c][seen] if cov is not None else None, int(seen.sum()))
        try:
            camera, kept = fit_camera(name, sizes[c], xyz[seen], uv[c][seen], spread, method=method)
        except KinemarkError as error:
            raise KinemarkError(f"Camera {name}: {error}") from None
        cameras.append(camera)
        left_out += [] if kept.all() else [f"{name} {(~kept).sum()}"]
    known = xyz[np.isfinite(xyz).all(1)]
    volume = np.stack([known.min(0), known.max(0)]) if len(known) else np.full((2, 3), np.nan)
    words = f"control points: DLT and least squares, {len(known)} points"
    words += f"; left out: {', '.join(left_out)}" if left_out else ""
    return Rig(tuple(cameras), words, volume)


def fit_camera(
    name: str,
    size: NDArray[np.int64],
    xyz: NDArray[np.float64],
    uv: NDArray[np.float64],
    cov: NDArray[np.float64],
    *,
    method: ControlPoints,
) -> tuple[Camera, NDArray[np.bool_]]:
    """One camera from points (N, 3) mm that it sees at (N, 2) px with covariance (N, 2, 2), and which were kept (N).

    Raises:
        KinemarkError: as in `calibrate_control_points`, without the camera's name.
    """
    kept = np.ones(len(xyz), np.bool_)
    while True:
        free = free_parameters(int(kept.sum()), method)
        fit = _fit(name, size, xyz[kept], uv[kept], cov[kept], free)
        worst = _outlier(fit, int(free.sum()), method.reject)
        if worst is None:
            return _plausible(fit, uv[kept]), kept
        if kept.sum() - 1 < max(len(xyz) / 2, len(POSE_AND_FOCUS)):
            raise KinemarkError(
                f"Of {len(xyz)} control points, {(~kept).sum()} did not fit the others and were left out, and the rest "
                "still disagrees. Check the order of the points and their places, or allow more lens terms."
            )
        kept[np.flatnonzero(kept)[worst]] = False


def free_parameters(n: int, method: ControlPoints) -> NDArray[np.bool_]:
    """(15) which of `data.PARAMETERS` n points determine, by (1)."""
    free = np.zeros(15, np.bool_)
    free[list(POSE_AND_FOCUS)] = True
    for term in RADIAL[: method.radial]:
        free[term] = n > free.sum()
    if method.tangential and n > free.sum() + 1:
        free[list(TANGENTIAL)] = True
    return free


def _fit(
    name: str,
    size: NDArray[np.int64],
    xyz: NDArray[np.float64],
    uv: NDArray[np.float64],
    cov: NDArray[np.float64],
    free: NDArray[np.bool_],
) -> Fit:
    K, R, t = decompose(from_dlt(fit_dlt(xyz, uv)), front=xyz.mean(0) if len(xyz) else (0.0, 0.0, 0.0))
    K[0, 1] = 0.0
    fit = resect(Camera(name, size, K, R, t), xyz, uv, cov, free=free)
    if not np.isfinite(fit.residual).all():
        raise KinemarkError(
            "No camera has all control points before it and sees them where they were seen. "
            "Check the order of the points and their places."
        )
    return fit


def _plausible(fit: Fit, uv: NDArray[np.float64]) -> Camera:
    """The camera, unless it is further off its points than any lens or surveyor could be."""
    spread = float(np.sqrt(uv.var(0).sum()))
    if fit.camera.residual > ABSURD * spread:
        raise KinemarkError(
            f"The best camera misses its control points by {fit.camera.residual:.1f} px RMS, and they spread over only "
            f"{spread:.0f} px. Check the order of the points and their places."
        )
    return fit.camera


def _outlier(fit: Fit, p: int, reject: float) -> int | None:
    """The point that fits worst, if it is an outlier and enough points are there to say so."""
    n = len(fit.normalised)
    if n <= len(POSE_AND_FOCUS):
        return None
    s = np.sqrt(np.median(fit.normalised**2) / (2 * np.log(2)) * 2 * n / (2 * n - p))  # (2)
    worst = int(fit.normalised.argmax())
    return worst if fit.normalised[worst] > reject * s + 1e-6 else None


def _usable(cov: NDArray[np.float64] | None, n: int) -> NDArray[np.float64]:
    """`cov` (n, 2, 2) if it is known for all points, else the same for all."""
    return cov if cov is not None and np.isfinite(cov).all() else np.tile(np.eye(2), (n, 1, 1))


def _check_shapes(
    names: Sequence[str],
    sizes: NDArray[np.int64],
    xyz: NDArray[np.float64],
    uv: NDArray[np.float64],
    cov: NDArray[np.float64] | None,
) -> None:
    c, n = len(names), len(xyz)
    found = {"sizes": (sizes.shape, (c, 2)), "xyz": (xyz.shape, (n, 3)), "uv": (uv.shape, (c, n, 2))}
    if cov is not None:
        found["cov"] = (cov.shape, (c, n, 2, 2))
    for what, (have, want) in found.items():
        if have != want:
            raise ValueError(f"{what} has shape {have}, wanted {want} for {c} cameras and {n} points")
