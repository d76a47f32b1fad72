"""Samples beside a gap that seem to contradict what is filled in without them.

A marker that drifts off its place before it is lost, or comes back beside it, goes along smoothly: its own motion
(`edges`) shows nothing. The other markers do. So `FIRST` fills each gap once more with REACH samples on both sides
missing, or half of those up to the next gap, lest it know less than in any hold-out gap. With d(t) from that fill to a
sample t, and C(t) the fill's calibrated covariance, the samples on one side of the gap are suspicious, from the gap on,
as long as

    |d(t)| > TIMES √(tr C(t))     and     |d(t)| > the least error of `edges`                              (1)

Where that is more than half of the frames of a side, twice as many are looked at there: the drift may reach farther. It
begins by less than (1) tells. So on a side where it finds samples that do not stand out from the marker's own
motion, all that were looked at say nothing of the gap.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import count, takewhile
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats
from ..marker_array import Gap, MarkerArray, Prediction
from ..methods.stage import filler_of
from .choice import CandidateFill
from .expected_error import likeness
from .hold_out import edge_distance

REACH = 10
"""Frames on each side that are looked at; chosen: twice what `edges` looks at, so that a slow drift is left behind."""
FARTHEST = 40
"""Frames to which this grows, twofold each time; chosen: two of 18 drifts of up to 15 samples reached beyond 10."""
TIMES = 2.5
"""Times the standard deviation of a place, without unit; chosen: none of 40 good edges of nine trials was above it
(seed 910), and 88 % of drifts of 10 mm were."""


class ContradictedEdge(NamedTuple):
    """Samples beside a gap by (1).

    Attributes:
        frames: theirs.
        looked_at: the gap with all frames on both sides that were looked at.
    """

    frames: tuple[int, ...]
    looked_at: Gap

    def ignored(self, gap: Gap, own: Collection[int]) -> set[int]:
        """Frames that say nothing of the gap; `own` stand out from the marker's own motion."""
        drift = set(self.frames).difference(own)
        sides = range(self.looked_at.start, gap.start), range(gap.stop, self.looked_at.stop)
        return {*self.frames, *(frame for side in sides if drift.intersection(side) for frame in side)}


def contradicted_edges(
    motion: MarkerArray, witnesses: Mapping[Gap, CandidateFill], least_mm: float
) -> dict[Gap, ContradictedEdge]:
    """What is suspicious by (1), of gaps beside which anything is.

    Args:
        motion: the trial.
        witnesses: how `FIRST` did in the hold-out gaps, by the gaps to look at.
        least_mm: of (1), mm.
    """
    looked = {gap: _looked_at(motion, gap, by, least_mm) for gap, by in witnesses.items()}
    return {gap: one for gap, one in looked.items() if one.frames}


def _looked_at(motion: MarkerArray, gap: Gap, by: CandidateFill, least_mm: float) -> ContradictedEdge:
    """(1) beside one gap; farther away, step by step, on a side of which most is contradicted."""
    reach = [REACH, REACH]
    while True:
        longer = _longer(motion.seen[gap.marker], gap, reach)
        (again,) = filler_of(by.method)(motion.hidden([longer]), [longer], method=by.method)
        d = np.linalg.norm(motion.xyz[gap.marker, longer.start : longer.stop] - again.xyz, axis=1)
        beyond = (d > TIMES * _sd(motion, longer, again, by)) & (d > least_mm)
        sides = _next_to(gap, set((np.flatnonzero(beyond) + longer.start).tolist()))
        more = [
            2 * far if len(side) > far // 2 and far < FARTHEST else far for side, far in zip(sides, reach, strict=True)
        ]
        if more == reach:
            return ContradictedEdge((*sides[0][::-1], *sides[1]), longer)
        reach = more


def _longer(seen: Bools, gap: Gap, reach: Sequence[int]) -> Gap:
    """A gap with what is hidden beside it: up to so many frames on each side, and half of those that are seen there."""
    before, after = seen[: gap.start][::-1], seen[gap.stop :]
    hide = [min(far, int(np.argmin(np.append(s, False))) // 2) for s, far in zip((before, after), reach, strict=True)]
    return Gap(gap.marker, gap.start - hide[0], gap.stop + hide[1])


def _sd(motion: MarkerArray, gap: Gap, prediction: Prediction, by: CandidateFill) -> Floats:
    """(L) mm, √(tr C) of (1); NaN if no test tells of it."""
    weights = likeness([result.test for result in by.results], gap)
    cov = by.calibration.covariance(prediction, edge_distance(motion, gap), weights)
    return np.asarray(np.sqrt(np.trace(cov, axis1=1, axis2=2)))


def _next_to(gap: Gap, beyond: set[int]) -> list[list[int]]:
    """Those of the frames that are in one piece with a gap, before and after it, the nearest first."""
    sides = range(gap.start - 1, -1, -1), count(gap.stop)
    return [list(takewhile(beyond.__contains__, side)) for side in sides]
