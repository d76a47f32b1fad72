"""Filling gap by gap: what all gaps share is worked out once, then each gap is asked for by itself.

    prepared = prepare(trajectories)
    prepared.candidates("LKNE", 751)       # every quick method's fill of the gap that frame 751 lies in
    prepared.best("LKNE", 751)             # what `fill` with `auto` would choose

A gap is judged by hold-out gaps of its own, drawn as `fill` draws them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats
from .filled_gap import FilledGap
from .judge.auto import Auto
from .judge.choice import choose_candidate
from .marker_array import Gap, MarkerArray, find_gaps
from .methods.polynomials import Cubic, Linear
from .methods.quintic import Quintic

QUICK = (Linear(), Cubic(), Quintic())
"""Methods of the first answer; those that take milliseconds."""


@dataclass(frozen=True, slots=True, eq=False)
class GapFill:
    """How one gap of L frames may be filled.

    Attributes:
        gap: what is said of it, with method, expected error in mm, reference markers, and why it has no fill.
        first: number of its first frame in the recording.
        xyz: (L, 3) mm, NaN where the method has no prediction. cov: (L, 3, 3) mm², NaN where unknown.
    """

    gap: FilledGap
    first: int
    xyz: Floats
    cov: Floats

    @property
    def method(self) -> str:
        """Its name."""
        return self.gap.method

    @property
    def expected_mm(self) -> float:
        """Mean error expected, mm; infinite where there is no prediction, NaN where nothing tells."""
        return self.gap.expected_mm

    @property
    def sd(self) -> Floats:
        """(L, 3) mm."""
        return np.sqrt(np.diagonal(self.cov, axis1=1, axis2=2))


@dataclass(frozen=True, slots=True, eq=False)
class PreparedFill:
    """A trial whose gaps can be asked for one by one.

    Attributes:
        trajectories: the trial. motion: its markers as one array. gaps: of all markers.
        method: what chooses. seed: of the places of hold-out gaps.
    """

    trajectories: Trajectories
    motion: MarkerArray
    gaps: tuple[Gap, ...]
    method: Auto = field(default_factory=Auto)
    seed: int = 0

    def gap_at(self, marker: str, frame: int) -> Gap:
        """The gap of a marker that a frame, a number in the recording, lies in.

        Raises:
            KeyError: there is none.
        """
        at = frame - self.trajectories.first_frame
        for gap in self.gaps:
            if self.motion.names[gap.marker] == marker and gap.start <= at < gap.stop:
                return gap
        raise KeyError(f"{marker} has no gap at frame {frame}")

    def candidates(self, marker: str, frame: int, *, methods: Sequence[Any] = QUICK) -> tuple[GapFill, ...]:
        """The gap as each method would fill it, the one with the least expected error first.

        Raises:
            KeyError: there is no gap at that frame.
        """
        gap = self.gap_at(marker, frame)
        return tuple(sorted((self._chosen(gap, (one,)) for one in methods), key=lambda one: _or_inf(one.expected_mm)))

    def best(self, marker: str, frame: int) -> GapFill:
        """The gap as it is filled in the end: by the method that does best, of all that `auto` tries.

        Raises:
            KeyError: there is no gap at that frame.
        """
        return self._chosen(self.gap_at(marker, frame), self.method.methods)

    def _chosen(self, gap: Gap, methods: Sequence[Any]) -> GapFill:
        from .fill import evaluate_candidates

        answers = evaluate_candidates(self.motion, [gap], methods, seed=self.seed)
        found, prediction, cov = choose_candidate(self.motion, [gap], 0, answers)
        return GapFill(found, gap.start + self.trajectories.first_frame, prediction.xyz, cov)


def prepare(
    trajectories: Trajectories, *, method: Auto | None = None, ends: bool = False, seed: int = 0
) -> PreparedFill:
    """A trial whose gaps are asked for one by one.

    Args:
        trajectories: the trial; what is filled already counts as seen.
        method: what chooses; `Auto()` where None. ends: also gaps before a marker's first sample and after its last.
        seed: of the places of the hold-out gaps.
    """
    motion = MarkerArray.of(trajectories)
    return PreparedFill(trajectories, motion, tuple(find_gaps(motion, ends=ends)), method or Auto(), seed)


def _or_inf(mm: float) -> float:
    return mm if np.isfinite(mm) else np.inf
