"""Is a trial good? The grade that its findings make, and what was measured and how well."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence
from typing import Any

from ..data import Finding, make_finding
from .trial_findings import Figures, calibration_known, used_share
from .verdict import Verdict, grade_of, verdict_of


def trial_verdict(figures: Figures, findings: Sequence[Finding]) -> Verdict:
    """The grade that the findings make, and statements on what was measured and how well.

    How good positions are nobody knows where the calibration states no error: they are neither good nor usable with
    care.
    """
    grade = grade_of(findings)
    headline = {"green": "trial_good", "amber": "trial_usable", "red": "trial_unusable"}[grade]
    if grade != "red" and not calibration_known(figures):
        headline = "trial_unknown"
    return verdict_of(findings, (make_finding(headline), *_statements(figures)))


def _statements(figures: Figures) -> Iterator[Finding]:
    recording, markers = figures["recording"], figures["trajectories"]
    nameless = any(one["name"].startswith("*") for one in markers["markers"])
    fragments = nameless and markers["count"] != markers["markers_worn"]
    yield make_finding(
        "recorded",
        camera_count=len(figures["cameras"]),
        marker_count=markers["markers_worn"] if fragments else markers["count"],
        track_count=markers["count"] if fragments else None,
        duration_s=recording["duration_s"],
        frame_count=recording["frames"],
        rate_hz=recording["rate_hz"],
    )
    if markers["samples"]:
        yield _complete(figures)
    if (median := figures["points"]["residual_median_px"]) is not None:
        pixels = [c["pixel_at_subject_mm"] for c in figures["cameras"] if c["pixel_at_subject_mm"] is not None]
        at_subject = median * statistics.median(pixels) if pixels else None
        yield make_finding("agreement", residual_px=median, at_subject_mm=at_subject)
    if markers["sd_per_axis_mean_mm"] is not None:
        noise = markers["jitter_median_mm"]
        sd, known = markers["sd_per_axis_mean_mm"], calibration_known(figures)
        yield make_finding("position_deviation", sd_mm=sd, noise_mm=noise, calibration_known=known)
        if room := figures["calibration"].get("room"):
            yield make_finding("room_deviation_of_trial", sd_mm=room["sd_at_subject_mm"])


def _complete(figures: Figures) -> Finding:
    markers = figures["trajectories"]
    values: dict[str, Any] = {
        "complete_share": markers["completeness_of_found_share"],
        "filled_share": markers["filled_samples"] / markers["samples"],
        "gaps": markers["gaps"],
        "longest_s": markers["longest_gap_s"],
    }
    start = markers["first_frame"]
    frames = [(first + start, stop - 1 + start) for first, stop in markers["in_view_runs"]]
    if (complete := markers["completeness_in_view_share"]) is not None:
        shown = markers["markers_shown"] if markers["markers_shown"] > markers["markers_worn"] else None
        return make_finding("completeness", frames=frames, **values | {"complete_share": complete, "shown": shown})
    return make_finding("completeness_unknown", frames=frames, used_share=used_share(figures), **values)
