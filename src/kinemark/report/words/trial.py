"""What findings about a trial say: its recording, points, markers and tracks."""

from __future__ import annotations

from ...data import Finding
from .template import Words, fill, shown
from .verdicts import calibration_headline


def _no_points(found: Finding) -> str:
    if found.values["diagnosed"]:
        return "See the diagnostics below."
    return "Check that the calibration belongs to this camera set-up and that the cameras are synchronised."


def _model_unused(found: Finding) -> str:
    why = {
        "unrecognised": "its markers were not found among the tracks, by the lengths and directions of its segments.",
        "no_neighbour": "where its markers were missing, in {missing} frames of all markers together, none that they "
        "are connected with was in sight.",
        "not_needed": "none of its markers was missing.",
    }
    said = why.get(str(found.values["why"]), "it was not used.")
    return fill(f"The angle model of [track] corrected nothing: {said}", found)


def _model_unused_advice(found: Finding) -> str:
    if found.values["why"] == "unrecognised":
        return (
            "All its markers must be in sight for learning_time once tracks have begun, and the motion must be the "
            "model's, in the same direction in the laboratory. Give a model of this motion, or leave angle_model out."
        )
    if found.values["why"] == "no_neighbour":
        return "Identities there are the predictor's alone: look at the gaps, or give a model with more markers."
    return "Nothing is to be done."


def _calibration_verdict(found: Finding) -> str:
    return f"On the calibration: {calibration_headline(found)}"


def _incomplete(found: Finding) -> str:
    least = "; the least complete: {markers}" if found.markers else ""
    return fill(
        f"Only {{complete_share}} of the marker positions are there while the subject is in view{least}.", found
    )


def _standing(found: Finding) -> str:
    spots, at = found.values["spots_list"], found.values["at_list"]
    assert isinstance(spots, tuple) and isinstance(at, tuple)
    said = "; ".join(f"{c} {n}, at {places} px" for c, n, places in zip(found.cameras, spots, at, strict=False))
    share = fill("up to {images_share} of a camera's images", found)
    return f"Places where something shines that does not move while the markers do: {said} ({share})."


def _contradicted(found: Finding) -> str:
    stated = found.values["stated_hz_list"]
    assert isinstance(stated, tuple)
    said = ", ".join(f"{name} {shown(rate, 'Hz')}" for name, rate in zip(found.cameras, stated, strict=False))
    return fill("The session says {rate_hz} and the videos say otherwise: ", found) + f"{said}."


def _scale(found: Finding) -> str:
    wide = " and are {marker_mm:1} wide" if found.values["marker_mm"] is not None else ""
    return fill(
        "By the calibration's unit of length the markers are {distance_mm:0} from the cameras, lie within "
        f"{{extent_mm:0}} of each other{wide}.",
        found,
    )


def _left_outside(found: Finding) -> str:
    said = fill(
        "{points} tracked points ({points_share}) lie more than {margin_mm} outside the control volume and were left "
        "out, at x, y, z from {least_mm_list} to {greatest_mm_list}.",
        found,
    )
    of = fill(" Of {markers} nothing is left.", found) if found.markers else ""
    unit = found.values["unit"]
    return said + of + (f" In {unit} it would hold them: volume_mm was probably not written in mm." if unit else "")


def _close(found: Finding) -> str:
    numbers = {kind: n for kind, n in found.values.items() if isinstance(n, int) and n}
    kinds = ", ".join(
        f"{n} possible {kind}{'' if n == 1 else 'es' if kind == 'stitch' else 's'}" for kind, n in numbers.items()
    )
    total = sum(numbers.values())
    return (
        f"{total} {'decision' if total == 1 else 'decisions'} of the tracking {'was' if total == 1 else 'were'} close"
        + (f": {kinds}." if kinds else ".")
    )


RATE = "Correct rate_hz, or the rate in the file: every speed and every limit of [track] depends on it."

