"""What distances from other markers say of who is who: the body keeps its shape.

Of a path before and after a place, in windows of WINDOW_S, the distances from each other path k have means μ and
standard deviations s. Markers of the same segment keep theirs, so where the two halves are one marker,

    z_k = (μ_after − μ_before) / √(s_before² + s_after² + SLACK²)                                          (1)

is small for those k whose distance was steadiest before. The misfit is the mean of 2 ln(1 + z²/3), as of Student's t
with three degrees of freedom, over the COMPANIONS steadiest (2).

What tracking joins by companions (`track/simultaneous/joining/companions.py`) is told by the same score: of the
distances just before and after, medians r and r' of variances v and v',

    score_k = 2 ln(L (1 − STRAY) / √(2π (v + v')) exp(−(r' − r)² / 2 (v + v')) + STRAY)                    (3)

with L how far apart markers usually are. Three times its mean over the MATES nearest companions, or over the MATES
steadiest ones where that is lower, is what they say for one marker (4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...numerics.robust import SD_PER_MEDIAN
from ...numerics.row_quantiles import row_medians
from .paths import Paths

WINDOW_S = 1.0
"""Length of each window, s; chosen: a stride."""
FRAMES = 24
"""Of a window that are looked at, evenly spread; chosen."""
SLACK_MM = 2.0
"""mm; chosen: what skin and noise make of a distance at least."""
COMPANIONS = 5
"""Other paths that tell; chosen: as many as a segment has."""
ENOUGH = 6
"""Frames of a window in which both must be seen; chosen."""
NEXT, FEWEST, MATES, STRAY, LEAST_MM = 24, 3, 4, 0.02, 1.0
"""Samples beside a place that (3) looks at, fewest of them and of companions, companions of (4), share of those that do
not keep their distance, and mm that a distance varies at least; chosen, as in tracking."""


class Distances(NamedTuple):
    """From one half of a path to all paths in a window: means (M), standard deviations (M), NaN where unknown."""

    mean: Floats
    sd: Floats


def distances(paths: Paths, p: int, middle: float, side: int) -> Distances:
    """Of path p before (side −1) or after (1) the middle of a place."""
    n = round(WINDOW_S * paths.rate)
    last = int(np.floor(middle)) if side < 0 else int(np.floor(middle)) + 1
    step = max(1, n // FRAMES)
    frames = last + side * np.arange(0, n, step)
    frames = frames[(frames >= 0) & (frames < paths.xyz.shape[1])]
    own = frames[paths.seen[p, frames]]
    if len(own) < ENOUGH:
        unknown = np.full(len(paths.frames), np.nan)
        return Distances(unknown, unknown)
    off = paths.xyz[:, own] - paths.xyz[p, own]
    d = np.sqrt(np.einsum("mfk,mfk->mf", off, off))
    there = np.isfinite(d)
    n_there = there.sum(1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(there, d, 0.0).sum(1) / n_there
        sd = np.sqrt(np.where(there, (d - mean[:, None]) ** 2, 0.0).sum(1) / n_there)
    enough = n_there >= ENOUGH
    enough[p] = False
    return Distances(np.where(enough, mean, np.nan), np.where(enough, sd, np.nan))


def misfit(before: Distances, after: Distances, without: tuple[int, ...] = ()) -> float:
    """(2) of two halves, but for some companions; NaN where nothing can be told."""
    known = np.isfinite(before.mean) & np.isfinite(after.mean)
    known[list(without)] = False
    at = np.flatnonzero(known)
    at = at[np.argsort(before.sd[at], kind="stable")[:COMPANIONS]]
    if len(at) < 2:
        return float("nan")
    z = (after.mean[at] - before.mean[at]) / np.sqrt(before.sd[at] ** 2 + after.sd[at] ** 2 + SLACK_MM**2)  # (1)
    return float(np.mean(2 * np.log1p(z**2 / 3)))


class _Mates(NamedTuple):
    """Median distances (M) from one half of a path to all paths, mm, and their variances; NaN where unknown."""

    r: Floats
    variance: Floats


def companions(paths: Paths, p: int, sample: int, spread: float) -> float:
    """(4) of path p between its sample of that index and the next; 0 where nothing can be told.

    Args:
        paths: of the trial. p, sample: which, and where.
        spread: L of (3), mm (`spread`).
    """
    own = paths.frames[p]
    before = _mates(paths, p, own[max(sample + 1 - NEXT, 0) : sample + 1])
    after = _mates(paths, p, own[sample + 1 : sample + 1 + NEXT])
    variance = before.variance + after.variance
    known = np.flatnonzero(np.isfinite(variance))
    if len(known) < FEWEST:
        return 0.0
    variance, near = variance[known], np.minimum(before.r, after.r)[known]
    off = (after.r - before.r)[known] ** 2 / variance
    score = 2 * np.log((1 - STRAY) * spread / np.sqrt(2 * np.pi * variance) * np.exp(-off / 2) + STRAY)
    nearest, steadiest = (np.argsort(order, kind="stable")[:MATES] for order in (near, variance))
    return float(3 * min(score[nearest].mean(), score[steadiest].mean()))


def spread(paths: Paths) -> float:
    """L of (3), mm: how far apart two samples of a trial usually are."""
    xyz = paths.xyz[paths.seen]
    return float(np.linalg.norm(xyz.std(0)) * np.sqrt(2)) + LEAST_MM if len(xyz) else LEAST_MM


def _mates(paths: Paths, p: int, frames: Ints) -> _Mates:
    """In these frames of path p."""
    r = np.linalg.norm(paths.xyz[:, frames] - paths.xyz[p, frames], axis=-1)
    enough = np.isfinite(r).sum(1) >= FEWEST
    enough[p] = False
    middle, variance = np.full((2, len(r)), np.nan)
    if enough.any():
        middle[enough] = row_medians(r[enough])
        steady = SD_PER_MEDIAN * row_medians(np.abs(r[enough] - middle[enough, None]))
        variance[enough] = np.maximum(steady**2, paths.sd[enough] ** 2 + paths.sd[p] ** 2) + LEAST_MM**2
    return _Mates(middle, variance)
