"""What findings about a calibration say."""

from __future__ import annotations

from ...data import Finding
from .template import Words, fill, shown


def _volume(found: Finding) -> str:
    return "control volume" if found.values["volume_given"] else "volume (assumed; volume_mm says it)"


def _unseen(found: Finding) -> str:
    return fill(
        f"{{volume_share}} of the {_volume(found)} is seen by fewer than two cameras: nothing is measured there.", found
    )


def _seen_by_two(found: Finding) -> str:
    return fill(
        f"{{volume_share}} of the {_volume(found)} is seen by two cameras only, which cannot check each other.", found
    )


def _indispensable(found: Finding) -> str:
    unseen = found.values["unseen_share"] is not None
    lost = " and {unseen_share} of the volume is no longer measured" if unseen else ""
    return fill(f"Much rests on {{cameras}}: without it the error is {{ratio}} times as large{lost}.", found)


def _lens_advice(found: Finding) -> str:
    radial = "more radial terms (radial = 2 or 3)" if found.values["radial"] else ""
    sideways = "tangential = true, or principal_point = true" if found.values["sideways"] else ""
    wanted = " and ".join(filter(None, (radial, sideways)))
    return f"Fit {wanted} in [calibrate], or linearise the lenses anew."


def _one_place(found: Finding) -> str:
    return f"Cameras {' and '.join(found.cameras)} stand at the same place."


def _wrong_here(found: Finding) -> str:
    error = found.values["error_mm"]
    size = abs(error) if isinstance(error, float | int) else None
    length = "short" if isinstance(error, float | int) and error < 0 else "long"
    return fill("About ({place_mm_list:0}) the wand is ", found) + f"{shown(size, 'mm')} too {length}."


KEPT = {
    "after": "{whose} before that were left out: the cameras are as they stood at the end.",
    "before": "{whose} from there on were left out, as they are too few, and the errors of the camera are stated as "
    "larger by the move.",
    "all": "All images were used, and the errors of the camera are stated as larger by the move.",
}
"""What `camera_moved_while_calibrating` says of the images that were kept; nothing where that is not known."""


def _moved_meanwhile(found: Finding) -> str:
    since = "from about frame {first_frame} on ({from_s:1} from the beginning)"
    kept, whose = KEPT.get(str(found.values["kept"]), ""), "Its images" if found.cameras else "All images"
    if found.cameras:
        said = f"{{Cameras}} was probably moved while calibrating: {since} its images lie {{offset_px:1}} beside."
    else:
        said = (
            f"The cameras do not fit each other the whole time while calibrating: {since} one of them was probably "
            "moved, by {offset_px:1} in its image."
        )
    return fill(f"{said} {kept.format(whose=whose)}".strip(), found)


def _lost_images(found: Finding) -> str:
    """Which camera lost images, or took some twice; of two cameras it may be either."""
    images = found.values["images"]
    n = abs(images) if isinstance(images, int) else None
    how = "took twice" if isinstance(images, int) and images < 0 else "lost"
    what = f"{shown(n, 'count')} image{'s' * (n != 1)}"
    when = "between frames {frames}" if found.frames else "at a time that is not known"
    if found.frames and found.frames[0][0] == found.frames[0][1]:
        when = "about frame {first_frame}"
    said = f"{{Cameras}} {how} {what}" if found.cameras else f"One of the two cameras lost or took twice {what}"
    return fill(f"{said} of the wand, {when}. The others were put in the frames that they show.", found)


def _world_elsewhere(found: Finding) -> str:
    if found.cameras:
        return fill(
            "{Cameras} sees the L-frame or the points of the world {offset_px:1} beside where the other cameras see "
            "them; it was left out of placing the world.",
            found,
        )
    return fill(
        "The cameras do not agree where the L-frame or the points of the world are: by {offset_px:1}, and nobody "
        "knows which camera is wrong. So may the world be.",
        found,
    )


def _world_points(found: Finding) -> str:
    if not found.values["points_list"]:
        return fill(
            "The points of the world do not lie as they are surveyed: {rms_mm} RMS off, the worst by {off_mm}.", found
        )
    return fill(
        "{points_list:Point|Points} {points_list} of the world {points_list:lies|lie} up to {off_mm} from where "
        "{points_list:it is|they are} surveyed, and {points_list:was|were} left out; the others fit to {rms_mm} RMS.",
        found,
    )


