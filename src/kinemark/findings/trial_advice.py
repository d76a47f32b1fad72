"""From figures to words: what deserves a look, what to do about it, and the verdict over the whole."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator
from typing import Any

from ..report.formatting import count, measure, number, percent, some

RESIDUAL_RATIO = 3.0
"""A camera stands out when its median residual is above this many times the middle one of the other cameras …"""
RESIDUAL_FLOOR_PX = 0.25
"""… and above this: below it, no camera is in trouble."""
RESIDUAL_AMBER_PX, RESIDUAL_RED_PX = 1.0, 3.0
"""Median residual over all cameras."""
CALIBRATION_AMBER_PX = 1.0
"""RMS residual of one camera's calibration."""
USED_SHARE = 0.6
"""Share of a camera's valid detections that should belong to a point."""
COMPLETE_AMBER, COMPLETE_RED = 0.97, 0.8
"""Share of samples that are present while the subject is in view."""
STRETCH = 0.06
"""How far the focal lengths along u and v may differ, or differ from 2:1 in fields of interlaced video."""
PIECES = 1.3
"""Tracks a marker above which they count as broken."""
LONG_GAP_S = 0.2
"""A gap that interpolation should not bridge unseen: a fifth of a gait cycle."""
FILLED_SHARE = 0.1
"""Share of a marker's samples that may be filled."""
SD_AMBER_MM = 2.0
"""Standard deviation of one axis: about a degree over a segment of 100 mm."""
OUTSIDE_SHARE = 0.02
"""Share of samples that may lie outside the control volume."""

Figures = dict[str, Any]
Remark = dict[str, str]


def warnings(figures: Figures) -> list[Remark]:
    """What deserves a look: severity ("red", "amber" or "info"), what was found, what to do; the gravest first."""
    found = [warning for check in CHECKS for warning in check(figures)]
    return sorted(found, key=lambda warning: ("red", "amber", "info").index(warning["severity"]))


def verdict(figures: Figures) -> dict[str, Any]:
    """grade ("green", "amber" or "red"), a headline, and sentences on what was measured and how well."""
    severities = {warning["severity"] for warning in figures["warnings"]}
    grade = "red" if "red" in severities else "amber" if "amber" in severities else "green"
    headline = {
        "green": "Good to use.",
        "amber": "Usable with care: look at the points below first.",
        "red": "Do not use these data as they are.",
    }[grade]
    return {"grade": grade, "headline": headline, "sentences": list(_sentences(figures))}


def _sentences(figures: Figures) -> Iterator[str]:
    recording, markers = figures["recording"], figures["trajectories"]
    cameras, followed = count(len(figures["cameras"]), "camera"), count(markers["count"], "marker")
    if markers["unlabelled"] and markers["count"] != markers["markers_worn"]:
        followed = f"about {count(markers['markers_worn'], 'marker')}, in {count(markers['count'], 'track')},"
    length = f"{measure(recording['duration_s'], 2, 's')} ({count(recording['frames'], 'frame')}"
    yield f"{cameras} followed {followed} for {length} at {number(recording['rate_hz'])}\u00a0Hz)."
    if markers["samples"]:
        yield _complete(markers)
    if figures["points"]["residual_median_px"] is not None:
        yield _agreement(figures)
    if markers["sd_per_axis_mean_mm"] is not None:
        sd = measure(markers["sd_per_axis_mean_mm"], 2, "mm")
        yield f"The standard deviation of a position is {sd} per axis on average."


def _complete(markers: Figures) -> str:
    first, stop = markers["in_view_frames"]
    there = percent(markers["completeness_in_view_share"])
    filled = markers["filled_samples"] / markers["samples"]
    also = f" ({percent(filled)} of all samples are filled)" if filled else ""
    gaps = f"{count(markers['gaps'], 'gap')} left, the longest {measure(markers['longest_gap_s'], 2, 's')}"
    return (
        f"While the subject was in view (frames {first} to {stop - 1}), {there} of the marker positions "
        f"are there{also}; {gaps if markers['gaps'] else 'no gaps left'}."
    )


