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
from ..data.array_types import Bools, Floats, Ints
from ..signal.white_noise import white_noise_sd
from .left_over import used_of_possible
from .plain import mean, quantile, runs, share

IN_VIEW = 0.75
"""Share of the markers that must be there for the subject to count as in view; chosen."""
OUT_OF_VIEW, OUT_S = 0.3, 0.25
"""Share of the markers, and of the usual images, below both of which the subject is out of view, and for how long, s;
chosen: markers that are lost while the cameras see as much as ever are missing."""
PARTS, FEWEST_A_PART = 10, 5
"""Of a path, and samples of each, by which is told whether it moves; chosen: a median of five is free of outliers."""
MOST_AT_ONCE = 0.9
"""Share of the frames that have no more markers than are worn; chosen: in the others are ghosts."""
LEFT_OVER = 0.5
"""Share of the images of two cameras and of all that must belong to a point for completeness to be known; chosen: else
there may be as many markers again as were found."""


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


def travel(path: MarkerTrajectory) -> float:
    """How far a path goes, mm: between the farthest of the medians of its ten parts, which noise moves little; NaN of a
    path with too few samples to tell."""
    xyz = path.xyz[path.origin == Origin.MEASURED]
    if len(xyz) < PARTS * FEWEST_A_PART:
        return math.nan
    middle = np.array([np.median(part, axis=0) for part in np.array_split(xyz, PARTS)])
    return float(np.linalg.norm(middle[:, None] - middle, axis=-1).max())


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
    """How many markers there are: all named ones ever seen, and beside them as many without a name as half of the
    frames have; of unlabelled tracks, as many as nine in ten frames that have any do not exceed."""
    seen = present(trajectories)
    if not unlabelled(trajectories):
        return int(seen[_named(trajectories)].any(axis=1).sum()) + _nameless_worn(trajectories)
    at_once = seen.sum(axis=0)
    at_once = at_once[at_once > 0]
    return max(round(float(np.quantile(at_once, MOST_AT_ONCE))), 1) if at_once.size else 0


def _named(trajectories: Trajectories) -> Bools:
    """(M) which have a marker's name."""
    return np.array([not path.name.startswith("*") for path in trajectories], np.bool_)


def _nameless_worn(trajectories: Trajectories) -> int:
    """Markers beside the named ones: short pieces and ghosts that were left without a name are none, nor is a piece of
    a marker that has its name elsewhere: so there are never more at once than are worn."""
    seen, named = present(trajectories), _named(trajectories)
    seen = seen[:, seen.any(axis=0)]
    if not seen.size:
        return 0
    lasting = np.median(seen[~named].sum(axis=0))
    room = np.quantile(seen.sum(axis=0), MOST_AT_ONCE) - seen[named].any(axis=1).sum()
    return max(round(float(min(lasting, room))), 0)


def in_view(trajectories: Trajectories) -> tuple[int, int]:
    """First and last-plus-one frame in which three in four of the markers are there.

    Both ends of the trial where no frame has so many.
    """
    seen = present(trajectories)
    if not seen.size:
        return 0, 0
    frames = np.flatnonzero(seen.sum(0) >= max(IN_VIEW * markers_worn(trajectories), 1))
    return (int(frames[0]), int(frames[-1]) + 1) if frames.size else (0, seen.shape[1])


def frames_in_view(trajectories: Trajectories, images: Ints | None = None) -> Bools:
    """(F) the frames of `in_view` but for those in which the subject was away in between.

    It was where for a while there are few markers, and few of the images (F) that all cameras have together else.
    """
    at_once, (first, stop) = present(trajectories).sum(0), in_view(trajectories)
    inside = np.zeros(len(at_once), np.bool_)
    inside[first:stop] = True
    if images is None or not inside.any():
        return inside
    worn = markers_worn(trajectories)
    whole = inside & (at_once >= IN_VIEW * worn)
    usual = np.median(images[whole]) if whole.any() else 0.0
    for a, b in runs(inside & (at_once < OUT_OF_VIEW * worn) & (images < OUT_OF_VIEW * usual)):
        if b - a >= OUT_S * trajectories.rate:
            inside[a:b] = False
    return inside


