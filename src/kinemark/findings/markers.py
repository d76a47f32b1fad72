"""How completely and how exactly each marker was followed.

With C the covariance of a sample, the standard deviation of one axis, averaged over the three as a variance, is

    σ = √(trace C / 3)                mm                                     (1)

A measure of noise that asks no model, from third differences of positions through time: white noise of
standard deviation σ gives d = x[f+3] − 3 x[f+2] + 3 x[f+1] − x[f] the variance (1 + 9 + 9 + 1) σ² = 20 σ²,
while smooth movement nearly cancels, so that with the median, which single jumps cannot move,

    jitter = 1.4826 · median |d| / √20        mm                             (2)

1.4826 turns the median of absolute normal deviates into their standard deviation. Movement that is fast for
the frame rate adds to (2): it is an upper bound of the noise.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Bools, Floats
from ..numerics.robust import SD_PER_MEDIAN
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


def jitter(xyz: Floats) -> float:
    """Noise of one axis of a path (F, 3), mm; NaN with fewer than four samples in a row."""
    return SD_PER_MEDIAN * quantile(np.abs(np.diff(xyz, n=3, axis=0)), 0.5) / math.sqrt(20)  # (2)


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
        "sd_per_axis_mean_mm": mean(np.array([sample_deviation(path) for path in trajectories])),
        "jitter_median_mm": quantile(np.array([marker["jitter_mm"] for marker in markers], float), 0.5),
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
        "jitter_mm": jitter(path.xyz),
        "residual_mean_mm": mean(path.residual),
    }


def _cameras(path: MarkerTrajectory) -> NDArray[np.float64]:
    """(F) how many cameras saw each sample; NaN where unknown."""
    count = np.bitwise_count(path.cameras).astype(float)
    return np.where(count > 0, count, np.nan)
