"""What findings about the cameras of a trial say."""

from __future__ import annotations

import math

from ...data import Finding
from .template import Words, fill, shown

FAR_ABOVE = 100
"""Times as large as the others', above which the number says no more; chosen."""

COUNTED = {
    "v_up": "v is counted from the bottom of the images",
    "u_left": "u is counted from the right of the images",
    "turned": "pixels are counted from the bottom right corner of the images",
    "exchanged": "u and v are exchanged",
    "centre": "u and v are counted from the middle of the images",
    "centre_v_up": "u and v are counted from the middle of the images, v upwards",
    "share": "u and v are shares of the images' width and height, not pixels",
    "share_v_up": "u and v are shares of the images' width and height, not pixels, and v goes upwards",
    "half_size": "the images have half the size of those that were calibrated",
    "double_size": "the images have twice the size of those that were calibrated",
}

LOOK_AT_CAMERA = "Look at that camera in a second trial: calibrate again if it was moved, or leave it out."


def _disagrees(found: Finding) -> str:
    ratio = found.values["ratio"]
    times = fill("{ratio} times", found) if isinstance(ratio, float | int) and ratio < FAR_ABOVE else "far above"
    u, v = (shown(found.values[f"offset_{axis}_px"], "ratio", "2") for axis in "uv")
    start = fill("{Cameras} disagrees with the others: its median residual is {residual_px}, ", found)
    return f"{start}{times} theirs; its image is offset by ({u}, {v})\u00a0px."


def _swapped(found: Finding) -> str:
    pairs = [f"{a} and {b}" for a, b in zip(found.cameras[::2], found.cameras[1::2], strict=False)]
    return f"The images of {', or of '.join(pairs)} seem to be swapped" + fill(
        ": with each taken for the other {swapped_share} of what they saw agrees with two more cameras, and "
        "{as_is_share} or less as it is.",
        found,
    )


def _same_images(found: Finding) -> str:
    return f"Cameras {' and '.join(found.cameras)} have the same images: one file is given for both."


def _in_order(found: Finding) -> str:
    images_of = found.values["images_of_list"]
    assert isinstance(images_of, tuple)
    rows = ", ".join(f"{name} has those of {other}" for name, other in zip(found.cameras, images_of, strict=False))
    return f"Cameras have each other's images: {rows}. Each was taken for the one whose images it has, and used."


def _pixel_axes(found: Finding) -> str:
    way = COUNTED.get(str(found.values["way"]), "pixels are counted along other axes than the calibration's")
    return f"It seems that {way}" + fill(
        ": so {other_share} of what a camera saw agrees with two more cameras, and {as_is_share} as it is.", found
    )


def _out_of_sync(found: Finding) -> str:
    delay, frames = (_number(found, f"delay_{unit}") for unit in ("ms", "frames"))
    later = "earlier" if delay < 0 else "later"
    return fill(
        f"{{Cameras}} takes its images {shown(abs(delay), 'ms')} {later} than the others, "
        f"{shown(abs(frames), 'frames')} of a frame, which moves its images by up to {{shift_px:1}}.",
        found,
    )


def _delay_learned(found: Finding) -> str:
    delay, error = (_number(found, name) for name in ("delay_ms", "delay_se_ms"))
    later = "earlier" if delay < 0 else "later"
    return fill(
        f"{{Cameras}} takes its images {shown(abs(delay), 'ms')} ± {shown(error, 'ms')} {later} than the others. All "
        "was tracked with its images moved to the times of the frames.",
        found,
    )


def _late_as_calibrated(found: Finding) -> str:
    ms = _number(found, "delay_ms")
    return fill(
        f"{{Cameras}} was tracked as {shown(abs(ms), 'ms')} {'earlier' if ms < 0 else 'later'} than the others, as the "
        "film of the calibration told: its images fit better by that than by what this trial tells.",
        found,
    )


def _by_images(found: Finding) -> str:
    """How many images a camera is late or early."""
    n = _number(found, "images")
    if not math.isfinite(n):
        return "some images earlier or later"
    return f"{abs(round(n))}\u00a0{'image' if abs(round(n)) == 1 else 'images'} {'earlier' if n < 0 else 'later'}"


