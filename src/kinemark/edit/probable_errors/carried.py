"""Where what is near a path carries it as a rigid body: what a marker does with its neighbours is motion.

Of the NEAR nearest paths those COMPANIONS whose distance changes least carry it: of a segment, its markers; where it
has too few, those of its neighbours.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...geometry.align import rigid_align
from .paths import Paths

LEAST_MM = 1.0
"""mm below which distances do not differ; chosen."""
NEAR, COMPANIONS = 12, 5
"""Nearest paths, and those of them that carry; chosen."""

USUAL_S, TESTS = 1.0, 24
"""s on each side of a place in which a path says how fast it leaves its companions otherwise, and its steps there that
do; chosen: a stride, in which half of the steps may be wrong. Who lies first, and runs then, leaves faster later on."""

BESIDE = 7
"""Nearest paths that say how much what is near a path leaves what carries it; chosen: more than a segment has, so that
three of them may leap as well."""


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


class Leaving:
    """How paths leave their companions, each step and pair of frames worked out once."""

    def __init__(self, paths: Paths) -> None:
        self.paths = paths
        self.known: dict[tuple[int, int, int], float] = {}

    def mm(self, p: int, f: int, g: int) -> float:
        """`left_mm` of path p from frame f to frame g."""
        key = p, f, g
        if key not in self.known:
            self.known[key] = left_mm(self.paths, p, g, f)
        return self.known[key]

    def usual(self, p: int, f: int, g: int) -> float:
        """mm a frame, the median of steps of path p near to those from frame f to g."""
        own, far = self.paths.frames[p], USUAL_S * self.paths.rate
        near = own[np.searchsorted(own, f - far) : np.searchsorted(own, g + far)]
        steps = near[:-1][np.diff(near) == 1]
        steps = steps[(steps < f) | (steps >= g)]
        every = max(1, round(2 * far / TESTS))
        return _median(self.mm(p, int(step), int(step) + 1) for step in steps[steps % every == 0])

    def beside(self, p: int, f: int, g: int) -> float:
        """mm that the paths nearest to p leave what carries them from frame f to g, the median."""
        there = self.paths.seen[:, f] & self.paths.seen[:, g]
        there[p] = False
        near = np.flatnonzero(there)
        d = np.linalg.norm(self.paths.xyz[near, f] - self.paths.xyz[p, f], axis=1)
        return _median(self.mm(int(q), f, g) for q in near[np.argsort(d, kind="stable")[:BESIDE]])


def _median(some: Iterable[float]) -> float:
    """Of those that are known; 0 where none is."""
    known = [value for value in some if np.isfinite(value)]
    return float(np.median(known)) if known else 0.0
