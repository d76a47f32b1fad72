"""What needs attention in a trial, from its figures."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence
from itertools import chain, combinations
from typing import Any

from ..data import Finding, Severity, make_finding
from ..data.finding import most_severe_first, red_if
from .left_over import used_of_possible

RESIDUAL_RATIO = 3.0
"""A camera stands out when its median residual is above this many times the median of the other cameras …; chosen."""
RESIDUAL_FLOOR_PX = 0.25
"""… and above this: below it, no camera stands out; chosen."""
RESIDUAL_AMBER_PX, RESIDUAL_RED_PX = 1.0, 3.0
"""Median residual over all cameras; chosen."""
CALIBRATION_AMBER_PX = 1.0
"""RMS residual of one camera's calibration; chosen."""
USED_SHARE = 0.6
"""Share of a camera's valid detections that should belong to a point; chosen."""
FLEETING = 0.1
"""Share of a camera's valid detections that may flash up for a frame; chosen."""
SAID = 4  # places of a camera's image that a sentence names; chosen: the figures have all
USED_RED = 0.3
"""The same of all cameras together, below which what was reconstructed is not what was seen; chosen."""
COMPLETE_AMBER, COMPLETE_RED, HALF = 0.97, 0.8, 0.5
"""Share of samples that are present while the subject is in view: red below the second where the cameras may have seen
what is missing, and else, as markers were hidden, up to the third; chosen."""
STRETCH = 0.06
"""How far the focal lengths along u and v may differ, or differ from 2:1 in fields of interlaced video; chosen."""
FRAGMENTS, FRAGMENTS_RED = 1.3, 8.0
"""Tracks a marker above which they count as broken, and as useless; chosen."""
LONG_GAP_S = 0.2
"""A gap that interpolation should not bridge unseen: a fifth of a gait cycle; chosen."""
FILLED_SHARE = 0.1
"""Share of a marker's samples that may be filled; chosen."""
SD_AMBER_MM = 2.0
"""Standard deviation of one axis: about a degree over a segment of 100 mm; chosen."""
NOISE_RATIO = 1.5
"""Times as much as their standard deviation that positions may tremble; chosen."""
OUTSIDE_SHARE = 0.02
"""Share of samples that may lie outside the control volume; chosen."""

NEAR_SHARE, NEAR_SHARE_RED = 0.01, 0.25
"""Share of the points on tracks so near another that either could have its images. Of 40 simulated recordings without a
swap one in six had more than the first, none more than 0.11; walking at 25 Hz, with few swaps, 0.21, and at 10 Hz, with
one a track, 0.28; chosen (see benchmarks/tracking_scenes.py)."""
OFF_COURSE = 0.005
"""Share of the points off their course; chosen on simulated recordings: 55 at 50 Hz and more have at most 0.0002; of 39
at 25 and 30 Hz 14 have more, 12 of them with exchanges."""
NEAREST_MM, FARTHEST_MM = 30.0, 500_000.0
"""How far apart the two outermost cameras may stand; chosen: nearer than cameras are wide, and farther than they see
markers, where metres were taken for mm, or mm for metres."""
NO_TRACK = 0.1
"""Share of the points that may belong to no track; chosen."""
TWO_CAMERAS = 0.5
"""Share of the points that may rest on fewer than three cameras; chosen."""

STILL_MM, MOVED_MM, STILL_S = 0.5, 50.0, 1.0
"""What a track travels that is still, or its jitter if that is more; what others do beside it; and for how long. Lamps
of simulated recordings travel up to 0.5 mm by noise; a person who stands moves each marker by more; chosen."""

Figures = dict[str, Any]
Findings = Iterator[Finding]
NAMELESS = "labels_without_template"
"""The finding that says of all trajectories that they have no names; by definition."""


def trial_findings(figures: Figures, noted: Sequence[Finding] = ()) -> list[Finding]:
    """What needs attention, the most severe first.

    Args:
        figures: of `quality`.
        noted: what the stages found themselves; it is among the result.
    """
    diagnosed = [found for found in noted if found.stage == "track"]
    named = {name for found in diagnosed for name in found.cameras}
    found = chain(
        _nothing(figures, diagnosed=bool(diagnosed)),
        *(check(figures) for check in CAMERA_CHECKS),
        () if _dropped_share(noted) > 1 - USED_SHARE else _unused(figures, named),
        *(check(figures) for check in MARKER_CHECKS),
        () if any(found.kind == NAMELESS for found in noted) else _unnamed(figures),
        _absent(figures, {name for found in noted for name in found.markers if found.kind == OUTSIDE}),
        (one for one in noted if _holds(one, noted, figures)),
        _close_decisions(figures),
        _confusable(figures),
        _rate_too_low(figures),
        _not_square(figures),
    )
    return most_severe_first(list(found))


