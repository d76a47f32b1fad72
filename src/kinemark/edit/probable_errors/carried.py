"""Where what is near a path carries it as a rigid body: what a marker does with its neighbours is motion.

Of the NEAR nearest paths those COMPANIONS whose distance changes least carry it: of a segment, its markers; where it
has too few, those of its neighbours.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...data.array_types import Floats, Ints
from ...geometry.align import best_rotations, rigid_align
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


def left_together_mm(paths: Paths, some: Ints, f: int, g: int) -> Floats:
    """(N) `left_mm` of several paths (N) in frame g from frame f, all worked out at once."""
    own_f, own_g = paths.xyz[:, f], paths.xyz[:, g]
    d_f, d_g = (np.linalg.norm(own - own[some][:, None], axis=2) for own in (own_f, own_g))
    d_f[np.arange(len(some)), some] = np.nan
    sums, change = (np.where(np.isfinite(d_f + d_g), d, np.inf) for d in (d_f + d_g, np.abs(d_g - d_f)))
    near = np.argsort(sums, axis=1)[:, :NEAR]
    change = np.take_along_axis(change, near, 1)
    order = np.argsort(change, axis=1)[:, :COMPANIONS]
    near, known = np.take_along_axis(near, order, 1), np.isfinite(np.take_along_axis(change, order, 1))
    n = known.sum(1)
    weight = (known / np.maximum(n, 1)[:, None])[..., None]
    a, b = (np.where(known[..., None], own[near], 0.0) for own in (own_f, own_g))
    ca, cb = (weight * a).sum(1), (weight * b).sum(1)
    R = best_rotations(((b - cb[:, None]) * (weight > 0)).mT @ (a - ca[:, None]))
    carried = cb + (R @ (own_f[some] - ca)[..., None])[..., 0]
    return np.where(n < 3, np.nan, np.linalg.norm(own_g[some] - carried, axis=1))


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
        """mm that those nearest to p leave what carries them from frame f to g, the median; p's own is known then."""
        there = self.paths.seen[:, f] & self.paths.seen[:, g]
        there[p] = False
        near = np.flatnonzero(there)
        d = np.linalg.norm(self.paths.xyz[near, f] - self.paths.xyz[p, f], axis=1)
        some = near[np.argsort(d, kind="stable")[:BESIDE]]
        new = np.array([q for q in (*some.tolist(), p) if (q, f, g) not in self.known], np.int64)
        if len(new):
            left = left_together_mm(self.paths, new, f, g).tolist()
            self.known.update({(q, f, g): mm for q, mm in zip(new.tolist(), left, strict=True)})
        return _median(self.known[q, f, g] for q in some.tolist())


def _median(some: Iterable[float]) -> float:
    """Of those that are known; 0 where none is."""
    known = [value for value in some if np.isfinite(value)]
    return float(np.median(known)) if known else 0.0