def _started_apart(found: Finding) -> str:
    return fill(
        f"{{Cameras}} was started {_by_images(found)} than the others. Kinemark's own tracker puts its images into "
        "the frames that they show, if more of them then fit.",
        found,
    )


def _to_state(found: Finding) -> str:
    """What to write as the delay of a camera."""
    name = found.cameras[0] if found.cameras else "camera"
    return f"delays_ms.{name} = {round(_number(found, 'state_ms'), 2):.6g} below [cameras]"


def _apart_advice(found: Finding) -> str:
    return f"Write {_to_state(found)}, and run again."


def _learned_advice(found: Finding) -> str:
    return f"Check that all cameras are triggered together; where that cannot be, write {_to_state(found)}."


def _dropped_images(found: Finding) -> str:
    n = _number(found, "dropped")
    many = "an image" if abs(n) == 1 else f"{abs(round(n))}\u00a0images" if math.isfinite(n) else "images"
    does = f"has {many} twice" if n < 0 else f"dropped {many}"
    return fill(
        f"{{Cameras}} {does} about frame {{first_frame}}: it then shows what the others show {_by_images(found)}. "
        "Kinemark's own tracker puts its images into the frames that they show, if they then fit better.",
        found,
    )


def _number(found: Finding, name: str) -> float:
    value = found.values[name]
    return value if isinstance(value, float | int) else float("nan")


def _stopped(found: Finding) -> str:
    last = found.frames[0][0] - 1 if found.frames else "–"
    return fill(f"{{Cameras}} has no images after frame {last}; the recording ends with frame {{last_frame}}.", found)


def _started_late(found: Finding) -> str:
    first = found.frames[-1][1] + 1 if found.frames else "–"
    return fill(f"{{Cameras}} has no images before frame {first}; the recording begins with {{first_frame}}.", found)


def _shifted(found: Finding) -> str:
    since = " from frame {first_frame} on" if found.frames else ""
    offset = ", ".join(shown(found.values[f"offset_{axis}_px"], "ratio", "+.1f") for axis in "uv")
    return fill(
        f"The images of {{cameras}} lie ({offset})\u00a0px beside where the other cameras expect them{since}.", found
    ) + _left_out(found)


def _put_right(found: Finding) -> str:
    offset = ", ".join(shown(found.values[f"offset_{axis}_px"], "ratio", "+.0f") for axis in "uv")
    since = " from frame {first_frame} on" if found.frames else ""
    when = "then" if found.frames else "after the calibration"
    return fill(
        f"The images of {{cameras}} lay ({offset})\u00a0px beside where the other cameras expect them{since}: it was "
        f"turned {when}. It was put right by the points of the others, and used.",
        found,
    )


def _other(found: Finding) -> str:
    first, second = (*found.cameras, "–", "–")[:2]
    return f"Camera {first} sees what camera {second} should see.{_left_out(found)}"


def _left_out(found: Finding) -> str:
    return " It was left out." if found.values["left_out"] else ""


def _fits_nothing(found: Finding) -> str:
    return fill("The images of {cameras} fit nothing that the others see.", found) + _left_out(found)


def _lenses(found: Finding) -> str:
    said = "The calibration states no lens terms, and the images do not fit without: "
    if found.values["lost"]:
        return said + fill("radial terms k1 of {k1_list:3} were learned from them, camera by camera, and used.", found)
    return said + fill(
        "they lie {sd_px} beside each other's lines. The cameras were calibrated as if they had no lens, so that "
        "learned terms (k1 of {k1_list:3}) were not used.",
        found,
    )


