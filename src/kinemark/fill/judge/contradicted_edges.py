"""Samples beside a gap that contradict what is filled in without them.

A marker that drifts off its place before it is lost, or comes back beside it, goes along smoothly: its own motion
(`edges`) shows nothing. The other markers do. So `FIRST` fills each gap once more with REACH samples on both sides
missing. With d(t) from that fill to a sample t, and C(t) the fill's calibrated covariance, the samples on one side of
the gap are suspicious, from the gap on, as long as

    |d(t)| > TIMES √(tr C(t))     and     |d(t)| > the least error of `edges`                              (1)
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby, takewhile

import numpy as np

from ...data.array_types import Bools
from ..marker_array import Gap, MarkerArray, Prediction
from ..methods.stage import filler_of
from .choice import CandidateFill
from .doubtful_edges import unseen_around
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
    for _, group in groupby(sorted(witnesses), key=lambda gap: gap.marker):
        own = list(group)  # of one marker: those of others stay, as references
        by = witnesses[own[0]]
        hidden = motion.hidden(Gap(gap.marker, max(gap.start - REACH, 0), gap.stop + REACH) for gap in own)
        longer = [unseen_around(hidden.seen[gap.marker], gap) for gap in own]
        again = filler_of(by.method)(hidden, longer, method=by.method)
        for gap, more, prediction in zip(own, longer, again, strict=True):
            beyond = np.flatnonzero(_beyond(motion, more, prediction, by, least_mm)) + more.start
            if frames := _next_to(gap, set(beyond.tolist())):
                found[gap] = frames
    return found


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
