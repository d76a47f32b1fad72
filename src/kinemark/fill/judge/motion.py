"""How much the part of the body around a marker moves: what makes one gap harder than another of its length.

A marker that is lost in fast motion is not seen in it anywhere else, while windows at rest abound. Where the marker is
missing, the REFERENCES markers that move with it best, of those that are seen there, tell: with x_k their positions at
instants STEP_S apart, the part covers from one to the next

    p = median over k of |Δx_k|,     a = median over k, l of |Δ(x_k − x_l)| / |x_k − x_l|                 (1)

in millimetres, and in radians turned. Where a whole segment is lost those markers are another segment's and may rest
while it moves. What is known of it then is from where to where the marker went: d, between the samples beside the gap.
With P and A the sums over a window, its motion is

    m = √( (max(P, d) + PATH) (A + TURN) )                                                                (2)

Windows that stand for a gap are measured by the same markers as the gap is, or they would be compared with something
else. What noise alone makes of the sums is below PATH and TURN in short windows.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ...data.array_types import Floats, Ints
from ..known_samples import known_median
from ..marker_array import Gap, MarkerArray
from ..reference_ranking import Ranks

REFERENCES = 4
"""Markers that tell how a part moves; chosen."""
STEP_S = 0.04
"""s between the instants; chosen: noise of frame after frame would sum up to a path."""
PATH = 5.0
"""mm of path below which windows do not differ; chosen."""
References = tuple[int, ...]
"""Markers by which a motion is measured."""
TURN = 0.05
"""rad of turning below which windows do not differ; chosen."""


class PartMotion:
    """The motion of the parts of a trial, for each marker worked out when it is first asked for."""

    def __init__(self, motion: MarkerArray) -> None:
        """Of a trial."""
        self.ranks, self.all = Ranks(motion), motion.xyz
        self.at: Ints = np.arange(0, motion.xyz.shape[1], max(1, round(STEP_S * motion.rate)))
        self.xyz = motion.xyz[:, self.at]
        self.steps: Floats = np.linalg.norm(np.diff(self.xyz, axis=1), axis=-1)
        self.usual = known_median(self.steps)
        self._sums: dict[References, Floats] = {}

    def references(self, gap: Gap) -> References:
        """The markers that tell of a gap: the first that are seen throughout it, or of all where none is."""
        near = self.ranks.of(gap.marker)
        within = slice(*np.searchsorted(self.at, (gap.start - 1, gap.stop + 1)))
        seen = near[~np.isnan(self.xyz[near, within, 0]).any(1)]
        return tuple((seen if len(seen) else near)[:REFERENCES].tolist())

    def of(self, marker: int, start: Ints | int, length: int, references: References) -> Floats:
        """m of (2) of windows of so many frames from `start` (N) on: (N) √(mm rad), as these markers tell it."""
        sums = self._sums.get(references)
        if sums is None:
            sums = self._sums[references] = self._summed(references)
        before, after = np.asarray(start) - 1, np.asarray(start) + length
        path, turn = (np.interp(after, self.at, s) - np.interp(np.maximum(before, 0), self.at, s) for s in sums)
        path = np.fmax(path, self._distance(marker, before, after))
        return np.asarray(np.sqrt((path + PATH) * (turn + TURN)))

    def of_gap(self, gap: Gap, references: References | None = None) -> float:
        """The same of one window; by the markers that tell of it as a gap where none are given."""
        by = self.references(gap) if references is None else references
        return float(self.of(gap.marker, gap.start, gap.length, by))

    def _distance(self, marker: int, before: Ints, after: Ints) -> Floats:
        """d of (2), (N) mm; NaN where one of the samples is not known."""
        last = self.all.shape[1] - 1
        d = self.all[marker, np.minimum(after, last)] - self.all[marker, np.maximum(before, 0)]
        return np.where((before >= 0) & (after <= last), np.linalg.norm(d, axis=-1), np.nan)

    def _summed(self, references: References) -> Floats:
        """(2, instants) path in mm and turning in rad since the first."""
        near = list(references)
        path = known_median(self.steps[near])
        path = np.where(np.isnan(path), self.usual, path)
        apart = [self.xyz[k] - self.xyz[j] for k, j in combinations(near, 2)]
        turn = known_median(np.array([_turned(d) for d in apart]).reshape(len(apart), len(path)))
        steps = np.nan_to_num(np.stack([path, turn]))
        return np.concatenate([np.zeros((2, 1)), np.cumsum(steps, axis=1)], axis=1)


def _turned(apart: Floats) -> Floats:
    """|Δd| / |d| of the difference (N, 3) of two markers: (N − 1)."""
    size = np.linalg.norm(apart, axis=1)
    return np.asarray(np.linalg.norm(np.diff(apart, axis=0), axis=1) / np.maximum(size[:-1], 1.0))
