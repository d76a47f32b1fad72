"""What verdicts say: their headlines, and statements on what was measured and how well."""

from __future__ import annotations

from ...data import Finding
from .template import Words, fill, shown

SOURCES = {
    "centroid noise": "the noise of the centroids",
    "disturbed images": "images that are disturbed",
    "marker placement": "where the markers are put on",
}
"""Sources of error as a sentence has them, where that is more than "the" and their names."""
BOUND_MM = 0.01
"""A length below this is only bounded; chosen."""


def calibration_headline(found: Finding) -> str:
    """What a calibration is good for; of `calibration_…` or `calibration_verdict`."""
    grade = found.values.get("grade") or {"calibration_good": "green", "calibration_usable": "amber"}.get(found.kind)
    if grade == "green":
        return f"The calibration is good: {_good_for(found)}."
    if grade == "amber":
        return f"Usable with care: {_good_for(found)}, but first look at what needs attention."
    if "unknown" in (grade, found.kind.removeprefix("calibration_")):
        return "What this calibration is good for is not known: it states no uncertainty."
    return "Do not use this calibration: what needs attention says why."


def _good_for(found: Finding) -> str:
    sd, volume = found.values["sd_mm"], found.values["volume_share"]
    if sd is None or volume is None:
        return "less than half of the volume is seen by two cameras"
    part = "half" if volume == 0.5 else shown(volume, "share").replace(".0", "")
    return f"a marker is placed to {shown(sd, 'mm')} per axis in {part} of the volume"


def _recorded(found: Finding) -> str:
    tracks = found.values["track_count"]
    about = "about " if tracks is not None else ""
    tracks = ", in {track_count} {track_count:track|tracks}," if tracks is not None else ""
    return fill(
        f"{{camera_count}} {{camera_count:camera|cameras}} followed {about}{{marker_count}} "
        f"{{marker_count:marker|markers}}{tracks} for {{duration_s}} ({{frame_count}} {{frame_count:frame|frames}} at "
        "{rate_hz}).",
        found,
    )


def _complete(found: Finding) -> str:
    shown = ": each camera shows about {shown} markers at once or more" if found.values["shown"] is not None else ""
    return fill(
        f"While the subject was in view ({{frames}}), {{complete_share}} of the marker positions are there"
        f"{shown}{_filled(found)}; {_gaps(found)}.",
        found,
    )


def _not_known(found: Finding) -> str:
    return fill(
        "How complete the markers are is not known: only {used_share} of the images belong to a reconstructed marker, "
        f"so whole markers may be missing. Of those that were found, {{complete_share}} of the positions are there"
        f"{_filled(found)}; {_gaps(found)}.",
        found,
    )


def _filled(found: Finding) -> str:
    return " ({filled_share} of all samples are filled)" if found.values["filled_share"] else ""


def _gaps(found: Finding) -> str:
    if found.values["gaps"]:
        return "{gaps} {gaps:gap|gaps} left, the longest {longest_s}"
    whole = shown(found.values["complete_share"], "share") in ("–", shown(1.0, "share"))
    return "no gaps left" if whole else "no gaps left between a marker's first and last sample"


def _agreement(found: Finding) -> str:
    subject = ", about {at_subject_mm:1} at the subject" if found.values["at_subject_mm"] is not None else ""
    return fill(
        "Half of all image points lie within {residual_px} of where the calibrated cameras expect them" + subject + ".",
        found,
    )


def _deviation(found: Finding) -> str:
    sd, noise = found.values["sd_mm"], found.values["noise_mm"]
    said = fill("The standard deviation of a position is {sd_mm:2} per axis on average", found)
    if not found.values["calibration_known"]:
        said += ", by the images alone, as the calibration states no error"
    if not isinstance(sd, float | int) or not isinstance(noise, float | int):
        return f"{said}."
    if noise > sd:
        return said + fill("; from frame to frame the positions tremble by {noise_mm:2}.", found)
    rest = "the rest is of errors that stay" + (", as the calibration's" if found.values["calibration_known"] else "")
    return said + fill(f", of which {{noise_mm:2}} is noise from frame to frame; {rest}.", found)


def _calibrated_by(found: Finding) -> str:
    v = found.values
    text = "{camera_count} {camera_count:camera|cameras} calibrated by {way}"
    if v["residual_px"] is not None:
        of = " over {images} {images:image|images} of {points} {points:point|points}" if v["images"] else ""
        text += ": the residual is {residual_px:3} RMS" + of
    if v["left_out_px"] is not None:
        text += ", and {left_out_px:3} on points that took no part"
    return fill(text + ".", found)


def _wand_lengths(found: Finding) -> str:
    known = found.values["known_mm_list"]
    assert isinstance(known, tuple)
    length = " + ".join(shown(mm, "count") for mm in known)
    return (
        fill("In {poses} {poses:pose|poses} that took no part, the wand's ", found)
        + f"{length}\u00a0mm come out wrong by "
        + fill("{error_abs_mm} on average (offset {error_mean_mm}, SD {error_sd_mm}).", found)
    )


def _predicted(found: Finding) -> str:
    known = "" if found.values["calibration_known"] else " and a calibration without error, since it states none"
    return fill(
        f"With centroids good to {{centroid_sd_px:3}}{known}, the standard deviation of a marker's position is below "
        "{sd_mm} per axis in 95\u00a0% of the volume, and below {largest_axis_mm} in its least certain direction.",
        found,
    )


def _volume_seen(found: Finding) -> str:
    matters = "; {camera_names} matters most: without it the error would be {ratio:2} times as large"
    return fill(
        "{two_share} of the volume is seen by at least two cameras, {three_share} by three"
        f"{matters if found.cameras else ''}.",
        found,
    )


