"""Is the calibration good? From its figures to words: what deserves a look, what to do, and the verdict."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator
from typing import Any

from ..report.formatting import count, measure, millimetres, number, percent, some
from .trial_advice import CALIBRATION_AMBER_PX, RESIDUAL_FLOOR_PX, RESIDUAL_RATIO, STRETCH, Figures, Remark

RESIDUAL_RED_PX = 3.0
"""RMS residual of one camera at which geometry is no longer believed."""
LEFT_OUT_RATIO, LEFT_OUT_FLOOR_PX = 2.0, 0.1
"""Errors left out above this many times the residual, and above so many px, mean that few points decide much."""
UNSEEN_AMBER, UNSEEN_RED = 0.02, 0.3
"""Share of the volume that fewer than two cameras see."""
CHECKED = 0.3
"""Share of the volume that may be seen by two cameras only, which cannot check each other."""
LOSS = 2.0
"""A camera whose loss makes the error this many times as large …"""
LOSS_SHARE = 0.1
"""… or takes so much of the volume away, is one that everything rests on."""
COVERED = 0.8
"""Share of the volume in a camera's image that should lie among the points it was calibrated with."""
CORNER_PX, CORNER_RATIO = 1.0, 4.0
"""How uncertain the image of a place in the volume may be, px, and how many times as much as the image's middle."""
SCALE_AMBER, SCALE_RED = 0.005, 0.02
"""How far a length that took no part may come out wrong, as a share of it."""
WAND_AMBER, WAND_RED = 0.005, 0.02
"""RMS error of the wand's length, as a share of it, and …"""
WAND_FLOOR_MM = 1.0
"""… below this nobody minds."""
SD_AMBER_MM, SD_RED_MM = 2.0, 10.0
"""Standard deviation of one axis in 95 % of the volume."""
FLAT_SHARE = 0.1
"""Share of the volume in which all rays may meet at less than 20°."""
LEFT_OUT_IMAGES = 0.05
"""Share of all images of points that may have been left out as wrong."""
POINT_RATIO = 4.0
"""A point whose error left out is this many times the middle one, and above 0.25 px, was surveyed or read wrongly."""
NEAREST_MM, FARTHEST_MM = 200.0, 50_000.0
"""Middle distance between cameras of a laboratory."""
SAME_PLACE_MM = 30.0
"""Cameras nearer to each other than this would be within each other."""
MOVED_MM, MOVED_PX = 2.0, 1.0
"""A camera that has moved by so much since the former calibration is named."""


def calibration_warnings(figures: Figures) -> list[Remark]:
    """What deserves a look: severity ("red", "amber" or "info"), what was found, what to do; the gravest first."""
    found = [warning for check in CHECKS for warning in check(figures)]
    return sorted(found, key=lambda warning: ("red", "amber", "info").index(warning["severity"]))


def calibration_verdict(figures: Figures) -> dict[str, Any]:
    """grade ("green", "amber" or "red"), a headline that says what the calibration is good for, and sentences."""
    severities = {warning["severity"] for warning in figures["warnings"]}
    grade = "red" if "red" in severities else "amber" if "amber" in severities else "green"
    good_for = _good_for(figures)
    headline = {
        "green": f"The calibration is good: {good_for}.",
        "amber": f"Usable with care: {good_for}, but look at the points below first.",
        "red": "Do not use this calibration: the reasons stand below.",
    }[grade]
    return {"grade": grade, "headline": headline, "sentences": list(_sentences(figures))}


def _good_for(figures: Figures) -> str:
    precision = figures["precision"]
    for key, share in (("sd_95_mm", "95\u00a0%"), ("sd_median_mm", "half")):
        if precision[key] is not None:
            return f"a marker is placed to {millimetres(precision[key])} per axis in {share} of the volume"
    return "less than half of the volume is seen by two cameras"


def _sentences(figures: Figures) -> Iterator[str]:
    fit, precision, cameras = figures["fit"], figures["precision"], figures["cameras"]
    made = f"{count(len(cameras), 'camera')} calibrated by {figures['way']}"
    if fit["residual_rms_px"] is not None:
        of = f" over {count(fit['images'], 'image')} of {count(fit['points'], 'point')}" if fit["images"] else ""
        made += f": the residual is {measure(fit['residual_rms_px'], 3, 'px')} RMS{of}"
    if fit["left_out_rms_px"] is not None:
        made += f", and {measure(fit['left_out_rms_px'], 3, 'px')} on points that took no part"
    yield made + "."
    if figures["judged"] and figures["judged"]["grade"] == "good":
        yield figures["judged"]["sentences"][0]
    yield from _lengths(figures)
    if precision["sd_95_mm"] is not None:
        known = "" if precision["calibration_known"] else " and a calibration without error, for it states none"
        yield (
            f"With centroids good to {measure(precision['centroid_sd_px'], 3, 'px')}{known}, the standard deviation of "
            f"a marker's position is below {millimetres(precision['sd_95_mm'])} per axis in 95\u00a0% of the volume, "
            f"and below {millimetres(precision['worst_direction_95_mm'])} even in its worst direction."
        )
    yield from _coverage(figures)


