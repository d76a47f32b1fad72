"""Points from all their images by least squares (KISS 4.2), weighted by the images' covariances.

The linear solution of KISS eq. 10 is the first guess, and `geometry.refine` the answer: it weighs every image by its
own covariance and by what the calibration of its camera leaves open, and gives the covariance of the point.

Detections that come without a covariance (a BTS or CSV file) are given one from the data. With a common standard
deviation s in px of each image coordinate, a point seen by n cameras has 2n − 3 degrees of freedom, and

    Σ |off|² ~ s² χ²(2n − 3)                                             (1)

so s² is the median of Σ |off|² over the median of χ², a value that wrong matches hardly move.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from ..data import Cloud, Detections, Matches, Rig
from ..geometry import refine, triangulate, undistort

Floats = NDArray[np.float64]

FALLBACK_SD = 0.2  # px; a usual centroid's, for recordings in which no point is seen by three cameras


@dataclass(frozen=True, slots=True)
class LeastSquares:
    """Parameters of the method.

    Attributes:
        centroid_sd: standard deviation of a centroid that states none, px; None: estimated from the data by (1).
        within_volume: drop points outside the rig's control volume, where it has one.
        volume_margin: how far outside a point may lie, mm.
    """

    centroid_sd: float | None = None
    within_volume: bool = True
    volume_margin: float = 100.0


def reconstruct(matches: Matches, detections: Detections, rig: Rig, *, method: LeastSquares = LeastSquares()) -> Cloud:
    """The points of all matches, in the order of their frames; residuals in px, covariances in mm²."""
    seen: NDArray[np.bool_] = matches.view >= 0
    uv = np.where(seen[..., None], detections.uv[matches.view], np.nan)
    cov = detections.cov[matches.view]
    ideal = np.stack([undistort(camera, uv[:, c]) for c, camera in enumerate(rig)], 1)
    guess = triangulate(ideal, rig.P)
    unknown = np.isnan(cov).any((-1, -2))
    if (unknown & seen).any():
        sd = method.centroid_sd or _centroid_sd(rig, guess, uv)
        cov = np.where(unknown[..., None, None], np.eye(2) * sd**2, cov)
    point = refine(rig, guess, uv, cov)
    residual = np.sqrt(np.nansum(point.off**2, axis=(1, 2)) / seen.sum(1))
    cloud = Cloud(
        rate=detections.rate,
        start=np.searchsorted(matches.frame, np.arange(matches.n_frames + 1)),
        xyz=point.xyz,
        cov=point.cov,
        residual=residual,
        view=matches.view,
    )
    return cloud.keep(np.isfinite(point.xyz).all(1) & _inside(point.xyz, rig, method))


def _centroid_sd(rig: Rig, guess: Floats, uv: Floats) -> float:
    """s of (1), px, from the points that three or more cameras see."""
    freedom = 2 * (~np.isnan(uv[..., 0])).sum(1) - 3
    three = (freedom >= 3) & np.isfinite(guess).all(1)
    if not three.any():
        return FALLBACK_SD
    off = refine(rig, guess[three], uv[three], np.broadcast_to(np.eye(2), (*uv[three].shape, 2))).off
    return float(np.sqrt(np.median(np.nansum(off**2, axis=(1, 2)) / chi2.median(freedom[three]))))


def _inside(xyz: Floats, rig: Rig, method: LeastSquares) -> NDArray[np.bool_]:
    """Whether points (P, 3) lie in the control volume; all do where the rig has none."""
    if not method.within_volume or np.isnan(rig.volume).any():
        return np.ones(len(xyz), bool)
    low, high = rig.volume
    return ((xyz >= low - method.volume_margin) & (xyz <= high + method.volume_margin)).all(1)
