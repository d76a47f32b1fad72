"""Is a calibration good, and for what? The grade that its findings make, and what was measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ..data import Finding, make_finding
from .trial_findings import Figures
from .verdict import Verdict, verdict_of


def calibration_verdict(figures: Figures, findings: Sequence[Finding]) -> Verdict:
    """The grade, with a headline that says what the calibration is good for, and statements.

    What a calibration that states no uncertainty is good for nobody knows: it is neither good nor usable with care.
    """
    grade = verdict_of(findings, ()).grade
    if grade == "red":
        headline = make_finding("calibration_unusable")
    elif not figures["precision"]["calibration_known"]:
        headline = make_finding("calibration_unknown")
    else:
        kind = "calibration_good" if grade == "green" else "calibration_usable"
        headline = make_finding(kind, **_good_for(figures["precision"]))
    return verdict_of(findings, (headline, *_statements(figures)))


def _good_for(precision: Figures) -> dict[str, Any]:
    """A standard deviation, and in how much of the volume it is not exceeded; None where less than half is seen."""
    for key, share in (("sd_95_mm", 0.95), ("sd_median_mm", 0.5)):
        if precision[key] is not None:
            return {"sd_mm": precision[key], "volume_share": share}
    return {"sd_mm": None, "volume_share": None}


def _statements(figures: Figures) -> Iterator[Finding]:
    fit, precision = figures["fit"], figures["precision"]
    yield make_finding(
        "calibrated_by",
        way=figures["way"],
        camera_count=len(figures["cameras"]),
        residual_px=fit["residual_rms_px"],
        images=fit["images"],
        points=fit["points"],
        left_out_px=fit["left_out_rms_px"],
    )
    if figures["judged"] and figures["judged"]["grade"] == "good":
        yield Finding.of(figures["judged"]["findings"][0])
    yield from _lengths(figures)
    if precision["sd_95_mm"] is not None:
        yield make_finding(
            "predicted_deviation",
            centroid_sd_px=precision["centroid_sd_px"],
            calibration_known=precision["calibration_known"],
            sd_mm=precision["sd_95_mm"],
            largest_axis_mm=precision["largest_axis_95_mm"],
        )
    if figures["room"]:
        keys = {"sd_mm": "sd_95_mm", "turn_deg": "turn_sd_deg", "origin_mm": "centre_sd_mm"}
        yield make_finding("room_deviation", **{name: figures["room"][key] for name, key in keys.items()})
    yield _coverage(figures)


def _lengths(figures: Figures) -> Iterator[Finding]:
    wand = figures["wand"]
    if wand and wand["poses"]:
        yield make_finding(
            "wand_lengths",
            poses=wand["poses"],
            known_mm_list=wand["known_mm"],
            error_abs_mm=wand["error_abs_mean_mm"],
            error_mean_mm=wand["error_mean_mm"],
            error_sd_mm=wand["error_sd_mm"],
        )
    for check in figures["checks"]:
        yield make_finding("length_check", length=check["what"], known_mm=check["known_mm"], found_mm=check["found_mm"])


def _coverage(figures: Figures) -> Finding:
    precision = figures["precision"]
    two, three = (1 - precision[f"fewer_than_{n}_cameras_share"] for n in (2, 3))
    matters = max(figures["cameras"], key=lambda c: c["without"]["ratio_median"] or 0)
    ratio = matters["without"]["ratio_median"] if len(figures["cameras"]) > 2 else None
    named = [] if ratio is None else [matters["name"]]
    return make_finding("volume_seen", cameras=named, two_share=two, three_share=three, ratio=ratio)