def _lengths(figures: Figures) -> Iterator[str]:
    wand = figures["wand"]
    if wand and wand["poses"]:
        yield (
            f"In {count(wand['poses'], 'pose')} that took no part, the wand's "
            f"{' + '.join(number(mm) for mm in wand['known_mm'])}\u00a0mm come out wrong by "
            f"{millimetres(wand['error_abs_mean_mm'])} on average (offset {millimetres(wand['error_mean_mm'])}, "
            f"SD {millimetres(wand['error_sd_mm'])})."
        )
    for check in figures["checks"]:
        known, found = (measure(check[key], 2, "mm") for key in ("known_mm", "found_mm"))
        yield f"{check['what']}, which took no part: {known} as measured, {found} by the cameras."


def _coverage(figures: Figures) -> Iterator[str]:
    precision = figures["precision"]
    two, three = (1 - precision[f"fewer_than_{n}_cameras_share"] for n in (2, 3))
    seen = f"{percent(two)} of the volume is seen by at least two cameras, {percent(three)} by three"
    matters = max(figures["cameras"], key=lambda c: c["without"]["ratio_median"] or 0)
    ratio = matters["without"]["ratio_median"]
    if len(figures["cameras"]) > 2 and ratio is not None:
        seen += f"; {matters['name']} matters most: without it the error would be {number(ratio, 2)} times as large"
    yield seen + "."


def _say(severity: str, what: str, do: str) -> Iterator[Remark]:
    yield {"severity": severity, "what": what, "do": do}


def _residual(figures: Figures) -> Iterator[Remark]:
    if figures["judged"]:
        return  # which weighs residuals by the extent of the images
    residuals = {c["name"]: c["residual_rms_px"] or 0.0 for c in figures["cameras"]}
    for severity, low, high in (("red", RESIDUAL_RED_PX, math.inf), ("amber", CALIBRATION_AMBER_PX, RESIDUAL_RED_PX)):
        poor = [name for name, r in residuals.items() if low < r <= high]
        if poor:
            worst = measure(max(residuals[name] for name in poor), 1, "px")
            what = f"{some('camera', poor).capitalize()} {_miss(poor)} the calibration points by up to {worst} RMS."
            do = (
                "Check that its images are its own and not another camera's, and the places of the points; then repeat."
            )
            yield from _say(severity, what, do)


def _miss(names: list[str]) -> str:
    return "misses" if len(names) == 1 else "miss"


def _judged(figures: Figures) -> Iterator[Remark]:
    """The reasons of a judgement that the way has of its own, the weightiest first; of a good one what else it says."""
    judged = figures["judged"]
    if judged:
        first = 1 if judged["grade"] == "good" else 0  # which the verdict says
        for allowed, sentence in list(zip(judged["allowed"], judged["sentences"], strict=True))[first:]:
            yield from _say({"bad": "red", "usable": "amber", "good": "info"}[allowed], sentence, "")


def _unlike_others(figures: Figures) -> Iterator[Remark]:
    if figures["judged"]:
        return  # which has looked at that already
    known = {c["name"]: c["residual_rms_px"] for c in figures["cameras"] if c["residual_rms_px"] is not None}
    for name, residual in known.items():
        others = [r for other, r in known.items() if other != name]
        if others and residual > max(RESIDUAL_FLOOR_PX, RESIDUAL_RATIO * statistics.median(others)):
            what = f"Camera {name} fits worse than the others: {measure(residual, 2, 'px')} against "
            what += f"{measure(statistics.median(others), 2, 'px')}."
            do = "It may have moved while calibrating, be out of focus or out of time, or have another camera's images."
            yield from _say("amber", what, do)


def _left_out(figures: Figures) -> Iterator[Remark]:
    far = []
    for c in figures["cameras"]:
        residual, out = c["residual_rms_px"], c["left_out_rms_px"]
        if residual is not None and out is not None and out > max(LEFT_OUT_FLOOR_PX, LEFT_OUT_RATIO * residual):
            far.append((out / max(residual, 1e-6), c["name"]))
    if far:
        names = [name for _, name in sorted(far, reverse=True)]
        what = (
            f"In {some('camera', names)} points that took no part are missed by up to {number(max(far)[0], 1)} times "
        )
        what += "the residual: the few points that there are decide too much."
        yield from _say("amber", what, "Use more points, spread over the whole image, or fewer lens terms.")


