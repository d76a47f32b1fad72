"""The error of markers whose file does not state it: assumed, or estimated from their own unsteadiness.

The white noise of a path (`signal.white_noise`) is what changes from frame to frame: a path that was filtered before,
and errors that are slow (calibration, skin, placement), leave it too small.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import MarkerTrajectory, Trajectories
from ..data.array_types import Floats
from ..signal.white_noise import white_noise_sd


def estimated_sd(xyz: Floats) -> float:
    """σ mm along an axis of one marker's white noise, from its path (F, 3); NaN where it is too short."""
    return white_noise_sd(xyz)


def with_marker_sd(trajectories: Trajectories, sd_mm: float | None = None) -> Trajectories:
    """The same markers, with a covariance σ² I wherever theirs is unknown.

    Args:
        trajectories: covariances that they have are kept.
        sd_mm: σ; None takes the white noise of each marker.

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