def _agreement(figures: Figures) -> str:
    median = figures["points"]["residual_median_px"]
    pixels = [c["pixel_at_subject_mm"] for c in figures["cameras"] if c["pixel_at_subject_mm"] is not None]
    at_subject = f", about {measure(median * statistics.median(pixels), 1, 'mm')} at the subject" if pixels else ""
    return (
        f"Half of all image points lie within {measure(median, 2, 'px')} of where the calibrated cameras expect them"
        f"{at_subject}."
    )


def _say(severity: str, what: str, do: str) -> Iterator[Remark]:
    yield {"severity": severity, "what": what, "do": do}


def _nothing(figures: Figures) -> Iterator[Remark]:
    if not figures["recording"]["frames"]:
        yield from _say(
            "red", "The recording has no frames.", "Check that the trial names the right images or detections."
        )
    elif not any(camera["detections"] for camera in figures["cameras"]):
        yield from _say(
            "red", "No camera saw any marker.", "Lower the threshold in [detect], or check exposure and lights."
        )
    elif not figures["points"]["count"]:
        what = "The cameras saw markers, but no marker was found in space."
        do = "Check that the calibration belongs to this camera set-up and that the cameras are synchronised."
        yield from _say("red", what, "See the diagnostics below." if figures["diagnostics"] else do)
    elif not figures["trajectories"]["samples"]:
        what = "3D points were reconstructed, but no trajectory came of them."
        yield from _say("red", what, "Check the parameters of [track]: shortest, and speed; and rate_hz.")


def _blind(figures: Figures) -> Iterator[Remark]:
    seeing = [c for c in figures["cameras"] if c["detections"]]
    for camera in figures["cameras"]:
        if seeing and not camera["detections"]:
            what = f"Camera {camera['name']} saw nothing in the whole trial."
            yield from _say(
                "amber", what, "Check its cable, lens cap, lights and threshold; then record again or leave it out."
            )


def _unlike_others(figures: Figures) -> Iterator[Remark]:
    for camera in _outliers(figures):
        median, others = camera["residual_median_px"], _others(figures, camera)
        times = f"{number(median / others, 1)} times" if median < 100 * others else "far above"
        u, v = (number(value, 2) for value in camera["offset_px"])
        what = (
            f"Camera {camera['name']} disagrees with the others: its median residual is {measure(median, 2, 'px')}, "
            f"{times} theirs; its image is offset by ({u}, {v})\u00a0px."
        )
        do = "When the offset explains the residual, the camera was moved: calibrate again. "
        yield from _say("amber", what, do + "Otherwise check its focus and its synchronisation.")


def _outliers(figures: Figures) -> list[Figures]:
    """Cameras whose median residual is far above that of the others."""
    return [
        camera
        for camera in figures["cameras"]
        if (camera["residual_median_px"] or 0) > max(RESIDUAL_FLOOR_PX, RESIDUAL_RATIO * _others(figures, camera))
    ]


def _others(figures: Figures, camera: Figures) -> float:
    """Middle one of the median residuals of the other cameras, px; infinite where there is none."""
    medians = [c["residual_median_px"] for c in figures["cameras"] if c is not camera]
    known = [median for median in medians if median is not None]
    return statistics.median(known) if known else math.inf


def _residual(figures: Figures) -> Iterator[Remark]:
    median = figures["points"]["residual_median_px"] or 0
    if median > RESIDUAL_AMBER_PX:
        what = f"The cameras agree poorly: half of all image points are {measure(median, 2, 'px')} or more off."
        severity = "red" if median > RESIDUAL_RED_PX else "amber"
        yield from _say(severity, what, "Calibrate again, lens distortion included, before trusting distances.")


def _calibration(figures: Figures) -> Iterator[Remark]:
    poor = [c["name"] for c in figures["cameras"] if (c["calibration_residual_px"] or 0) > CALIBRATION_AMBER_PX]
    if poor and not figures["calibration"].get("verdict"):
        limit = f"(residual above {number(CALIBRATION_AMBER_PX)}\u00a0px)"
        what = f"The calibration itself is poor {limit} in {some('camera', poor)}."
        yield from _say("amber", what, "Look for misread control points and calibrate again.")