def _points(figures: Figures) -> Iterator[Remark]:
    errors = {p["name"]: p["left_out_rms_px"] for p in figures["points"] if p["left_out_rms_px"] is not None}
    if len(errors) > 3 and not figures["judged"]:
        limit = max(RESIDUAL_FLOOR_PX, POINT_RATIO * statistics.median(errors.values()))
        odd = [name for name, error in errors.items() if error > limit]
        if odd:
            what = f"The other points do not agree with {some('control point', odd)}: off by up to "
            what += f"{measure(max(errors[name] for name in odd), 1, 'px')} when left out."
            yield from _say(
                "amber", what, "Measure their places again, or check that they were not mistaken for others."
            )
    share = figures["fit"]["images_left_out_share"]
    if share is not None and share > LEFT_OUT_IMAGES and not figures["judged"]:
        what = f"{percent(share)} of all images of points fitted so badly that they were left out."
        yield from _say("amber", what, "Look for reflections, wrong matches and cameras out of time.")


def _views(figures: Figures) -> Iterator[Remark]:
    unseen, two = (figures["precision"][f"fewer_than_{n}_cameras_share"] for n in (2, 3))
    volume = "control volume" if figures["volume"]["given"] else "volume (assumed; volume_mm says it)"
    if unseen > UNSEEN_AMBER:
        what = f"{percent(unseen)} of the {volume} is seen by fewer than two cameras: nothing is measured there."
        severity = "red" if unseen > UNSEEN_RED else "amber"
        yield from _say(severity, what, "Turn or move cameras, see the map; or set volume_mm to what is used.")
    elif two > CHECKED and len(figures["cameras"]) > 2:
        what = f"{percent(two)} of the {volume} is seen by two cameras only, which cannot check each other."
        yield from _say("amber", what, "Turn or add cameras so that three see every place.")


def _loss(figures: Figures) -> Iterator[Remark]:
    if len(figures["cameras"]) < 3:
        yield from _say(
            "info", "There are two cameras: when one is lost or a marker hidden, so is the measurement.", ""
        )
        return
    for c in figures["cameras"]:
        ratio, newly = c["without"]["ratio_median"], c["without"]["newly_unseen_share"] or 0
        if (ratio is not None and ratio > LOSS) or newly > LOSS_SHARE:
            what = f"Much rests on camera {c['name']}: without it the error is {number(ratio, 1)} times as large"
            what += f" and {percent(newly)} of the volume is no longer measured." if newly > LOSS_SHARE else "."
            yield from _say(
                "info", what, "Check this camera first when something is wrong; another near it would help."
            )


def _image(figures: Figures) -> Iterator[Remark]:
    outside = {c["name"]: c["volume_share"] for c in figures["cameras"]}
    little = [name for name, share in outside.items() if share is not None and share < COVERED]
    if little:
        least = percent(min(outside[name] for name in little))
        what = f"In {some('camera', little)} the calibration points cover only part of the volume (least: {least})."
        do = "Bring points or the wand to the corners of the images: beyond the points the lens is a guess."
        yield from _say("amber" if min(outside[name] for name in little) < COVERED / 2 else "info", what, do)
    vague = [
        c["name"]
        for c in figures["cameras"]
        if (c["aim_volume_worst_px"] or 0) > max(CORNER_PX, CORNER_RATIO * (c["aim_middle_px"] or math.inf))
    ]
    if vague:
        worst = max(c["aim_volume_worst_px"] for c in figures["cameras"] if c["name"] in vague)
        what = f"In parts of the images of {some('camera', vague)} the lens is hardly determined: places of the volume "
        what += f"are uncertain by up to {measure(worst, 1, 'px')} there."
        yield from _say("amber", what, "Use more points near the corners, or fewer lens terms.")


def _scale(figures: Figures) -> Iterator[Remark]:
    for check in figures["checks"]:
        off = abs(check["error_share"] or 0)
        if off > SCALE_AMBER:
            what = f"The scale is doubtful: {check['what']} is {millimetres(check['known_mm'])} and comes out as "
            what += f"{millimetres(check['found_mm'])} ({percent(off)} off)."
            severity = "red" if off > SCALE_RED else "amber"
            yield from _say(severity, what, "Measure both lengths again, centre to centre of the markers.")
    places = [c["position_mm"] for c in figures["cameras"]]
    apart = statistics.median(math.dist(a, b) for i, a in enumerate(places) for b in places[:i])
    if not NEAREST_MM <= apart <= FARTHEST_MM:
        what = f"By this calibration the cameras stand {millimetres(apart)} apart."
        do = "Lengths are wanted in mm: were they given in m or cm? Check lengths_mm, the rods or the points."
        yield from _say("red", what, do)


