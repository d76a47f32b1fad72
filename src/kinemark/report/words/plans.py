"""What a plan of cameras says."""

from __future__ import annotations

from ...data import Finding
from .template import Words, fill


def _what(found: Finding) -> str:
    return "the walking body's markers" if found.values["body"] else "the volume"


def _covers(found: Finding) -> str:
    return fill(
        "{camera_count} {camera_count:camera measures|cameras measure} {two_share} of " + _what(found)
        + " by two or more, {three_share} by three or more.",
        found,
    )  # fmt: skip


def _error(found: Finding) -> str:
    where = "on the walking body" if found.values["body"] else "in the volume"
    known = found.values["calibrated"]
    rest = (
        "; the error of the calibration comes on top"
        if not known
        else "; the error of the calibration counts for {calibrated} {calibrated:camera|cameras}, and comes on top for "
        "the others"
    )
    return fill(
        f"With centroids good to {{centroid_px:3}} a marker {where} is off by {{sd_median_mm}} per axis (standard "
        f"deviation, median), and by less than {{sd_95_mm}} in 95\u00a0%{rest}.",
        found,
    )


PLAN_WORDS = {
    "plan_covers": Words(
        _covers,
        "Add a camera, let cameras stand higher or farther, or take a shorter focal length, and plan again.",
    ),
    "plan_error": Words(_error),
    "plan_volume": Words(
        "Of the empty volume {two_share} is seen by two cameras or more, {three_share} by three or more; σ is "
        "{sd_median_mm} there."
    ),
    "plan_following": Words(
        "One more camera would raise what three or more measure from {three_share} to {three_share_after}, and take σ "
        "from {sd_median_mm} to {sd_median_after_mm}."
    ),
    "plan_camera_most_missed": Words(
        "{Cameras} would be missed most: without it two or more measure {two_share}, and σ is {sd_median_mm}."
    ),
}
"""By kind of finding."""
