"""Why a gap stays open."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def open_gap_text(gap: Mapping[str, Any], limit_mm: float) -> str:
    """Of a gap in the figures of a filling; a dash where it is filled."""
    match gap["state"]:
        case "above_limit":
            expected = {name: mm for name, mm in gap["candidates_mm"].items() if mm == gap["expected_mm"]}
            which = f"the best method ({', '.join(expected)})" if expected else "it"
            return (
                f"{which} is expected to be off by {gap['expected_mm']:.1f} mm, more than the limit of {limit_mm:g} mm"
            )
        case "sd_contradicts":
            return (
                f"the largest standard deviation of the fill, {gap['sd_max_mm']:.1f} mm, contradicts "
                f"the error expected, {gap['expected_mm']:.1f} mm"
            )
        case "jump_contradicts":
            return (
                f"the fill jumps by {gap['jump_mm']:.1f} mm more than the marker does elsewhere, which contradicts the "
                f"error expected, {gap['expected_mm']:.1f} mm"
            )
        case "no_hold_out":
            return "no hold-out gap could be made: too little of the trial is known to estimate the error of a fill"
        case "left_open":
            return "somebody chose to leave it open"
        case "not_predicted":
            return str(gap["reason"])
        case _:
            return "–"


def frames_text(gap: Mapping[str, Any]) -> str:
    """The frames of a gap, as they are numbered in its recording: `1239`, `1216–1225`."""
    first, last = gap["first_frame"], gap["last_frame"]
    return f"{first}" if first == last else f"{first}–{last}"
