"""What quality.json holds of each gap, as `quality_document` declares the rest."""

from __future__ import annotations

from typing_extensions import TypedDict

from ..fill.filled_gap import GapState
from .quality_types import Count, Number, documented


@documented
class GapData(TypedDict):
    """One gap, and what became of it; frames are numbers in the recording."""

    marker: str
    first_frame: int
    last_frame: int
    first_s: float
    length_s: float
    frames: Count
    method: str
    """Empty where it stayed open."""
    expected_mm: Number
    sd_max_mm: Number
    """Greatest standard deviation of an axis within it, also of a fill that was not kept."""
    jump_mm: float
    """By how much the fill jumps more than the marker and its reference markers do."""
    sides_mm: float
    """By how much the marker is elsewhere on its body after it, where that is no posture; else 0."""
    motion_ratio: Number
    """How many times as much the body part moves in it as in any hold-out gap that tells its error."""
    candidates_mm: dict[str, Number]
    """Expected error of each method."""
    tests: Count
    reference_markers: list[str]
    """Markers that it was filled from."""
    trimmed: list[int]
    """Measured frames that were replaced."""
    suspicious: list[int]
    """Measured frames beside it that stand out from the marker's own motion, or contradict the other markers; kept."""
    off_mm: float
    """How far the farthest of these is off the fill, which does not follow them; 0 where it is tied to them."""
    state: GapState
    """Filled; or open, since no method has a prediction, no hold-out gap could be made, more error is expected than
    `limit_mm`, `sd_max_mm` or `jump_mm` contradicts the error expected, the marker is elsewhere on its body after it
    (`sides_mm`), or since somebody chose so."""
    reason: str
    """What the method lacked where it has no prediction; else empty."""