TRIAL_WORDS = {
    "no_frames": Words("The recording has no frames.", "Check that the trial names the right images or detections."),
    "no_detections": Words(
        "No camera saw any marker.",
        "Lower the threshold in [detect], set inverted = true there where markers are dark on bright ground, or check "
        "exposure and lights.",
    ),
    "no_points": Words("The cameras saw markers, but no marker was reconstructed.", _no_points),
    "no_trajectories": Words(
        "3D points were reconstructed, but no trajectory came of them.",
        "Check the parameters of [track]: the shortest track, and the speed of markers; and rate_hz.",
    ),
    "ground_subtracted": Words(
        "The static ground was subtracted from the images of {cameras}: it is uneven.",
        "Markers before lamps as bright as they are cannot be seen: close the aperture or shorten the exposure until "
        "lamps are darker than markers, and mask lamps of a marker's size. If a marker that stands still is missing "
        'there, set background = "none" in [detect].',
    ),
    "angle_model_unused": Words(_model_unused, _model_unused_advice),
    "calibration_residual_high": Words(
        "The calibration itself is poor (residual above {limit_px:0}) in {cameras}.",
        "Look for misread control points and calibrate again.",
    ),
    "calibration_verdict": Words(_calibration_verdict, "See under Calibration, or calibration.html."),
    "detections_unused": Words(
        "Much of what {cameras} saw became no part of a 3D point (used: {used_share} or more).",
        "Mask reflections and lamps in view; if there are none, suspect calibration or synchronisation.",
    ),
    "reflections_standing": Words(
        _standing,
        "Cover them, or mask them under [masks]; if they are markers on something that does not move, all is well.",
    ),
    "images_fleeting": Words(
        "Many images in {cameras} flash up for one frame and belong to no marker (up to {images_share} of a camera's).",
        "Raise the threshold or the least area in [detect], or look for flickering light.",
    ),
    "two_camera_points": Words(
        "{points_share} of the points rest on only two cameras, which cannot check one another.",
        "Add cameras or turn them so that at least three see every marker.",
    ),
    "scale_impossible": Words(
        "By this calibration the outermost cameras stand {apart_mm} from each other: its unit of length is probably "
        "another one.",
        "Correct length_unit in [calibration], or the lengths that calibrated: all positions are as wrong.",
    ),
    "length_unit_doubtful": Words(
        _scale,
        "If a whole person was recorded, the calibration has another unit of length: correct length_unit in "
        "[calibration], or units in its file. If it was a hand or a face, all is well.",
    ),
    "pixels_not_square": Words(
        "The pixels of {cameras} would not be square by this calibration.",
        "Check the coordinates of the control points, unless the sensor has such pixels.",
    ),
    "camera_fewer_images": Words(
        "{Cameras} has {images} images, and others have {most_images}. They were taken as the first ones.",
        "If it lost images in between, those after stand in wrong frames: put black ones in their places. If it began "
        "late, state its delays_ms below [cameras]: kinemark starts tells by how much.",
    ),
    "frame_rate_contradicted": Words(
        _contradicted,
        "Correct the one that is wrong: times and speeds are as right as rate_hz. High-speed cameras often store a "
        "slower rate, and a field of interlaced video is a frame.",
    ),
    "channels_resampled": Words(
        "{channels} channels at {rate_hz} are interpolated to {stored_rate_hz} in the C3D file, which has one rate.",
        "Take them from the recording's own file where every sample counts.",
    ),
    "channels_cut": Words(
        "{channels} channels go on for {duration_s} beyond the frames; the C3D file does not hold the rest.",
        "Take them from the recording's own file where that counts.",
    ),
    "recording_partly_read": Words(
        "Of the recording's file these parts could not be read: {parts_list}.",
        "All else was read. Export the recording again where these parts are wanted.",
    ),
    "recording_notes": Words("Of the recording's file: {parts_list}.", "What was asked for is complete."),
    "nothing_goes_on": Words(
        "The cameras agree in single frames, but no track continues from one frame to the next: {rate_hz} is not the "
        "frame rate of the recording, or too low for what was recorded, as a wheel that turns fast.",
        f"{RATE} Where the rate is right, record at a higher one.",
    ),
    "too_few_frames": Words(
        "The recording has {frame_count} {frame_count:frame|frames}, and a track needs {least}: it is known by its "
        "motion.",
        'Record some more; or set method = "distance_only" under [track], which needs no motion.',
    ),
    "speeds_impossible": Words(
        "Markers move at {speed_m_s}, faster than people but sprinters and throwers: {rate_hz} is probably not the "
        "frame rate, unless a ball, a racket or a machine was recorded.",
        RATE,
    ),
    "points_dropped_outside": Words(
        _left_outside,
        "Enlarge volume_mm, or set within_volume = false under [reconstruct], if the subject was there.",
    ),
    "positions_uncertain": Words(
        "{points} positions ({points_share}) have a standard deviation above {limit_mm}.",
        "Their covariance says in which direction; add a camera from another side.",
    ),
    "markers_never_seen": Words(
        "No position in any frame: {markers}.",
        "A position needs two cameras that see {markers:it|them}: {markers:it|they} may have been out of view or "
        "hidden, not worn, or not labelled. Turn cameras, or take {markers:it|them} out of the marker set.",
    ),
    "incomplete": Words(
        _incomplete, "See under Markers where they are missing; add or turn cameras to cover those places."
    ),
    "tracks_broken": Words(
        "{tracks} {tracks:track|tracks} for about {markers_worn} {markers_worn:marker|markers}: a marker that was "
        "hidden for long begins a new one.",
        "Give the fragments of a marker one name, and fill what is missing between them.",
    ),
    "tracks_continue": Words(
        "{tracks} {tracks:track likely continues an earlier one|tracks likely continue earlier ones} after a gap, and "
        "{tracks:is|are} not joined to {tracks:it|them}: earlier {earlier_list}, later {later_list}.",
        "Names that are given to both, by identification or by hand, join them.",
    ),
    "tracks_still": Words(
        "{markers:Track|Tracks} {marker_names} {markers:stays|stay} within {limit_mm:1} while the others move by "
        "{moved_mm:0}: probably {markers:a lamp or reflection|lamps or reflections}, and counted among the markers.",
        "Cover them, or mask them under [masks]; if they are markers on something that does not move, all is well.",
    ),
    "tracks_mirrored": Words(
        "{markers:Track|Tracks} {marker_names} {markers:is a mirror image of another|are mirror images of others}, "
        "as in a wet floor or a window: no {markers:marker|markers}, though counted among them.",
        "Cover or dry what mirrors, or mask it under [masks]; delete {markers:this track|these tracks}.",
    ),
    "tracks_confusable": Words(
        "In {decisions} {decisions:place|places}, {points_share} of all points, tracks came so near for the rate that "
        "they may have been exchanged.",
        "Trust no name there before you have looked: of such places in simulated walks at 25 and 30 Hz one in 10 to 20 "
        "was an exchange. They are the first of the decisions that were close. Record at a higher rate, or with more "
        "cameras.",
    ),
    "rate_too_low": Words(
        "In {points_share} of the points markers leave their course between two frames by more than half of their "
        "distance to the next marker: at {rate_hz} their motion does not tell them apart.",
        "Record at a higher rate, or put markers farther apart where they move fast; look at exchanges there.",
    ),
    "long_gaps": Words(
        "Gaps longer than {limit_s:.3g} in {markers}.",
        "Fill them from neighbouring markers on the same segment, or leave these stretches out.",
    ),
    "much_filled": Words(
        "More than {limit_share} of the samples are filled, not measured, in {markers}.",
        "Compare {markers:it|them} with a repeated trial before reading fine detail from {markers:it|them}.",
    ),
    "markers_uncertain": Words(
        "A standard deviation above {limit_mm:.3g} per axis in {markers}.",
        "Have more cameras see {markers:it|them} from wider apart; do not read angles of small segments from "
        "{markers:it|them}.",
    ),
    "noise_above_deviation": Words(
        "Positions tremble by {noise_mm:2} from frame to frame, and their standard deviation is stated as {sd_mm:2}.",
        "Do not trust the stated standard deviations, nor those of angles; check the noise that the detections state.",
    ),
    "outside_volume": Words(
        "{samples_share} of the samples lie outside the control volume, where the calibration was not checked.",
        "Trust them less, or calibrate a larger volume.",
    ),
    "unnamed_trajectories": Words(
        "{unnamed} of {trajectories} {trajectories:trajectory|trajectories} {unnamed:has|have} no marker name.",
        "Name {unnamed:it|them} before computing angles: on the screen Labels of kinemark studio, or with kinemark "
        "label by a labelled trial of the subject. With [label] in session.toml, one named trial names the others.",
    ),
    "points_in_no_track": Words(
        "{points_share} of the 3D points belong to no track: ghosts, or markers that were lost.",
        "Click them in the scene: if they follow the subject, check rate_hz and the parameters of [track].",
    ),
    "close_decisions": Words(_close, "The report lists them with times and reasons, under Decisions that were close."),
}
