"""What is said of each gap, and a trial with its gaps filled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from ..data import Trajectories

GapState = Literal[
    "filled",
    "not_predicted",
    "no_hold_out",
    "above_limit",
    "sd_contradicts",
    "jump_contradicts",
    "sides_contradict",
    "left_open",
]
"""What became of a gap: filled; open, since no method has a prediction, since no hold-out gap could be made that would
tell the error, since more error is expected than is allowed, since the largest standard deviation in it or a jump
contradicts the error expected (`judge.contradiction`), since the marker is elsewhere on its body after the gap
(`judge.two_sides`), or since somebody chose so."""


@dataclass(frozen=True, slots=True)
class FilledGap:
    """One gap and what became of it.

    Attributes:
        marker: its name; start, stop: its frames, from 0, stop excluded.
        method: name of the method that filled it; empty when it stays open.
        expected_mm: mean error expected of the fill, from hold-out gaps; NaN where none could be made.
        candidates: expected mean error of every method that was tried, mm; infinite where it had no prediction. In
            trials of many gaps by the tests alone for a method that was not asked about this gap.
        tests: number of hold-out gaps made for this gap; some have none of their own where there is one method alone.
        reference_markers: those that it was filled from.
        trimmed: frames of the gap that had been measured and are taken to be wrong; filled too, unless it stays open.
        sd_mm: largest standard deviation of an axis in it; NaN where none is known.
        jump_mm: by how much the fill jumps more than the marker and its reference markers do.
        sides_mm: by how much the marker is elsewhere on its body after it, where both sides cannot be one marker at one
            place (`judge.two_sides`); else 0.
        motion_ratio: how many times as much the body part moves in it as in any hold-out gap that tells its error
            (`judge.motion`); much above 1, the error is expected by what those show of how errors grow. NaN: not known.
        suspicious: measured frames beside the gap that stand out from the marker's own motion, or that the fill made
            without them contradicts; kept as they are.
        off_mm: how far the farthest of these is from that fill, which then stands in the gap and steps there; 0 where
            the fill is tied to them.
        state: filled, or why it stays open.
        reason: what the method lacked where it has no prediction; else empty.
    """

    marker: str
    start: int
    stop: int
    method: str
    expected_mm: float
    candidates: Mapping[str, float] = field(default_factory=dict)
    tests: int = 0
    reference_markers: tuple[str, ...] = ()
    trimmed: tuple[int, ...] = ()
    suspicious: tuple[int, ...] = ()
    off_mm: float = 0.0
    sd_mm: float = np.nan
    jump_mm: float = 0.0
    sides_mm: float = 0.0
    motion_ratio: float = np.nan
    state: GapState = "filled"
    reason: str = ""

    @property
    def expected_of(self) -> dict[str, float]:
        """Mean error expected of each method, mm: by its hold-out gaps, and no less than is expected of the fill where
        samples beside the gap are suspicious, which hold-out gaps do not have, and each method rests on them."""
        least = self.expected_mm if self.suspicious and np.isfinite(self.expected_mm) else 0.0
        return {name: max(mm, least) for name, mm in self.candidates.items()}

    @property
    def length(self) -> int:
        """Frames."""
        return self.stop - self.start


class Filled(NamedTuple):
    """A trial with its gaps filled, and what is to be said of each gap."""

    trajectories: Trajectories
    gaps: tuple[FilledGap, ...]