def _nothing(figures: Figures, *, diagnosed: bool) -> Findings:
    if not figures["recording"]["frames"]:
        yield make_finding("no_frames")
    elif not any(camera["detections"] for camera in figures["cameras"]):
        yield make_finding("no_detections")
    elif not figures["points"]["count"]:
        yield make_finding("no_points", diagnosed=diagnosed)
    elif not figures["trajectories"]["samples"]:
        yield make_finding("no_trajectories")


def _blind(figures: Figures) -> Findings:
    if any(camera["detections"] for camera in figures["cameras"]):
        for camera in figures["cameras"]:
            if not camera["detections"]:
                yield make_finding("camera_sees_nothing", cameras=[camera["name"]])


def _unlike_others(figures: Figures) -> Findings:
    for camera in _outliers(figures):
        median, others = camera["residual_median_px"], _others(figures, camera)
        u, v = camera["offset_px"]
        yield make_finding(
            "camera_disagrees",
            cameras=[camera["name"]],
            residual_px=median,
            ratio=median / others if others else None,
            offset_u_px=u,
            offset_v_px=v,
        )


def _outliers(figures: Figures) -> list[Figures]:
    """Cameras whose median residual is far above that of the others."""
    return [
        camera
        for camera in figures["cameras"]
        if (camera["residual_median_px"] or 0) > max(RESIDUAL_FLOOR_PX, RESIDUAL_RATIO * _others(figures, camera))
    ]


def _others(figures: Figures, camera: Figures) -> float:
    """Median of the median residuals of the other cameras, px; infinite where there is none."""
    medians = [c["residual_median_px"] for c in figures["cameras"] if c is not camera]
    known = [median for median in medians if median is not None]
    return statistics.median(known) if known else math.inf


def _residual(figures: Figures) -> Findings:
    median = figures["points"]["residual_median_px"] or 0
    if median > RESIDUAL_AMBER_PX:
        yield make_finding("cameras_agree_poorly", severity=red_if(median > RESIDUAL_RED_PX), residual_px=median)


def _calibration(figures: Figures) -> Findings:
    poor = [c["name"] for c in figures["cameras"] if (c["calibration_residual_px"] or 0) > CALIBRATION_AMBER_PX]
    if poor and not figures["calibration"].get("verdict"):
        yield make_finding("calibration_residual_high", cameras=poor, limit_px=CALIBRATION_AMBER_PX)


def _judged(figures: Figures) -> Findings:
    verdict = figures["calibration"].get("verdict")
    if verdict and verdict["grade"] != "green":
        headline = verdict["statements"][0]
        unknown = verdict["grade"] != "red" and not calibration_known(figures)
        severity: Severity = "red" if verdict["grade"] == "red" else "amber" if unknown else "info"
        good_for = {"sd_mm": None, "volume_share": None} | headline["values"]
        grade = "unknown" if unknown else verdict["grade"]
        yield make_finding("calibration_verdict", severity=severity, grade=grade, **good_for)


def calibration_known(figures: Figures) -> bool:
    """Whether the calibration states its error; one that nobody judged counts as one that does."""
    precision = figures["calibration"].get("precision")
    return not precision or bool(precision["calibration_known"])


def _unused(figures: Figures, named: set[str]) -> Findings:
    """Cameras little of whose detections is used.

    Those that were named for another reason are left out, unless most cameras are such.
    """
    numbers = zip(figures["cameras"], *used_of_possible(figures["cameras"]), strict=True)
    used = {camera["name"]: float(part / n) for camera, part, n in numbers if n > 0}
    told = named if used and statistics.median(used.values()) >= USED_RED else set()
    little = {name: part for name, part in used.items() if part < USED_SHARE and name not in told}
    if figures["points"]["count"] and little:
        whole = used_share(figures)
        yield make_finding(
            "detections_unused", severity=red_if(whole < USED_RED), cameras=little, used_share=min(little.values())
        )


def used_share(figures: Figures) -> float:
    """Share of the detections of all cameras that belong to a point, of those that may be of markers."""
    used, possible = used_of_possible(figures["cameras"])
    return float(used.sum() / max(possible.sum(), 1.0))


