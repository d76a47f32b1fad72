"""What distances from other markers say of who is who: the body keeps its shape.

Of a path before and after a place, in windows of WINDOW_S, the distances from each other path k have means μ and
standard deviations s. Markers of the same segment keep theirs, so where the two halves are one marker,

    z_k = (μ_after − μ_before) / √(s_before² + s_after² + SLACK²)                                          (1)

is small for those k whose distance was steadiest before. The misfit is the mean of 2 ln(1 + z²/3), as of Student's t
with three degrees of freedom, over the COMPANIONS steadiest (2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats
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