CAMERA_WORDS = {
    "camera_sees_nothing": Words(
        "{Cameras} saw nothing in the whole trial.",
        "Check its cable, lens cap, lights and threshold; then record again or leave it out.",
    ),
    "camera_disagrees": Words(
        _disagrees,
        "When the offset explains the residual, the camera was moved: calibrate again. Otherwise check its focus and "
        "its synchronisation.",
    ),
    "cameras_agree_poorly": Words(
        "The cameras agree poorly: half of all image points are {residual_px} or more off.",
        "Calibrate again, lens distortion included, before trusting distances.",
    ),
    "pixel_axes_differ": Words(
        _pixel_axes,
        "Write the points with pixel 0, 0 in the top left corner, u to the right and v downwards, and in the size of "
        "image that was calibrated.",
    ),
    "cameras_swapped": Words(_swapped, "Swap the files, in the trial or in the calibration."),
    "cameras_with_same_images": Words(
        _same_images,
        "Give each camera its own file, and run again.",
    ),
    "camera_out_of_sync": Words(
        _out_of_sync,
        "Check that all cameras are triggered together; where that cannot be, state delays_ms in [cameras].",
    ),
    "camera_started_apart": Words(_started_apart, _apart_advice),
    "camera_dropped_images": Words(
        _dropped_images,
        "Look at the times of its images. Put a black one where one was dropped, or take out what is there twice, and "
        "run again, to be exact.",
    ),
    "camera_late_as_calibrated": Words(_late_as_calibrated, _apart_advice),
    "camera_delay_learned": Words(_delay_learned, _learned_advice),
    "camera_rolling_shutter": Words(
        "The rows of {cameras} are taken one after the other, the last {readout_ms:1} ± {readout_se_ms:1} after the "
        "first. All was tracked with its images moved to the times of the frames.",
        "Markers at the edges of the image are measured best with a global shutter.",
    ),
    "camera_uneven_times": Words(
        "The times at which {cameras} takes its images scatter by {uneven_ms:1}, standard deviation. Its images count "
        "the less the faster their markers move, and positions in fast motion are less certain.",
        "Check that the camera keeps its rate and loses or repeats no image; trigger all cameras together.",
    ),
    "camera_without_images": Words("{Cameras} has no images at all.", LOOK_AT_CAMERA),
    "camera_stopped": Words(_stopped, "Check whether the camera stopped recording; else leave it out."),
    "camera_started_late": Words(_started_late, "Check whether the camera started late; else leave it out."),
    "camera_moved": Words(
        "The images of {cameras} fit no track in {frames}: the camera was probably moved. The others were used.",
        LOOK_AT_CAMERA,
    ),
    "camera_shifted": Words(
        _shifted,
        "The camera was probably touched after the calibration. Look at it in a second trial: calibrate again, or "
        "leave it out.",
    ),
    "camera_put_right": Words(
        _put_right,
        "Look at the camera's mount, and calibrate again before the next session.",
    ),
    "cameras_put_in_order": Words(
        _in_order,
        "Give each camera its own images, with their delays_ms, or its own calibration, before you use either "
        "elsewhere: other trials may have the same mistake.",
    ),
    "calibration_off": Words(
        "The images of {cameras} lie beside where the other cameras expect them, by {offset_px} in the median camera: "
        "the calibration fits no better.",
        "Calibrate again, lens distortion included, with the wand or the points all over the volume and the images.",
    ),
    "lens_terms_unstated": Words(
        _lenses,
        "Calibrate again with lens distortion, or state the lens terms in the calibration, where it had them.",
    ),
    "lens_terms_taken_out": Words(
        "The images are without the lens distortion that the calibration states: by it they lie {sd_px} beside each "
        "other's lines. All was tracked and solved without lens terms.",
        "Leave the lens terms out of the calibration, where the distortion was taken out of the images before; else "
        "give the calibration of these lenses.",
    ),
    "strobes_seen": Words(
        "In the images of {cameras} shine the strobes of {of_list}, where the calibration has these cameras: they were "
        "left out.",
        "There is nothing to do; where markers pass before them, turn the cameras apart, or mask them under [masks].",
    ),
    "noise_overstated": Words(
        "The centroids state a standard deviation of {stated_px}, but the images lie only {seen_px} beside each "
        "other's lines: the latter was believed.",
        "State standard deviations in px, and no variances or sizes of images; or leave the noise out.",
    ),
    "camera_takes_place_of_other": Words(_other, "Check whether the cameras are in the wrong order."),
    "camera_in_doubt": Words(
        "The images of {cameras} hardly fit those of the other cameras, and too few points are seen by three cameras "
        "to tell which of them is wrong: points that two cameras see may be no markers.",
        "Track once more without it and compare; calibrate again where its points go and others do not come.",
    ),
    "camera_fits_nothing": Words(
        _fits_nothing, "Its calibration is of another place or camera: calibrate it again, or leave it out."
    ),
}
