"""The error of markers whose file does not state it: assumed, or estimated from their own unsteadiness.

A smooth path sampled fast has next to no fourth difference; that of white noise of standard deviation σ has the
variance 70 σ² (Σ binomial(4, k)²), so that with the median, which fast moments do not disturb,

    σ = median |Δ⁴ x| / (0.6745 √70)                                                                    (1)

(after Lanshammar 1982). It sees only what changes from frame to frame: a path that was filtered before, and errors that
are slow (calibration, skin, placement), leave it too small.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Trajectories
from ..numerics.robust import MEDIAN_OF_NORMAL

DIFFERENCES = 4
GAIN = 70.0
FEWEST = 20


def estimated_sd(xyz: NDArray[np.float64]) -> float:
    """σ mm along an axis of one marker's white noise (1), from its path (F, 3); NaN from fewer than 20 differences."""
    change = np.diff(xyz, n=DIFFERENCES, axis=0)
    known = change[np.isfinite(change).all(1)]
    if len(known) < FEWEST:
        return float("nan")
    return float(np.sqrt(np.mean((np.median(np.abs(known), axis=0) / MEDIAN_OF_NORMAL) ** 2) / GAIN))  # (1)


def with_marker_sd(trajectories: Trajectories, sd_mm: float | None = None) -> Trajectories:
    """The same markers, with a covariance σ² I wherever theirs is unknown.

    Args:
        trajectories: covariances that they have are kept.
        sd_mm: σ; None estimates one for each marker by (1).

    Raises:
        ValueError: σ is not above 0.
    """
    if sd_mm is not None and not 0 < sd_mm < np.inf:
        raise ValueError(f"sd_mm is {sd_mm}, wanted a length above 0")
    return replace(trajectories, paths=tuple(_stated(path, sd_mm) for path in trajectories))


def _stated(path: MarkerTrajectory, sd_mm: float | None) -> MarkerTrajectory:
    unknown = np.asarray(np.isnan(path.cov).any((1, 2)) & np.isfinite(path.xyz).all(1))
    if not unknown.any():
        return path
    sd = estimated_sd(path.xyz) if sd_mm is None else sd_mm
    return replace(path, cov=np.where(unknown[:, None, None], sd**2 * np.eye(3), path.cov))
