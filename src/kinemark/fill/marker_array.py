"""What fillers work on: all markers of a trial as one array, and the gaps in it.

A filler is a function `filler(motion, gaps, method=…) -> list[Prediction]`, one prediction for each gap. It may read
all that is not NaN in `motion`, before, during and after the gap; nothing else tells it which samples are missing, so
that hiding a part of a trial (`hidden`) and filling it again is a fair test of a filler. What is the same for many gaps
of one call (a mean shape, sums of products) is worked out once a call.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs


class Gap(NamedTuple):
    """Frames `start` to `stop` − 1 of one marker, counted from 0."""

    marker: int
    start: int
    stop: int

    @property
    def length(self) -> int:
        """Frames."""
        return self.stop - self.start


class MarkerArray(NamedTuple):
    """All markers of a trial.

    Attributes:
        xyz: (M, F, 3) mm, marker-major, NaN where missing.
        rate: frames a second, Hz.
        names: (M).
    """

    xyz: Floats
    rate: float
    names: tuple[str, ...]

    @classmethod
    def of(cls, trajectories: Trajectories) -> MarkerArray:
        """The markers of a trial; what is filled counts as seen."""
        return cls(trajectories.xyz, trajectories.rate, trajectories.names)

    @property
    def seen(self) -> Bools:
        """(M, F)."""
        return ~np.isnan(self.xyz[..., 0])

    def hidden(self, gaps: Iterable[Gap]) -> MarkerArray:
        """The same with all samples in the gaps missing."""
        xyz = self.xyz.copy()
        for gap in gaps:
            xyz[gap.marker, gap.start : gap.stop] = np.nan
        return self._replace(xyz=xyz)


class Prediction(NamedTuple):
    """What a filler says of one gap of L frames.

    Attributes:
        xyz: (L, 3) mm, NaN where it has no prediction.
        cov: (L, 3, 3) mm², what the method itself takes its error to be, NaN where it does not say.
        reason: why it has no prediction, in words for the user; empty where it has.
        references: markers that it was filled from.
    """

    xyz: Floats
    cov: Floats
    reason: str = ""
    references: tuple[int, ...] = ()

    @classmethod
    def none(cls, length: int, reason: str) -> Prediction:
        """No value at all, and why."""
        return cls(np.full((length, 3), np.nan), np.full((length, 3, 3), np.nan), reason)


def find_gaps(motion: MarkerArray, *, ends: bool = False) -> list[Gap]:
    """The gaps of all markers, by marker and frame.

    Args:
        motion: the trial.
        ends: also those before a marker's first sample and after its last; a marker never seen is not a gap.
    """
    gaps = []
    for marker, seen in enumerate(motion.seen):
        if seen.any():
            missing = true_runs(~seen).tolist()
            gaps += [Gap(marker, a, b) for a, b in missing if ends or (a > 0 and b < len(seen))]
    return gaps
