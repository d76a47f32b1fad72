"""Samples beside a gap that contradict what is filled in without them.

A marker that drifts off its place before it is lost, or comes back beside it, goes along smoothly: its own motion
(`edges`) shows nothing. The other markers do. So `FIRST` fills each gap once more with REACH samples on both sides
missing, or half of those up to the next gap, lest it know less than in any hold-out gap. With d(t) from that fill to a
sample t, and C(t) the fill's calibrated covariance, the samples on one side of the gap are suspicious, from the gap on,
as long as

    |d(t)| > TIMES √(tr C(t))     and     |d(t)| > the least error of `edges`                              (1)
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import takewhile

import numpy as np

from ...data.array_types import Bools
from ..marker_array import Gap, MarkerArray, Prediction
from ..methods.stage import filler_of
from .choice import CandidateFill
from .expected_error import likeness
from .hold_out import edge_distance

REACH = 10
"""Frames on each side that are looked at; chosen: twice what `edges` looks at, so that a slow drift is left behind."""
TIMES = 2.5
"""Times the standard deviation of a place, without unit; chosen: none of 40 good edges of nine trials was above it
(seed 910), and 88 % of drifts of 10 mm were."""


def contradicted_edges(
    motion: MarkerArray, witnesses: Mapping[Gap, CandidateFill], least_mm: float
) -> dict[Gap, tuple[int, ...]]:
    """Frames that are suspicious by (1), of gaps that have any.

    Args:
        motion: the trial.
        witnesses: how `FIRST` did in the hold-out gaps, by the gaps to look at.
        least_mm: of (1), mm.
    """
    found = {}
    for gap, by in witnesses.items():
        longer = _longer(motion.seen[gap.marker], gap)
        (again,) = filler_of(by.method)(motion.hidden([longer]), [longer], method=by.method)
        beyond = np.flatnonzero(_beyond(motion, longer, again, by, least_mm)) + longer.start
        if frames := _next_to(gap, set(beyond.tolist())):
            found[gap] = frames
    return found


def _longer(seen: Bools, gap: Gap) -> Gap:
    """A gap with what is hidden beside it: up to REACH frames on each side, and half of those that are seen there."""
    before, after = seen[: gap.start][::-1], seen[gap.stop :]
    reach = [min(REACH, int(np.argmin(np.append(side, False))) // 2) for side in (before, after)]
    return Gap(gap.marker, gap.start - reach[0], gap.stop + reach[1])


def _beyond(motion: MarkerArray, gap: Gap, prediction: Prediction, by: CandidateFill, least_mm: float) -> Bools:
    """(L) in which frames of a gap the marker is seen where (1) holds; nowhere if no test tells of it."""
    weights = likeness([result.test for result in by.results], gap)
    cov = by.calibration.covariance(prediction, edge_distance(motion, gap), weights)
    d = np.linalg.norm(motion.xyz[gap.marker, gap.start : gap.stop] - prediction.xyz, axis=1)
    return np.asarray((d > TIMES * np.sqrt(np.trace(cov, axis1=1, axis2=2))) & (d > least_mm))


def _next_to(gap: Gap, beyond: set[int]) -> tuple[int, ...]:
    """Those of the frames that are in one piece with a gap, and at most REACH on each side."""
    before = takewhile(beyond.__contains__, range(gap.start - 1, gap.start - 1 - REACH, -1))
    after = takewhile(beyond.__contains__, range(gap.stop, gap.stop + REACH))
    return tuple(sorted([*before, *after]))
