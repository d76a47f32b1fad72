"""Why a decision of the tracking was close, how a source of error is known, and why a gap stays open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..formatting import number

REASONS = {
    "came_near": "came within {distance_mm} mm of each other, nearer than their positions were certain",
    "stitched_with_rival": "were stitched over a gap, but another stitch was nearly as likely",
    "not_stitched_with_rival": "may be one marker with a gap, but another stitch was nearly as likely",
    "exchange_as_likely": "were lost at the same time, and their motion fits about as well if they were exchanged",
    "found_again": "lost, and found again where its position was known to {sd_mm} mm only",
    "little_evidence": "a marker is only {likelihood_ratio} times likelier than a chance meeting of images",
    "stitched_over_wide_gap": "were stitched over a gap, but its motion alone leaves {sd_mm} mm open",
    "not_stitched_over_wide_gap": "may be one marker with a gap, but its motion alone leaves {sd_mm} mm open",
    "shared_images": "lived on images in which markers run together",
}
"""By `AmbiguousDecision.reason`, what is wrong most often first: at 25 and 30 Hz (benchmarks/tracking_scenes.py) one in
10 to 20 of those that came near, and one in a hundred of those that were found again."""


def reason_text(decisions: Sequence[Mapping[str, Any]]) -> str:
    """The reason of one decision, or of several with the same reason: their numbers from the least to the greatest."""
    first = decisions[0]
    values = {name: _span([one["values"].get(name) for one in decisions]) for name in first["values"]}
    return REASONS[first["reason"]].format_map(values)


def place_of_reason(decisions: Sequence[Mapping[str, Any]]) -> int:
    """Of decisions with the same reason: its place among all, what is wrong most often first."""
    return list(REASONS).index(decisions[0]["reason"])


def _span(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    low, high = (number(f(known), 0) if known else "–" for f in (min, max))
    return low if low == high else f"{low}–{high}"


SOURCE_ADVICE = {
    "disturbed images": "Find the camera from which limb or clothes hide the marker; add one there, or move it.",
    "centroid noise": "Average over more cycles, or filter. Larger markers and longer lenses make larger images.",
    "lens model": "Linearise the cameras with a grid, or allow more lens terms; the maps show which camera.",
    "calibration": "Calibrate again, waving the wand through the whole volume, and before every session.",
    "marker placement": "Palpate twice, one examiner a subject, joint centres found from motion. Cameras cannot help.",
}
"""What helps against each source of error."""

EVIDENCE = {
    "given": "as given",
    "residual_scatter": "scatter of the residuals",
    "calibration_residuals": "residuals of the calibration",
    "usual_noise": "assumed: no marker is seen by three cameras",
    "residuals_of_regions": "residuals that are alike in one part of an image",
    "outlying_residuals": "points with residuals far beyond all others",
    "residuals_of_cameras": "a change of the cameras that the residuals ask for; scale cannot be seen",
    "calibration_covariance": "covariance of the calibration",
    "usual_placement": "assumed, {mm:.4g} mm along each axis",
}
"""By `ErrorSource.evidence`."""


def evidence_text(source: Mapping[str, Any]) -> str:
    """How a source of the ranking is known."""
    return EVIDENCE[source["evidence"]].format(mm=source["mm"] if source["mm"] is not None else float("nan"))


def open_gap_text(gap: Mapping[str, Any], limit_mm: float) -> str:
    """Of a gap in the figures of a filling; a dash where it is filled."""
    match gap["state"]:
        case "above_limit":
            expected = {name: mm for name, mm in gap["candidates_mm"].items() if mm == gap["expected_mm"]}
            which = f"the best method ({', '.join(expected)})" if expected else "it"
            return (
                f"{which} is expected to be off by {gap['expected_mm']:.1f} mm, "
                f"more than the limit of {limit_mm:.4g} mm"
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
        case "sides_contradict":
            return (
                f"before and after it the marker lies {gap['sides_mm']:.0f} mm apart on its body: it is another "
                "marker, or was put on anew"
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
