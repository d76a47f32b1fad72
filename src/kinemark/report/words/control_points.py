"""What the judgement of control points says."""

from __future__ import annotations

import math
from itertools import zip_longest
from typing import cast

from ...data import Finding
from .template import Words, fill, listed, shown

LENS = "Allow more lens terms, or measure the points again."


def _limit(found: Finding) -> str:
    """What a calibration of that grade misses."""
    if found.severity == "info":
        return ""
    if found.severity == "amber":
        return fill(" A good calibration has 1 part in {limit_parts} or less for certain.", found)
    return fill(" More than 1 part in {limit_parts} is bad.", found)


def _return(found: Finding) -> str:
    return fill(
        "Control points that took no part come back {rms_mm:.2g} from where they were surveyed (RMS; farthest "
        "{max_point}, {max_mm:.2g}), 1 part in {parts} of the volume's diagonal of {diagonal_m:.2g}.",
        found,
    ) + _limit(found)


def _by_residual(found: Finding) -> str:
    alone = found.values["alone"]
    why = "One camera alone places no points" if alone else "The points are too few to leave one out as a test"
    return fill(
        f"{why}. By the residuals, with {{equations}} {{equations:equation|equations}} left over, points are "
        "{error_px:.2g} off, 1 part in {parts_least} to {parts_most} of the images' extent.",
        found,
    ) + _limit(found)


def _left_out(found: Finding) -> str:
    points, far, places = (_items(found, name) for name in ("points_list", "off_px_list", "place_of_list"))
    rows = zip_longest(points, far, places)
    each = [
        f"{point} ({shown(off, 'px', '1')} off{f', where {place} belongs' if place else ''})"
        for point, off, place in rows
    ]
    return f"{fill('{Cameras}', found)} left out {len(points)} of its points: {listed(each)}."


def _items(found: Finding, name: str) -> tuple[object, ...]:
    value = found.values[name]
    return value if isinstance(value, tuple) else ()


def _swapped(found: Finding) -> str:
    points, images = _items(found, "points_list"), _items(found, "image_of_list")
    of = dict(zip(points, images, strict=False))
    order = list(of)
    pairs = [(a, b) for k, (a, b) in enumerate(of.items()) if b in order[k + 1 :] and of[b] == a]
    if 2 * len(pairs) == len(points):
        what = f"control points seem to be swapped, {' and '.join(f'{a} with {b}' for a, b in pairs)}"
    else:
        rows = ", ".join(f"{a} is where {b} was said to be" for a, b in of.items())
        what = f"control points seem to be mistaken for one another: {rows}"
    after = fill("the other way round the residual falls from {before_px:1} to {after_px:1}", found)
    return f"{fill('{Cameras}', found)}: {what}; {after}."


def _displaced(found: Finding) -> str:
    text = "All cameras agree that control {points_list:point|points} {points_list} {points_list:is|are} not at the "
    text += "surveyed {points_list:place|places} but "
    if found.values["where"] == "other":
        text += "each at that of the other"
    elif found.values["where"] == "alike":
        shift = cast("tuple[float, ...]", found.values["shift_mm_list"])
        away = shown(math.hypot(*shift), "mm", ".3g")
        text += f"{away} away, by ({{shift_mm_list:1}})"
    else:
        text += "{least_mm:.3g} to {greatest_mm:.3g} away"
    less = zip_longest(_items(found, "less_points_list"), _items(found, "less_mm_list"))
    rows = [f"{point} ({shown(mm, 'mm', '.2g')})" for point, mm in less]
    return f"{fill(text, found)}.{f' Less far off: {listed(rows)}.' if rows else ''} {_effect(found)}"


def _effect(found: Finding) -> str:
    if found.values["before_px"] is None:
        return "No camera used them."
    return fill("Without them residuals fall from {before_px:.2g} to {after_px:.2g}.", found)


CONTROL_POINT_WORDS = {
    "control_points_return": Words(_return),
    "control_points_by_residual": Words(_by_residual),
    "no_equations_left": Words(
        "There are as many equations as parameters: the residuals say nothing.", "Use eight points or more."
    ),
    "cameras_miss_control_points": Words(
        "{Cameras} {cameras:misses its|miss their} control points by {residual_px_list:.2g} RMS, more than 1 part in "
        "{limit_parts} of the images' extent.",
        "Check that the images are those of {cameras:this camera|these cameras}, and the places of the points.",
    ),
    "cameras_worse_than_others": Words(
        "{Cameras} {cameras:misses its|miss their} control points by {residual_px_list:.2g} RMS, at least "
        "{limit_ratio:0} times as far as the others.",
        "Check the points in {cameras:its|their} images, focus and lens.",
    ),
    "residuals_above_noise": Words(
        "Residuals of {residual_px:.2g} are {ratio:0} times what the noise of the centroids explains. Lens terms, the "
        "survey or the points themselves are wrong by the rest.",
        LENS,
    ),
    "control_points_left_out": Words(_left_out, "Check these points in the images of that camera."),
    "control_points_swapped": Words(_swapped, "Correct their order."),
    "control_point_misplaced": Words(
        "{Cameras}: control point {point} seems to be misplaced or taken for another; without it the residual falls "
        "from {before_px:1} to {after_px:1}.",
        "Point at it again, or leave it out.",
    ),
    "control_points_displaced": Words(_displaced, "Measure again, or leave out."),
    "focal_length_uncertain": Words(
        "{Cameras}: its points leave the focal length uncertain by {sd_share}. They are few, nearly in a plane, or "
        "fill only a part of the image.",
        "Use more points, spread in depth and over the whole image.",
    ),
    "control_points_unseen": Words(
        "No camera sees {points_list}: hidden, or not where the description says.",
        "Check the description, and what hides {points_list:it|them}.",
    ),
    "control_points_seen_by_few": Words(
        "Less than half of the cameras see {points_list}: hidden, or not where the description says.",
        "Check the description, and what hides {points_list:it|them}.",
    ),
}