def _world_mirrored(found: Finding) -> str:
    if found.severity == "info":
        return "All cameras see the world mirrored: v is counted from the bottom, or the coordinates are left-handed."
    return "All cameras see the world mirrored: the coordinates are left-handed, or all images are mirrored."


CALIBRATION_WORDS = {
    "cameras_miss_points": Words(
        "{Cameras} {cameras:misses|miss} the calibration points by up to {max_px:1} RMS.",
        "Check that {cameras:its images are its|their images are their} own and not another camera's, and the places "
        "of the points; then repeat.",
    ),
    "camera_fits_worse": Words(
        "{Cameras} fits worse than the others: {residual_px} against {others_px}.",
        "It may have moved while calibrating, be out of focus or out of time, or have another camera's images.",
    ),
    "left_out_errors_large": Words(
        "In {cameras} points that took no part are missed by up to {ratio} times the residual: the few points that "
        "there are decide too much.",
        "Use more points, spread over the whole image, or fewer lens terms.",
    ),
    "control_points_disagree": Words(
        "The other points do not agree with control {points_list:point|points} {points_list}: off by up to "
        "{max_px:1} when left out.",
        "Measure {points_list:its place|their places} again, or check that {points_list:it was not mistaken for "
        "another|they were not mistaken for others}.",
    ),
    "images_left_out": Words(
        "{images_share} of all images of points fitted so badly that they were left out.",
        "Look for reflections, wrong matches and cameras out of time.",
    ),
    "volume_unseen": Words(_unseen, "Turn or move cameras, see the map; or set volume_mm to what is used."),
    "volume_seen_by_two": Words(_seen_by_two, "Turn or add cameras so that three see every place."),
    "two_cameras_only": Words("There are two cameras: when one is lost or a marker hidden, so is the measurement."),
    "camera_indispensable": Words(
        _indispensable, "Check this camera first when something is wrong; another near it would help."
    ),
    "points_cover_part": Words(
        "In {cameras} the calibration points cover only part of the volume (least: {least_share}).",
        "Bring points or the wand to the corners of the images: beyond the points the lens is a guess.",
    ),
    "lens_uncertain": Words(
        "In parts of the images of {cameras} the lens is hardly determined: places of the volume are uncertain by up "
        "to {max_px:1} there.",
        "Use more points near the corners, or fewer lens terms.",
    ),
    "points_outside_image": Words(
        "Points lie outside the images of {cameras}: up to {most_share} of all that one camera saw.",
        "Correct size_px (width, height) of the camera, or the names, if the files of two cameras were exchanged.",
    ),
    "lens_folds": Words(
        "Near the edges of the images of {cameras} (up to {most_share} of an image) the lens correction turns back on "
        "itself: markers seen there are not used.",
        "Calibrate with points, or the wand, near these edges; a very wide lens needs three radial terms.",
    ),
    "scale_doubtful": Words(
        "The scale is uncertain: {length} is {known_mm} and comes out as {found_mm} ({error_share} off).",
        "Measure both lengths again, centre to centre of the markers.",
    ),
    "cameras_distance_implausible": Words(
        "By this calibration the cameras stand {apart_mm} apart.",
        "Lengths are wanted in mm: were they given in m or cm? Check lengths_mm, the rods or the points.",
    ),
    "cameras_at_one_place": Words(_one_place, "Were one camera's images given for both? Correct the file names."),
    "wand_length_wrong": Words(
        "The wand's length comes out wrong by {rms_mm} RMS in poses that took no part.",
        "Wave it through the whole volume again, slowly; check synchronisation and lengths_mm.",
    ),
    "wand_length_wrong_here": Words(_wrong_here, "Use more poses there, or a better lens correction."),
    "film_halves_differ": Words(
        "One half of the recording fits cameras of its own much better than the cameras of all of it (squares of "
        "residuals are {ratio:.1f} times as large by these): something changed meanwhile, and the errors are larger "
        "than stated.",
        "Record again: touch no camera, and check that no recording has lost images. Of three cameras or more it is "
        "told which one it was.",
    ),
    "wand_gaps_differ": Words(
        "The gaps between the wand's markers are given as {stated_mm_list:.5g} and come out as {seen_mm_list:.5g}. "
        "These were used, with the whole length as it is given.",
        "Measure them again, from centre to centre, and the whole length too: the scale rests on it.",
    ),
    "camera_moved_while_calibrating": Words(
        _moved_meanwhile,
        "Trials that were recorded on the other side of the move do not fit: wave again for these, and touch no "
        "camera; or leave that camera out.",
    ),
    "camera_late_while_calibrating": Words(
        "{Cameras} took its images of the wand {late_images:.3g} images ({delay_ms:3}) later than the others. They "
        "were moved in time.",
        "Check that all cameras are started and triggered together. Trials try this delay, and say so where they keep "
        "to it. If this one is always late by as much, state its delays_ms below [cameras].",
    ),
    "camera_lost_images_while_calibrating": Words(
        _lost_images,
        "Check that this camera records every image: its disk, its cable, its program. It may lose images of a trial, "
        "too.",
    ),
    "l_frame_moved": Words(
        "In {frame_count} of {read_frames} frames the L-frame stood elsewhere, by up to {off_mm:.2g}. "
        "They were left out.",
        "Record it once more, lying still on the floor, if these are many.",
    ),
    "world_seen_elsewhere": Words(
        _world_elsewhere,
        "Was a camera moved or turned after the wand was waved, or are two recordings exchanged? Wave the wand again "
        "if so: whatever that camera sees since is off by as much.",
    ),
    "world_points_disagree": Words(
        _world_points,
        "Measure these points again and look for exchanged names, a typed digit and other units: the origin and the "
        "axes rest on them.",
    ),
    "cameras_mirrored": Words(
        "{Cameras} {cameras:sees|see} the world mirrored, and the others do not.",
        "That is right only if {cameras:its|their} recordings are mirrored in the same way. Count pixels of all "
        "cameras from the top left corner.",
    ),
    "coordinates_mirrored": Words(
        _world_mirrored,
        "Check the directions of x, y and z: from the end of z, x turns to y against the clock. Else left and right "
        "are exchanged in all that follows.",
    ),
    "cameras_upside_down": Words(
        "All cameras are upside down in this world. If they do not hang so, the file counts v from the bottom, and the "
        "world is mirrored: left and right are exchanged.",
        "Write v from the top, height − 1 − v, in the files of the wand, the L-frame and all trials.",
    ),
    "precision_low": Words(
        "The standard deviation of a position reaches {sd_mm} per axis within 95\u00a0% of the volume.",
        "Set cameras wider apart or nearer, and use more calibration points.",
    ),
    "room_uncertain": Words(
        "Where the room is, is known less well than what is in it: all positions together may be off by {sd_mm} per "
        "axis. Distances, angles and movements are not affected.",
        "Record the L-frame longer, in the middle of the volume or with longer arms, where more cameras see it.",
    ),
    "rays_nearly_parallel": Words(
        "In {volume_share} of the volume all rays meet at less than {limit_deg:0}, so depth is poorly known.",
        "Set the cameras wider apart.",
    ),
    "no_uncertainty_stated": Words(
        "The calibration states no uncertainty, so the map shows what the centroids alone would leave.",
        "Calibrate from images in this session to know more.",
    ),
    "no_lens_correction": Words(
        "{Cameras} {cameras:has|have} no lens correction.",
        "With eleven points or more, or a linearisation grid, the lens is measured too.",
    ),
    "lens_term_missing": Words(
        "In {cameras} the residuals go with the place in the image, by {max_px:2} RMS, {noise_share} of their noise: "
        "the lenses have terms that were not fitted. Positions are off by more than their standard deviation says.",
        _lens_advice,
    ),
    "grid_rows_bent": Words(
        "Rows of the linearisation grid stay bent in {cameras}.",
        "Allow more lens terms, or check that the grid is flat.",
    ),
    "cameras_moved_since": Words(
        "Since the calibration before, {cameras} moved against the others.",
        "Trials recorded in between may need either calibration: the former one is kept.",
    ),
    "world_of_first_camera": Words(
        "The world is that of the first camera: nothing says where the floor is.",
        "Give l_frame or world_points in [calibration].",
    ),
    "grid_partly_used": Words("{Cameras}: only a part of the grid in an image was used. {reason}"),
    "grid_image_unused": Words("{Cameras}: an image of the grid was not used. {reason}"),
}
