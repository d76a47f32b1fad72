"""Why a decision of the tracking was close."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..formatting import number

REASONS = {
    "came_near": "came within {distance_mm} mm of each other, nearer than their positions were certain",
    "found_again": "lost, and found again where its position was known to {sd_mm} mm only",
    "jumped": "jumped by {jump_mm} mm",
    "shared_images": "lived on images in which markers run together",
    "little_evidence": "a marker is only {likelihood_ratio} times likelier than a chance meeting of images",
    "stitched_with_rival": "were stitched over a gap, but another stitch was nearly as likely",
    "stitched_over_wide_gap": "were stitched over a gap, but its motion alone leaves {sd_mm} mm open",
    "not_stitched_with_rival": "may be one marker with a gap, but another stitch was nearly as likely",
    "not_stitched_over_wide_gap": "may be one marker with a gap, but its motion alone leaves {sd_mm} mm open",
}
"""By `AmbiguousDecision.reason`."""


def reason_text(decisions: Sequence[Mapping[str, Any]]) -> str:
    """The reason of one decision, or of several with the same reason: their numbers from the least to the greatest."""
    first = decisions[0]
    values = {name: _span([one["values"].get(name) for one in decisions]) for name in first["values"]}
    return REASONS[first["reason"]].format_map(values)


def _span(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    low, high = (number(f(known), 0) if known else "–" for f in (min, max))
    return low if low == high else f"{low}–{high}"