def _no_markers(figures: Figures) -> Findings:
    """Cameras with images that stand, and those most of whose images of no point are fleeting."""
    if standing := {c["name"]: c for c in figures["cameras"] if c["standing_spots"]}:
        spots = [c["standing_spots"] for c in standing.values()]
        at = [", ".join(f"({u:.0f}, {v:.0f})" for u, v in c["standing_at"][:SAID]) for c in standing.values()]
        share = max(c["standing_share"] for c in standing.values())
        yield make_finding("reflections_standing", cameras=standing, spots_list=spots, at_list=at, images_share=share)
    fleeting = {c["name"]: share for c in figures["cameras"] if (share := c["fleeting_share"] or 0.0) > FLEETING}
    if fleeting:
        yield make_finding("images_fleeting", cameras=fleeting, images_share=max(fleeting.values()))


def _few_cameras(figures: Figures) -> Findings:
    few = figures["points"]["fewer_than_3_cameras_share"] or 0
    if few > TWO_CAMERAS:
        yield make_finding("two_camera_points", points_share=few)


OUTSIDE, WITHOUT_IMAGES, NOT_FOUND = "points_dropped_outside", "camera_without_images", "markers_not_found"


def _dropped_share(noted: Sequence[Finding]) -> float:
    """Share of the tracked points that lie outside the volume: their images are used, though not kept."""
    shares: list[Any] = [found.values["points_share"] for found in noted if found.kind == OUTSIDE]
    return max(shares, default=0.0)


def _holds(one: Finding, noted: Sequence[Finding], figures: Figures) -> bool:
    """Whether what a stage found needs to be said of the whole trial.

    Not of markers that are missing where the volume left out the points of half their frames.
    """
    if one.kind == WITHOUT_IMAGES:
        return not {c["name"] for c in figures["cameras"] if not c["detections"]}.issuperset(one.cameras)
    left: list[Any] = [found.values["points"] for found in noted if found.kind == OUTSIDE]
    return one.kind != NOT_FOUND or not left or max(left) < figures["recording"]["frames"] * len(one.markers) / 2


def _absent(figures: Figures, outside: set[str]) -> Findings:
    """Markers without a sample, but for those of which it is known that they were outside the volume."""
    markers = figures["trajectories"]["markers"]
    absent = [m["name"] for m in markers if not m["samples"] and m["name"] not in outside]
    if absent and figures["trajectories"]["samples"]:
        yield make_finding("markers_never_seen", markers=absent)


def _incomplete(figures: Figures) -> Findings:
    trajectories = figures["trajectories"]
    of_found, of_shown = trajectories["completeness_of_found_share"], trajectories["completeness_in_view_share"]
    if not trajectories["samples"] or of_found is None:
        return
    complete = of_found if of_shown is None else min(of_found, of_shown)
    if complete >= COMPLETE_AMBER:
        return
    markers = [m for m in trajectories["markers"] if (m["completeness_in_view_share"] or 0.0) < COMPLETE_AMBER]
    markers = [m for m in markers if not m["name"].startswith("*")]
    least_complete = [m["name"] for m in sorted(markers, key=lambda m: m["completeness_in_view_share"] or 0.0)]
    yield make_finding(
        "incomplete",
        severity=red_if(complete <= HALF or (complete < COMPLETE_RED and _found_of_seen(figures) < COMPLETE_RED)),
        markers=() if trajectories["unlabelled"] else least_complete,
        complete_share=complete,
    )


def _found_of_seen(figures: Figures) -> float:
    """Share of the samples that are present, of these and those that images of no point would yet make, of two each."""
    used, possible = used_of_possible(figures["cameras"])
    samples = figures["trajectories"]["samples"]
    return float(samples / (samples + (possible - used).sum() / 2))


def _broken(figures: Figures) -> Findings:
    tracks, worn = figures["trajectories"]["count"], figures["trajectories"]["markers_worn"]
    if figures["trajectories"]["unlabelled"] and tracks > FRAGMENTS * max(worn, 1):
        broken = tracks > FRAGMENTS_RED * max(worn, 1)
        yield make_finding("tracks_broken", severity=red_if(broken), tracks=tracks, markers_worn=worn)


def _still(figures: Figures) -> Findings:
    """Nameless tracks that lie where they are while most others move: lamps and reflections."""
    tracks = [m for m in figures["trajectories"]["markers"] if m["travel_mm"] is not None]
    least = max(STILL_S * figures["recording"]["rate_hz"], figures["recording"]["frames"] / 2)
    still = [m["name"] for m in tracks if m["travel_mm"] < max(STILL_MM, m["jitter_mm"] or 0) and m["samples"] > least]
    moved = statistics.median([m["travel_mm"] for m in tracks if m["name"] not in still] or [0.0])
    if moved > MOVED_MM and (nameless := [name for name in still if name.startswith("*")]):
        yield make_finding("tracks_still", markers=nameless, limit_mm=STILL_MM, moved_mm=moved)


