"""Where what is near a path carries it as a rigid body: what a marker does with its neighbours is motion.

Of the NEAR nearest paths those COMPANIONS whose distance changes least carry it: of a segment, its markers; where it
has too few, those of its neighbours.
"""

from __future__ import annotations

import numpy as np

from ...geometry.align import rigid_align
from .paths import Paths

LEAST_MM = 1.0
"""mm below which distances do not differ; chosen."""
NEAR, COMPANIONS = 12, 5
"""Nearest paths, and those of them that carry; chosen."""


def left_mm(paths: Paths, p: int, to: int, *others: int) -> float:
    """How far path p is in frame `to` from where it is carried from the other frames, in the mean, mm; NaN where fewer
    than three paths are near it in all of them."""
    frames = [*others, to]
    own = paths.xyz[:, frames]
    d = np.linalg.norm(own - own[p], axis=2)
    d[p] = np.nan
    first, last = d[:, np.argmin(frames)], d[:, np.argmax(frames)]
    near = np.flatnonzero(np.isfinite(d).all(1))
    near = near[np.argsort(first[near] + last[near])][:NEAR]
    near = near[np.argsort(np.abs(last[near] - first[near]))][:COMPANIONS]
    if len(near) < 3:
        return float("nan")
    carried = [R @ own[p, k] + t for k in range(len(others)) for R, t in [rigid_align(own[near, k], own[near, -1])]]
    return float(np.linalg.norm(own[p, -1] - np.mean(carried, axis=0)))