def _gaps_filled(found: Finding) -> str:
    if found.values["filled"] == found.values["gaps"]:
        return "All gaps are filled"
    return fill("{filled} of {gaps} {gaps:gap|gaps} {filled:is|are} filled", found)


def at_least(mm: object) -> str:
    """A length; where it is too small to matter, only a bound of it."""
    return "less than 0.01\u00a0mm" if isinstance(mm, float | int) and mm < BOUND_MM else shown(mm, "mm")


def _gap_error(found: Finding) -> str:
    median, largest = (at_least(found.values[f"{which}_mm"]) for which in ("median", "max"))
    return (
        f"In the median gap a filled sample is expected to be {median} off, and {largest} at most. That was "
        "measured on this trial: known samples were hidden in gaps of the same length, filled in the same way, "
        "and compared."
    )


def _from_static(found: Finding) -> str:
    return fill(
        "{count} {count:marker|markers} that the trial never shows {count:is|are} placed from the static trial, "
        f"expected to be {at_least(found.values['max_mm'])} off at most; how far neighbours move against each other "
        "tells that.",
        found,
    )


def source_words(name: object) -> str:
    """A source of error as part of a sentence."""
    return SOURCES.get(str(name), f"the {name}")


def _error_of(what: str, frame: str, mean: str) -> Words:
    def text(found: Finding) -> str:
        size = (
            f"{what} is uncertain by {frame} in a single frame, one standard deviation, and by {mean} in a mean over "
        )
        share = "{cycles} {cycles:cycle|cycles}. {variance_share} of the variance is "
        return fill(size + share, found) + f"{source_words(found.values['source'])}."

    return Words(text)


def _error_of_cameras(found: Finding) -> str:
    angle = " and {angle_deg:2} for an angle" if found.values["angle_deg"] is not None else ""
    return fill(f"The cameras' part of it is {{position_mm}} for a marker along each axis{angle}.", found)


def _most_missed(found: Finding) -> str:
    start = fill("Without {camera_names}, the camera most missed, ", found)
    if found.values["without_mm"] is None:
        return f"{start}no point would be left."
    return start + fill(
        "the cameras' part would be {without_mm} instead of {with_mm} where something is left, and {lost_share} of the "
        "points would be gone.",
        found,
    )


VERDICT_WORDS = {
    "trial_good": Words("Good to use."),
    "trial_usable": Words("Usable with care: first look at what needs attention."),
    "trial_unknown": Words(
        "How good these data are is not known: the calibration states no error. Compare a known length, or calibrate "
        "anew, before you trust distances."
    ),
    "trial_unusable": Words("Do not use these data as they are."),
    "recorded": Words(_recorded),
    "completeness": Words(_complete),
    "completeness_unknown": Words(_not_known),
    "agreement": Words(_agreement),
    "position_deviation": Words(_deviation),
    "calibration_good": Words(calibration_headline),
    "calibration_usable": Words(calibration_headline),
    "calibration_unknown": Words(calibration_headline),
    "calibration_unusable": Words(calibration_headline),
    "calibrated_by": Words(_calibrated_by),
    "wand_lengths": Words(_wand_lengths),
    "length_check": Words("{length}, which took no part: {known_mm:2} as measured, {found_mm:2} by the cameras."),
    "predicted_deviation": Words(_predicted),
    "room_deviation": Words(
        "These are errors of positions relative to each other. In the room all of them together may besides be off by "
        "{sd_mm} per axis in 95\u00a0% of the volume, the same in every frame: what says where the room is turns them "
        "by {turn_deg:3} and shifts them by {origin_mm:2} (standard deviations per axis)."
    ),
    "room_deviation_of_trial": Words(
        "In the room all positions together may besides be off by {sd_mm:2} per axis (standard deviation), the same in "
        "every frame. It changes no distance and no angle."
    ),
    "volume_seen": Words(_volume_seen),
    "gaps_filled": Words(_gaps_filled),
    "nothing_to_fill": Words("There was nothing to fill"),
    "no_marker_seen": Words("No marker is seen in this trial"),
    "expected_gap_error": Words(_gap_error),
    "markers_from_static": Words(_from_static),
    "samples_beyond": Words(
        "{samples} {samples:sample|samples} before a marker's first or after its last {samples:is|are} still missing "
        "(--ends fills these too)."
    ),
    "angles_good": Words("The angles hold together"),
    "angles_usable": Words("The angles need attention"),
    "angles_missing": Words("A joint has no angles"),
    "angles_computed": Words("Model {model}, {side} side, {frame_count} {frame_count:frame|frames}."),
    "angle_deviations": Words(
        "Standard deviations by the markers' errors, the median over the frames: from {least_deg} ({least_joint} "
        "{least_angle}) to {greatest_deg} ({greatest_joint} {greatest_angle}). They are a lower bound: placement of "
        "the markers and skin that slides over bone come on top."
    ),
    "cycles_averaged": Words("{cycles} {cycles:cycle|cycles} averaged."),
    "error_limited_by": Words(lambda found: f"What limits this recording is {source_words(found.values['source'])}."),
    "error_of_angle": _error_of("An angle", "{frame_deg:2}", "{mean_deg:2}"),
    "error_of_position": _error_of("A position", "{frame_mm}", "{mean_mm}"),
    "error_of_cameras": Words(_error_of_cameras),
    "placement_assumed": Words(
        "Placement is an assumption, {placement_mm} along each axis; say what yours is. Of what the trial itself "
        "shows, {next_source} is the first."
    ),
    "camera_most_missed": Words(_most_missed),
    "cameras_losing_points": Words("Losing {cameras} takes more than {limit_share} of the points."),
    "two_cameras_no_loss": Words("With two cameras nothing is measured when one is lost."),
}
