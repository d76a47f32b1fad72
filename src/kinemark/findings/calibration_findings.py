"""What needs attention in a calibration, from its figures: how it fits, and what its cameras see of the volume."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence
from itertools import chain

from ..data import Finding, Severity, make_finding
from ..data.finding import most_severe_first, red_if
from .calibration_lengths import LENGTH_CHECKS
from .trial_findings import CALIBRATION_AMBER_PX, RESIDUAL_FLOOR_PX, RESIDUAL_RATIO, Figures, not_square

RESIDUAL_RED_PX = 3.0
"""RMS residual of one camera at which geometry is no longer believed; chosen (see studies/calibration_quality.py)."""
LEFT_OUT_RATIO, LEFT_OUT_FLOOR_PX = 2.0, 0.1
"""Errors left out above this many times the residual, and above so many px, mean that few points decide much.
Chosen."""
UNSEEN_AMBER, UNSEEN_RED = 0.02, 0.3
"""Share of the volume that fewer than two cameras see; chosen (see studies/calibration_quality.py)."""
CHECKED = 0.3
"""Share of the volume that may be seen by two cameras only, which cannot check each other.
Chosen (see studies/calibration_quality.py)."""
LOSS = 2.0
"""A camera whose loss makes the error this many times as large …; chosen."""
LOSS_SHARE = 0.1
"""… or takes so much of the volume away, is one that everything rests on.
Chosen (see studies/calibration_quality.py)."""
COVERED = 0.8
"""Share of the volume in a camera's image that should lie among the points it was calibrated with.
Chosen (see studies/calibration_quality.py)."""
CORNER_PX, CORNER_RATIO = 1.0, 4.0
"""How uncertain the image of a place in the volume may be, px, and how many times as much as at its centre; chosen."""
SD_AMBER_MM, SD_RED_MM = 2.0, 10.0
"""Standard deviation of one axis in 95 % of the volume; chosen (see studies/calibration_quality.py)."""
FLAT_SHARE = 0.1
"""Share of the volume in which all rays may meet at less than 20°; chosen (see studies/calibration_quality.py)."""
LEFT_OUT_IMAGES = 0.05
"""Share of all images of points that may have been left out as wrong; chosen (see studies/calibration_quality.py)."""
POINT_RATIO = 4.0
"""A point whose error left out is this many times the median, and above 0.25 px, was surveyed or read wrongly.
Chosen."""
HALVES_AMBER, HALVES_RED = 1.5, 2.0
"""Times that the squares of residuals of one half of a film are less with cameras of its own (`quality.halves`).
Chosen."""
MOVED_MM, MOVED_PX = 2.0, 1.0
"""A camera that has moved by so much since the former calibration is named; chosen."""
TREND_RATIO, TREND_PX = 0.1, 0.02
"""Residuals that go with the place in the image by so much of their noise, and by so many px, make errors of positions
that are not in their deviation; chosen (see benchmarks/room.py): from .13 on, ellipsoids of means of 25 images fail."""
DOWNWARDS = -0.3
"""Cosine between an image's v and the world's Z below which v grows downwards; chosen: cameras look up or down by less
than 70°."""
FLAT_DEG = 20
"""Rays that meet at less leave the depth poorly known; chosen (see studies/calibration_quality.py)."""


def calibration_findings(figures: Figures, noted: Sequence[Finding] = ()) -> list[Finding]:
    """What needs attention, the most severe first; `noted` is what was found while the calibration was made."""
    return most_severe_first(list(chain(*(check(figures) for check in CHECKS), noted)))


def _judged(figures: Figures) -> Iterator[Finding]:
    """The reasons of a judgement that the way has of its own; of a good one what it says besides."""
    judged = figures["judged"]
    if judged:
        first = 1 if judged["grade"] == "good" else 0  # which the verdict says
        yield from map(Finding.of, judged["findings"][first:])


def _residual(figures: Figures) -> Iterator[Finding]:
    if figures["judged"]:
        return  # which weighs residuals by the extent of the images
    residuals = {c["name"]: c["residual_rms_px"] or 0.0 for c in figures["cameras"]}
    high = {name: r for name, r in residuals.items() if r > RESIDUAL_RED_PX}
    fair = {name: r for name, r in residuals.items() if CALIBRATION_AMBER_PX < r <= RESIDUAL_RED_PX}
    if high:
        yield make_finding("cameras_miss_points", severity="red", cameras=high, max_px=max(high.values()))
    if fair:
        yield make_finding("cameras_miss_points", severity="amber", cameras=fair, max_px=max(fair.values()))


def _unlike_others(figures: Figures) -> Iterator[Finding]:
    if figures["judged"]:
        return  # which has looked at that already
    known = {c["name"]: c["residual_rms_px"] for c in figures["cameras"] if c["residual_rms_px"] is not None}
    for name, residual in known.items():
        others = [r for other, r in known.items() if other != name]
        if others and residual > max(RESIDUAL_FLOOR_PX, RESIDUAL_RATIO * statistics.median(others)):
            yield make_finding(
                "camera_fits_worse", cameras=[name], residual_px=residual, others_px=statistics.median(others)
            )


def _left_out(figures: Figures) -> Iterator[Finding]:
    far = []
    for c in figures["cameras"]:
        residual, out = c["residual_rms_px"], c["left_out_rms_px"]
        if residual is not None and out is not None and out > max(LEFT_OUT_FLOOR_PX, LEFT_OUT_RATIO * residual):
            far.append((out / max(residual, 1e-6), c["name"]))
    if far:
        names = [name for _, name in sorted(far, reverse=True)]
        yield make_finding("left_out_errors_large", cameras=names, ratio=max(far)[0])


def _halves(figures: Figures) -> Iterator[Finding]:
    ratio = figures["fit"]["halves_ratio"]
    if ratio is not None and ratio > HALVES_AMBER:
        yield make_finding("film_halves_differ", severity=red_if(ratio > HALVES_RED), ratio=ratio)


def _points(figures: Figures) -> Iterator[Finding]:
    if figures["judged"]:
        return
    errors = {p["name"]: p["left_out_rms_px"] for p in figures["points"] if p["left_out_rms_px"] is not None}
    if len(errors) > 3:
        limit = max(RESIDUAL_FLOOR_PX, POINT_RATIO * statistics.median(errors.values()))
        odd = {name: error for name, error in errors.items() if error > limit}
        if odd:
            yield make_finding("control_points_disagree", points_list=list(odd), max_px=max(odd.values()))
    share = figures["fit"]["images_left_out_share"]
    if share is not None and share > LEFT_OUT_IMAGES:
        yield make_finding("images_left_out", images_share=share)


def _views(figures: Figures) -> Iterator[Finding]:
    unseen, two = (figures["precision"][f"fewer_than_{n}_cameras_share"] for n in (2, 3))
    given = figures["volume"]["given"]
    if unseen > UNSEEN_AMBER:
        severity = red_if(given and unseen > UNSEEN_RED)
        yield make_finding("volume_unseen", severity=severity, volume_share=unseen, volume_given=given)
    elif two > CHECKED and len(figures["cameras"]) > 2:
        yield make_finding("volume_seen_by_two", volume_share=two, volume_given=given)


def _loss(figures: Figures) -> Iterator[Finding]:
    if len(figures["cameras"]) < 3:
        yield make_finding("two_cameras_only")
        return
    for c in figures["cameras"]:
        ratio, newly = c["without"]["ratio_median"], c["without"]["newly_unseen_share"] or 0
        if (ratio is not None and ratio > LOSS) or newly > LOSS_SHARE:
            unseen = newly if newly > LOSS_SHARE else None
            yield make_finding("camera_indispensable", cameras=[c["name"]], ratio=ratio, unseen_share=unseen)


def _image(figures: Figures) -> Iterator[Finding]:
    covered = {c["name"]: c["volume_share"] for c in figures["cameras"]}
    little = {name: share for name, share in covered.items() if share is not None and share < COVERED}
    if little:
        least = min(little.values())
        severity: Severity = "amber" if least < COVERED / 2 else "info"
        yield make_finding("points_cover_part", severity=severity, cameras=little, least_share=least)
    vague = {
        c["name"]: c["aim_volume_max_px"]
        for c in figures["cameras"]
        if (c["aim_volume_max_px"] or 0) > max(CORNER_PX, CORNER_RATIO * (c["aim_centre_px"] or math.inf))
    }
    if vague:
        yield make_finding("lens_uncertain", cameras=vague, max_px=max(vague.values()))
    outside = {c["name"]: share for c in figures["cameras"] if (share := c["points_outside_share"])}
    if outside:
        yield make_finding("points_outside_image", cameras=outside, most_share=max(outside.values()))
    folded = {c["name"]: c["folded_share"] for c in figures["cameras"] if c["folded_share"]}
    if folded:
        yield make_finding("lens_folds", cameras=folded, most_share=max(folded.values()))


def _precision(figures: Figures) -> Iterator[Finding]:
    sd = figures["precision"]["sd_95_mm"]
    if sd is not None and sd > SD_AMBER_MM:
        yield make_finding("precision_low", severity=red_if(sd > SD_RED_MM), sd_mm=sd)
    flat = figures["precision"]["angle_below_20_deg_share"]
    if flat > FLAT_SHARE:
        yield make_finding("rays_nearly_parallel", volume_share=flat, limit_deg=FLAT_DEG)
    if not figures["precision"]["calibration_known"]:
        yield make_finding("no_uncertainty_stated")


def _room(figures: Figures) -> Iterator[Finding]:
    room, own = figures["room"], figures["precision"]["sd_95_mm"] or 0.0
    if room and room["sd_95_mm"] > own:
        severity: Severity = "amber" if room["sd_95_mm"] > SD_AMBER_MM else "info"
        yield make_finding("room_uncertain", severity=severity, sd_mm=room["sd_95_mm"])


def _lens(figures: Figures) -> Iterator[Finding]:
    bare = [c["name"] for c in figures["cameras"] if not c["lens_fitted"] and not any(c["distortion"])]
    if bare:
        yield make_finding("no_lens_correction", cameras=bare)
    if odd := not_square(figures["cameras"]):
        yield make_finding("pixels_not_square", cameras=odd)
    bent = [s["name"] for s in figures["straightness"] if (s["after_px"] or 0) > CALIBRATION_AMBER_PX]
    if bent:
        yield make_finding("grid_rows_bent", cameras=bent)


def _lens_trend(figures: Figures) -> Iterator[Finding]:
    """Lens terms that were held though the images have them, the worst camera's figures."""
    trends = {c["name"]: c["lens_trend"] for c in figures["cameras"] if c["lens_trend"] and c["lens_trend"]["rms_px"]}
    named = {name: trend["rms_px"] for name, trend in trends.items()}
    if named:
        worst = max(trends.values(), key=lambda trend: float(trend["of_noise"]))
        harm = worst["of_noise"] > TREND_RATIO and max(named.values()) > TREND_PX
        severity: Severity = "amber" if harm else "info"
        terms = {term for trend in trends.values() for term in trend["terms"].split(", ")}
        yield make_finding(
            "lens_term_missing", severity=severity, cameras=named, max_px=max(named.values()),
            noise_share=worst["of_noise"], radial="radial" in terms, sideways="sideways" in terms,
        )  # fmt: skip


def _moved(figures: Figures) -> Iterator[Finding]:
    if not figures["change"]:
        return
    rows = figures["change"]["cameras"]
    gone = [c["name"] for c in rows if (c["moved_mm"] or 0) > MOVED_MM or (c["image_px"] or 0) > MOVED_PX]
    if gone and len(gone) < len(rows):
        yield make_finding("cameras_moved_since", cameras=gone)


def _mirrored(figures: Figures) -> Iterator[Finding]:
    """Cameras whose calibration turns right into left; all may do, where v is counted upwards, and not against z."""
    cameras = figures["cameras"]
    names = [c["name"] for c in cameras if c["mirrored"]]
    if names and len(names) < len(cameras):
        yield make_finding("cameras_mirrored", cameras=names)
    elif names:
        down = statistics.median(c["v_upwards"] for c in cameras) < DOWNWARDS
        yield make_finding("coordinates_mirrored", severity="amber" if down else "info")


CHECKS = (
    *(_judged, _residual, _unlike_others, _left_out, _halves, _points, _views, _loss, _image, *LENGTH_CHECKS),
    *(_mirrored, _precision, _room, _lens, _lens_trend, _moved),
)
