"""How completely and how exactly each marker was followed.

With C the covariance of a sample, the standard deviation of one axis, averaged over the three as a variance, is

    σ = √(trace C / 3)                mm                                     (1)

What of it changes from frame to frame is seen in the path itself, as its white noise (`signal.white_noise`), which asks
no model and to which movement adds nothing: its jitter. The rest of σ stays the same from frame to frame or changes
slowly, as the errors of the calibration and of the lenses do:

    steady = √(σ² − jitter²)      mm, 0 where the jitter is more               (2)
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Bools, Floats
from ..signal.white_noise import white_noise_sd
from .plain import mean, quantile, runs, share

IN_VIEW = 0.75
"""Share of the markers that must be there for the subject to count as in view; chosen."""


def standard_deviation(cov: Floats) -> Floats:
    """σ (…) mm of covariances (…, 3, 3) mm²; NaN where unknown or not a covariance."""
    variance = np.trace(cov, axis1=-2, axis2=-1) / 3
    return np.sqrt(np.where(variance >= 0, variance, np.nan))  # (1)


def sample_deviation(path: MarkerTrajectory) -> Floats:
    """σ (F) mm of a path; NaN where it has no sample."""
    return np.where(path.origin == Origin.MISSING, np.nan, standard_deviation(path.cov))


def jitter(path: MarkerTrajectory) -> float:
    """White noise of one axis of the measured samples of a path, mm; NaN with too few in a row."""
    return white_noise_sd(np.where((path.origin == Origin.MEASURED)[:, None], path.xyz, np.nan))


def steady(sd: float, noise: float) -> float:
    """What of σ `sd` mm is not `noise` mm, by (2); NaN where either is unknown."""
    return math.sqrt(max(sd**2 - noise**2, 0.0)) if math.isfinite(sd + noise) else math.nan


def positions(trajectories: Trajectories) -> Floats:
    """(M, F, 3) mm, also where there is no marker."""
    return trajectories.xyz if len(trajectories) else np.zeros((0, 0, 3))


def present(trajectories: Trajectories) -> Bools:
    """(M, F) where there is a sample."""
    return np.asarray(np.isfinite(positions(trajectories)).all(axis=2), np.bool_)


def unlabelled(trajectories: Trajectories) -> bool:
    """Whether most trajectories are tracks without a marker's name, `*1`, `*2`, …: fragments of markers."""
    return sum(path.name.startswith("*") for path in trajectories) > len(trajectories) / 2


def markers_worn(trajectories: Trajectories) -> int:
    """How many markers there are: all ever seen; of unlabelled tracks, as many as nine in ten frames do not exceed."""
    seen = present(trajectories)
    if not unlabelled(trajectories):
        return int(seen.any(axis=1).sum())
    at_once = seen.sum(axis=0)
    return round(float(np.quantile(at_once, 0.9))) if at_once.size else 0


def in_view(trajectories: Trajectories) -> tuple[int, int]:
    """First and last-plus-one frame in which three in four of the markers are there.

    Both ends of the trial where no frame has so many.
    """
    seen = present(trajectories)
    if not seen.size:
        return 0, 0
    frames = np.flatnonzero(seen.sum(0) >= max(IN_VIEW * markers_worn(trajectories), 1))
    return (int(frames[0]), int(frames[-1]) + 1) if frames.size else (0, seen.shape[1])


def completeness(trajectories: Trajectories) -> float:
    """Share of the markers' positions that are there while the subject is in view; NaN without any."""
    seen, (first, stop) = present(trajectories), in_view(trajectories)
    worn = markers_worn(trajectories) if unlabelled(trajectories) else len(trajectories)
    there = np.minimum(seen[:, first:stop].sum(axis=0), worn)
    return share(there.sum(), worn * (stop - first))


def marker_figures(trajectories: Trajectories) -> list[dict[str, Any]]:
    """The figures of every marker, in order."""
    span = in_view(trajectories)
    return [_one(path, trajectories.rate, span) for path in trajectories]


def trajectory_figures(trajectories: Trajectories, markers: list[dict[str, Any]]) -> dict[str, Any]:
    """The figures of all markers together; `markers` are theirs."""
    first, stop = in_view(trajectories)
    seen = present(trajectories)
    origin = np.array([path.origin for path in trajectories]).reshape(seen.shape)
    sd = mean(np.array([sample_deviation(path) for path in trajectories]))
    noise = quantile(np.array([marker["jitter_mm"] for marker in markers], float), 0.5)
    return {
        "count": len(trajectories),
        "unlabelled": unlabelled(trajectories),
        "markers_worn": markers_worn(trajectories),
        "samples": seen.sum(),
        "missing_samples": (~seen).sum(),
        "filled_samples": (origin == Origin.FILLED).sum(),
        "edited_samples": (origin == Origin.EDITED).sum(),
        "completeness_share": share(seen.sum(), seen.size),
        "in_view_frames": [first, stop],
        "completeness_in_view_share": completeness(trajectories),
        "gaps": sum(marker["gaps"] for marker in markers),
        "longest_gap_frames": max((marker["longest_gap_frames"] for marker in markers), default=0),
        "longest_gap_s": max((marker["longest_gap_s"] for marker in markers), default=0.0),
        "sd_per_axis_mean_mm": sd,
        "jitter_median_mm": noise,
        "steady_sd_mm": steady(sd, noise),
        "markers": markers,
    }


def _one(path: MarkerTrajectory, rate: float, span: tuple[int, int]) -> dict[str, Any]:
    seen = path.origin != Origin.MISSING
    at = np.flatnonzero(seen)
    inside = seen[slice(*span)]
    longest = max((b - a for a, b in path.gaps), default=0)
    filled = max((b - a for a, b in runs(path.origin == Origin.FILLED)), default=0)
    return {
        "name": path.name,
        "samples": seen.sum(),
        "missing_samples": (~seen).sum(),
        "filled_samples": (path.origin == Origin.FILLED).sum(),
        "edited_samples": (path.origin == Origin.EDITED).sum(),
        "completeness_share": share(seen.sum(), len(path)),
        "completeness_in_view_share": share(inside.sum(), inside.size),
        "first_seen_s": at[0] / rate if at.size else None,
        "last_seen_s": at[-1] / rate if at.size else None,
        "gaps": len(path.gaps),
        "longest_gap_frames": longest,
        "longest_gap_s": longest / rate,
        "longest_fill_frames": filled,
        **_exactness(path),
        "cameras_mean": mean(_cameras(path)),
    }


def _exactness(path: MarkerTrajectory) -> dict[str, float]:
    sd = sample_deviation(path)
    return {
        "sd_per_axis_mean_mm": mean(sd),
        "sd_per_axis_95_mm": quantile(sd, 0.95),
        "jitter_mm": jitter(path),
        "residual_mean_mm": mean(path.residual),
    }


def _cameras(path: MarkerTrajectory) -> NDArray[np.float64]:
    """(F) how many cameras saw each sample; NaN where unknown."""
    count = np.bitwise_count(path.cameras).astype(float)
    return np.where(count > 0, count, np.nan)