def completeness(trajectories: Trajectories, inside: Bools | None = None, shown: float = 0.0) -> float:
    """Share of the markers' positions that are there while the subject is in view, in the frames `inside` (F); NaN
    without any. Tracks without names are of so many markers at least as the images of a frame show."""
    seen = present(trajectories)
    inside = frames_in_view(trajectories) if inside is None else inside
    if unlabelled(trajectories):
        named, nameless = np.zeros(len(trajectories), np.bool_), max(markers_worn(trajectories), shown)
    else:
        named, nameless = _named(trajectories), _nameless_worn(trajectories)
    there = seen[named][:, inside].sum() + np.minimum(seen[~named][:, inside].sum(axis=0), nameless).sum()
    return share(there, (named.sum() + nameless) * inside.sum())


def completeness_known(cameras: list[dict[str, Any]]) -> bool:
    """Whether the images of the cameras, of which these are the figures, leave no room for as many markers again."""
    used, possible = used_of_possible(cameras)
    return bool((used < LEFT_OVER * possible).sum() < 2 or used.sum() >= LEFT_OVER * possible.sum())


def marker_figures(trajectories: Trajectories, inside: Bools) -> list[dict[str, Any]]:
    """The figures of every marker, in order; the subject is in view in the frames `inside` (F)."""
    return [_one(path, trajectories.rate, inside) for path in trajectories]


def trajectory_figures(
    trajectories: Trajectories, markers: list[dict[str, Any]], inside: Bools, *, known: bool = True, shown: float = 0.0
) -> dict[str, Any]:
    """The figures of all markers together.

    Args:
        trajectories: the markers.
        markers: their figures.
        inside: (F) where the subject is in view.
        known: whether it is known how complete they are.
        shown: how many the images of a frame show at least (`shown_at_once`); of no account where that is not known.
    """
    seen = present(trajectories)
    origin = np.array([path.origin for path in trajectories]).reshape(seen.shape)
    sd = mean(np.array([sample_deviation(path) for path in trajectories]))
    noise = quantile(np.array([marker["jitter_mm"] for marker in markers], float), 0.5)
    shown = shown if known and unlabelled(trajectories) else 0.0
    return {
        "count": len(trajectories),
        "unlabelled": unlabelled(trajectories),
        "markers_worn": markers_worn(trajectories),
        "markers_shown": round(shown),
        "samples": seen.sum(),
        "missing_samples": (~seen).sum(),
        "filled_samples": (origin == Origin.FILLED).sum(),
        "edited_samples": (origin == Origin.EDITED).sum(),
        "completeness_share": share(seen.sum(), seen.size),
        "first_frame": trajectories.first_frame,
        "in_view_frames": list(in_view(trajectories)),
        "in_view_runs": runs(inside),
        "completeness_in_view_share": completeness(trajectories, inside, shown) if known else math.nan,
        "completeness_of_found_share": completeness(trajectories, inside),
        "gaps": sum(marker["gaps"] for marker in markers),
        "longest_gap_frames": max((marker["longest_gap_frames"] for marker in markers), default=0),
        "longest_gap_s": max((marker["longest_gap_s"] for marker in markers), default=0.0),
        "sd_per_axis_mean_mm": sd,
        "jitter_median_mm": noise,
        "steady_sd_mm": steady(sd, noise),
        "markers": markers,
    }


def _one(path: MarkerTrajectory, rate: float, in_view: Bools) -> dict[str, Any]:
    seen = path.origin != Origin.MISSING
    at = np.flatnonzero(seen)
    inside = seen[in_view]
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
        "travel_mm": travel(path),
        "residual_mean_mm": mean(path.residual),
    }


def _cameras(path: MarkerTrajectory) -> NDArray[np.float64]:
    """(F) how many cameras saw each sample; NaN where unknown."""
    count = np.bitwise_count(path.cameras).astype(float)
    return np.where(count > 0, count, np.nan)
