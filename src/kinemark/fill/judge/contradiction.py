"""Fills that contradict the error expected of them.

The hold-out gaps tell the expected error ē of a gap. Two figures of the fill itself say when it cannot be true. One is
the largest standard deviation of an axis in it, σ: the gap stays open where

    σ > SD_RATIO ē   and   σ > the limit                                                                  (1)

The other is the largest jump. Of positions p every frame, with the two measured samples on both sides, the second
difference |p(t−1) − 2 p(t) + p(t+1)| is what a jump adds to, whatever the speed. From it is taken off what is usual,
the greater of its 99.5th percentile over all of the marker that is measured and the median of the same frame's over the
reference markers, for fast movements have great ones. The gap stays open where

    jump > JUMP_RATIO ē   and   jump > JUMP_SHARE of the usual limit                                      (2)

Beside suspicious samples (`edges`), which are listed, (2) is not asked: it is they that jump. A limit that is infinite
fills all that can be filled: then neither is asked.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Floats
from ..known_samples import known_median
from ..marker_array import Gap, MarkerArray

SD_RATIO = 5.0
"""Times the expected error, from which the largest standard deviation contradicts it, without unit; chosen: in
36 gaps of the benchmark's trials it was 0.8 to 2.6 times, but where both were below 0.001 mm."""
JUMP_RATIO = 5.0
"""Times the expected error, from which a jump contradicts it, without unit; chosen: in 36 gaps of the benchmark's
trials it was at most 0.2 times."""
JUMP_SHARE = 0.25
"""Of the usual limit of the expected error, below which a jump does no harm; chosen: 5 mm on a person."""


def largest_sd(cov: Floats) -> float:
    """Greatest standard deviation of an axis, mm, of covariances (L, 3, 3); NaN where none is known."""
    variance = np.diagonal(cov, axis1=-2, axis2=-1)
    known = variance[np.isfinite(variance)]
    return float(np.sqrt(known.max())) if len(known) else np.nan


def largest_jump(motion: MarkerArray, gap: Gap, xyz: Floats, references: tuple[int, ...]) -> float:
    """How much the largest second difference of a fill (L, 3) exceeds what is usual, mm; 0 where it does not.

    Args:
        motion: the trial.
        gap: that is filled. xyz: the fill.
        references: rows of the markers that it was filled from.
    """
    around = slice(max(gap.start - 2, 0), gap.stop + 2)
    path = motion.xyz[gap.marker].copy()
    own = second_differences(path)
    known = own[np.isfinite(own)]
    usual = float(np.quantile(known, 0.995)) if len(known) else 0.0
    path[gap.start : gap.stop] = xyz
    found = second_differences(path[around])
    beside = second_differences(motion.xyz[list(references), around]) if references else np.zeros((1, len(found)))
    limit = np.fmax(usual, known_median(beside))
    return float(np.nanmax(np.append(found - limit, 0.0)))


def second_differences(xyz: Floats) -> Floats:
    """(…, F − 2) mm of positions (…, F, 3)."""
    return np.asarray(np.linalg.norm(np.diff(xyz, n=2, axis=-2), axis=-1))


def contradicts_sd(sd: float, expected: float, limit_mm: float) -> bool:
    """(1)."""
    return bool(np.isfinite(limit_mm) and sd > max(SD_RATIO * expected, limit_mm))


def contradicts_jump(jump: float, expected: float, limit_mm: float, usual_mm: float) -> bool:
    """(2), of a trial with that usual limit."""
    return bool(np.isfinite(limit_mm) and jump > max(JUMP_RATIO * expected, JUMP_SHARE * usual_mm))