def _judged(figures: Figures) -> Iterator[Remark]:
    verdict = figures["calibration"].get("verdict")
    if verdict and verdict["grade"] != "green":
        severity = "red" if verdict["grade"] == "red" else "info"
        what = f"On the calibration: {verdict['headline']}"
        yield from _say(severity, what, "See under Calibration, or calibration.html.")


def _unused(figures: Figures) -> Iterator[Remark]:
    used = {c["name"]: c["used_of_valid_share"] for c in figures["cameras"]}
    told = " ".join(figures["diagnostics"])
    little = [name for name, part in used.items() if part is not None and part < USED_SHARE and f" {name} " not in told]
    if figures["points"]["count"] and little:
        least = percent(min(used[name] for name in little))
        what = f"Much of what {some('camera', little)} saw became no part of a 3D point (used: {least} or more)."
        do = "Mask reflections and lamps in view; if there are none, suspect calibration or synchronisation."
        yield from _say("amber", what, do)


def _few_views(figures: Figures) -> Iterator[Remark]:
    few = figures["points"]["fewer_than_3_cameras_share"] or 0
    if few > 0.5:
        what = f"{percent(few)} of the points rest on only two cameras, which cannot check one another."
        yield from _say("amber", what, "Add cameras or turn them so that at least three see every marker.")


def _absent(figures: Figures) -> Iterator[Remark]:
    absent = [m["name"] for m in figures["trajectories"]["markers"] if not m["samples"]]
    if absent and figures["trajectories"]["samples"]:
        what = f"Never seen: {some('marker', absent)}."
        yield from _say("amber", what, "Check that it was worn and labelled, or take it out of the marker set.")


def _incomplete(figures: Figures) -> Iterator[Remark]:
    complete = figures["trajectories"]["completeness_in_view_share"]
    if not figures["trajectories"]["samples"] or complete >= COMPLETE_AMBER:
        return
    markers = [m for m in figures["trajectories"]["markers"] if m["completeness_in_view_share"] < COMPLETE_AMBER]
    worst = [m["name"] for m in sorted(markers, key=lambda m: float(m["completeness_in_view_share"]))]
    what = f"Only {percent(complete)} of the marker positions are there while the subject is in view"
    do = "See under Markers where they are missing; add or turn cameras to cover those places."
    severity = "red" if complete < COMPLETE_RED else "amber"
    unlabelled = figures["trajectories"]["unlabelled"]
    least = "" if unlabelled else f"; the least complete: {some('marker', worst)}"
    yield from _say(severity, f"{what}{least}.", do)


def _pieces(figures: Figures) -> Iterator[Remark]:
    tracks, worn = figures["trajectories"]["count"], figures["trajectories"]["markers_worn"]
    if figures["trajectories"]["unlabelled"] and tracks > PIECES * max(worn, 1):
        what = f"{tracks} tracks for about {count(worn, 'marker')}: a marker that was hidden for long begins a new one."
        yield from _say("amber", what, "Give the pieces of a marker one name, and fill what is missing between them.")


def _long_gaps(figures: Figures) -> Iterator[Remark]:
    long = [m["name"] for m in figures["trajectories"]["markers"] if m["longest_gap_s"] > LONG_GAP_S]
    if long:
        what = f"Gaps longer than {number(LONG_GAP_S)} s in {some('marker', long)}."
        yield from _say(
            "amber", what, "Fill them from neighbouring markers on the same segment, or leave these stretches out."
        )


def _filled(figures: Figures) -> Iterator[Remark]:
    much = [
        m["name"]
        for m in figures["trajectories"]["markers"]
        if m["samples"] and m["filled_samples"] > FILLED_SHARE * m["samples"]
    ]
    if much:
        part = f"{number(100 * FILLED_SHARE)}\u00a0%"
        what = f"More than {part} of the samples are filled, not measured, in {some('marker', much)}."
        yield from _say("amber", what, "Compare them with a repeated trial before reading fine detail from them.")