def _same_place(figures: Figures) -> Iterator[Remark]:
    cameras = figures["cameras"]
    for i, a in enumerate(cameras):
        for b in cameras[:i]:
            if math.dist(a["position_mm"], b["position_mm"]) < SAME_PLACE_MM:
                what = f"Cameras {b['name']} and {a['name']} stand at the same place."
                yield from _say("red", what, "Were one camera's images given for both? Correct the file names.")


def _wand(figures: Figures) -> Iterator[Remark]:
    wand = figures["wand"]
    if not wand or not wand["poses"]:
        return
    limit = sum(wand["known_mm"]) / len(wand["known_mm"])
    error = wand["error_rms_mm"]
    if error > max(WAND_FLOOR_MM, WAND_AMBER * limit):
        severity = "red" if error > max(WAND_FLOOR_MM, WAND_RED * limit) else "amber"
        what = f"The wand's length comes out wrong by {millimetres(error)} RMS in poses that took no part."
        yield from _say(
            severity, what, "Wave it through the whole volume again, slowly; check synchronisation and lengths_mm."
        )
    for cell in wand["by_place"]:
        surely = 4 * (cell["error_sd_mm"] or 0) / math.sqrt(cell["poses"])
        if cell["poses"] >= 5 and abs(cell["error_mean_mm"]) > max(WAND_FLOOR_MM, WAND_AMBER * limit, surely):
            at = ", ".join(number(x, 0) for x in cell["middle_mm"])
            what = f"About ({at})\u00a0mm the wand is {millimetres(abs(cell['error_mean_mm']))} too "
            what += "long." if cell["error_mean_mm"] > 0 else "short."
            yield from _say("amber", what, "More poses there, or a better lens correction, would mend it.")


def _precision(figures: Figures) -> Iterator[Remark]:
    sd = figures["precision"]["sd_95_mm"]
    if sd is not None and sd > SD_AMBER_MM:
        severity = "red" if sd > SD_RED_MM else "amber"
        what = (
            f"The standard deviation of a position reaches {millimetres(sd)} per axis within 95\u00a0% of the volume."
        )
        yield from _say(severity, what, "Set cameras wider apart or nearer, and use more calibration points.")
    flat = figures["precision"]["angle_below_20_deg_share"]
    if flat > FLAT_SHARE:
        what = f"In {percent(flat)} of the volume all rays meet at less than 20°, so depth is poorly known."
        yield from _say("amber", what, "Set the cameras wider apart.")
    if not figures["precision"]["calibration_known"]:
        what = "The calibration states no uncertainty, so the map shows what the centroids alone would leave."
        yield from _say("info", what, "Calibrate from images in this session to know more.")


def _lens(figures: Figures) -> Iterator[Remark]:
    bare = [c["name"] for c in figures["cameras"] if not c["lens_fitted"] and not any(c["distortion"])]
    if bare:
        what = f"{some('camera', bare).capitalize()} {'has' if len(bare) == 1 else 'have'} no lens correction."
        yield from _say("info", what, "With eleven points or more, or a linearisation grid, the lens is measured too.")
    ratios = {c["name"]: c["focal_px"][0] / c["focal_px"][1] for c in figures["cameras"]}
    odd = [name for name, ratio in ratios.items() if min(abs(ratio - 1), abs(ratio - 2)) > STRETCH]
    if odd:
        what = f"The pixels of {some('camera', odd)} would not be square by this calibration."
        yield from _say("amber", what, "Check the coordinates of the points, unless the sensor is such.")
    bent = [s["name"] for s in figures["straightness"] if (s["after_px"] or 0) > CALIBRATION_AMBER_PX]
    if bent:
        what = f"Rows of the linearisation grid stay bent in {some('camera', bent)}."
        yield from _say("amber", what, "Allow more lens terms, or check that the grid is flat.")


def _moved(figures: Figures) -> Iterator[Remark]:
    if not figures["change"]:
        return
    rows = figures["change"]["cameras"]
    gone = [c["name"] for c in rows if (c["moved_mm"] or 0) > MOVED_MM or (c["image_px"] or 0) > MOVED_PX]
    if gone and len(gone) < len(rows):
        what = f"Since the calibration before, {some('camera', gone)} moved against the others."
        yield from _say("info", what, "Trials recorded in between may need either calibration: the former one is kept.")


def _doubtful(figures: Figures) -> Iterator[Remark]:
    for doubt in figures["doubts"]:
        yield from _say("amber", doubt, "")


CHECKS = (
    *(_judged, _residual, _unlike_others, _left_out, _points, _views, _loss, _image, _scale, _same_place, _wand),
    *(_precision, _lens, _moved, _doubtful),
)