def _long_gaps(figures: Figures) -> Findings:
    long = [m["name"] for m in figures["trajectories"]["markers"] if m["longest_gap_s"] > LONG_GAP_S]
    if long:
        yield make_finding("long_gaps", markers=long, limit_s=LONG_GAP_S)


def _filled(figures: Figures) -> Findings:
    markers = [m for m in figures["trajectories"]["markers"] if m["samples"]]
    much = [m["name"] for m in markers if m["filled_samples"] > FILLED_SHARE * m["samples"]]
    if much:
        yield make_finding("much_filled", markers=much, limit_share=FILLED_SHARE)


def _uncertain(figures: Figures) -> Findings:
    vague = [m["name"] for m in figures["trajectories"]["markers"] if (m["sd_per_axis_mean_mm"] or 0) > SD_AMBER_MM]
    if vague:
        yield make_finding("markers_uncertain", markers=vague, limit_mm=SD_AMBER_MM)


def _trembling(figures: Figures) -> Findings:
    sd, noise = (figures["trajectories"][key] for key in ("sd_per_axis_mean_mm", "jitter_median_mm"))
    if sd is not None and noise is not None and noise > NOISE_RATIO * sd:
        yield make_finding("noise_above_deviation", sd_mm=sd, noise_mm=noise)


def _outside(figures: Figures) -> Findings:
    outside = figures["volume"]["samples_outside_given_share"] or 0
    if outside > OUTSIDE_SHARE:
        yield make_finding("outside_volume", samples_share=outside)


def _unnamed(figures: Figures) -> Findings:
    names = [m["name"] for m in figures["trajectories"]["markers"]]
    unnamed = sum(name.startswith("*") for name in names)
    if unnamed:
        yield make_finding("unnamed_trajectories", unnamed=unnamed, trajectories=len(names))


def _left_over(figures: Figures) -> Findings:
    inside = figures["points"]["in_a_track_share"]
    if inside is not None and inside < 1 - NO_TRACK:
        yield make_finding("points_in_no_track", points_share=1 - inside)


def _close_decisions(figures: Figures) -> Findings:
    kinds = [row["kind"] for row in figures["ambiguous_decisions"]]
    if kinds:
        numbers: dict[str, Any] = {kind: kinds.count(kind) for kind in ("swap", "merge", "ghost", "stitch")}
        yield make_finding("close_decisions", **numbers)


def _confusable(figures: Figures) -> Findings:
    """Tracks that came near each other, for the rate, for so much of the time that some were likely exchanged."""
    near = [row for row in figures["ambiguous_decisions"] if row["reason"] == "came_near"]
    points = {
        (who, f)
        for row in near
        for who in row["trajectories"]
        for f in range(row["first_frame"], row["last_frame"] + 1)
    }
    share = len(points) / max(figures["points"]["count"], 1)
    if share > NEAR_SHARE:
        yield make_finding(
            "tracks_confusable",
            severity=red_if(share > NEAR_SHARE_RED),
            decisions=len(near),
            points_share=min(share, 1.0),
        )


def _rate_too_low(figures: Figures) -> Findings:
    share = figures["tracks"]["off_course_share"] or 0.0
    if share > OFF_COURSE:
        yield make_finding("rate_too_low", points_share=share, rate_hz=figures["recording"]["rate_hz"])


def _scale(figures: Figures) -> Findings:
    """Cameras that stand nearer to each other, or farther apart, than any do."""
    places = [camera["position_mm"] for camera in figures["cameras"]]
    apart = max((math.dist(a, b) for a, b in combinations(places, 2)), default=math.nan)
    if apart < NEAREST_MM or apart > FARTHEST_MM:
        yield make_finding("scale_impossible", apart_mm=apart)


def _not_square(figures: Figures) -> Findings:
    if odd := not_square(figures["cameras"]):
        yield make_finding("pixels_not_square", cameras=odd)


def not_square(cameras: Sequence[Figures]) -> list[str]:
    """Names of the cameras whose pixels would not be square; those of fields are half as high."""
    ratios = {c["name"]: c["focal_px"][0] / c["focal_px"][1] for c in cameras}
    return [name for name, ratio in ratios.items() if min(abs(ratio - 1), abs(ratio - 2)) > STRETCH]


def inconsistent_cameras(figures: Figures) -> list[str]:
    """Names of the cameras that disagree with the others, for marking them in tables."""
    return [camera["name"] for camera in _outliers(figures)]


CAMERA_CHECKS = (_scale, _blind, _unlike_others, _residual, _calibration, _judged, _no_markers)
MARKER_CHECKS = (
    *(
        _few_cameras,
        _incomplete,
        _broken,
        _still,
        _long_gaps,
        _filled,
        _uncertain,
        _trembling,
        _outside,
        _left_over,
    ),
)