def _uncertain(figures: Figures) -> Iterator[Remark]:
    vague = [m["name"] for m in figures["trajectories"]["markers"] if (m["sd_per_axis_mean_mm"] or 0) > SD_AMBER_MM]
    if vague:
        what = f"A standard deviation above {number(SD_AMBER_MM)} mm per axis in {some('marker', vague)}."
        yield from _say(
            "amber",
            what,
            "Have more cameras see them from wider apart; do not read angles of small segments from them.",
        )


def _outside(figures: Figures) -> Iterator[Remark]:
    outside = figures["volume"]["samples_outside_given_share"] or 0
    if outside > OUTSIDE_SHARE:
        what = (
            f"{percent(outside)} of the samples lie outside the control volume, where the calibration was not checked."
        )
        yield from _say("amber", what, "Trust them less, or calibrate a larger volume.")


def _unnamed(figures: Figures) -> Iterator[Remark]:
    names = [m["name"] for m in figures["trajectories"]["markers"]]
    unnamed = sum(name.startswith("*") for name in names)
    if unnamed:
        what = f"{unnamed} of {count(len(names), 'trajectory', 'trajectories')} have no marker name."
        yield from _say("info", what, "Label them before computing angles.")


def _left_over(figures: Figures) -> Iterator[Remark]:
    inside = figures["points"]["in_a_track_share"]
    if inside is not None and inside < 0.9:
        what = f"{percent(1 - inside)} of the 3D points belong to no track: ghosts, or markers that were lost."
        do = "Click them in the scene: if they follow the subject, check rate_hz and the parameters of [track]."
        yield from _say("amber", what, do)


def _doubtful(figures: Figures) -> Iterator[Remark]:
    for note in figures["notes"]:
        yield from _say("amber", note, "Correct the one that is wrong.")


def _diagnostics(figures: Figures) -> Iterator[Remark]:
    for sentence in figures["diagnostics"]:
        if "frame rate" in sentence:
            do = "Correct rate_hz, or the rate in the file: every speed and every limit of [track] depends on it."
        else:
            do = "Look at that camera in a second trial: calibrate again if it was moved, or leave it out."
        yield from _say("amber", sentence, do)


def _unsure(figures: Figures) -> Iterator[Remark]:
    decisions = figures["ambiguous_decisions"]
    if decisions:
        kinds = {kind: sum(row["kind"] == kind for row in decisions) for kind in ("swap", "merge", "ghost", "join")}
        listed = ", ".join(count(n, f"possible {kind}") for kind, n in kinds.items() if n)
        were = "was" if len(decisions) == 1 else "were"
        what = f"{count(len(decisions), 'decision')} of the tracking {were} close: {listed}."
        yield from _say("info", what, "They are listed with their times and reasons below.")


def _stretched(figures: Figures) -> Iterator[Remark]:
    """A control frame with wrong measures gives pixels that are not square; those of fields are half as high."""
    ratios = {c["name"]: c["focal_px"][0] / c["focal_px"][1] for c in figures["cameras"]}
    odd = [name for name, ratio in ratios.items() if min(abs(ratio - 1), abs(ratio - 2)) > STRETCH]
    if odd:
        what = f"The pixels of {some('camera', odd)} would not be square by this calibration."
        yield from _say("amber", what, "Check the coordinates of the control points, unless the sensor is such.")


def worst_cameras(figures: Figures) -> list[str]:
    """Names of the cameras that disagree with the others, for marking them in tables."""
    return [camera["name"] for camera in _outliers(figures)]


CHECKS = (
    *(_nothing, _blind, _unlike_others, _residual, _calibration, _judged, _unused, _few_views, _absent),
    *(_incomplete, _pieces, _long_gaps, _filled, _uncertain, _outside, _unnamed, _left_over, _doubtful, _diagnostics),
    *(_unsure, _stretched),
)
