"""What was guessed for a first `session.toml`, why, and what is asked, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

HEAD = (
    "A first session.toml, made by kinemark init. What was guessed says why; correct what is wrong.",
    "Lines that begin with # ? want a value: write it, and remove the mark. All keys: docs/session.md",
)

REASONS = {
    "no_cameras": "no file says which camera is which; {{camera}} in a pattern becomes each name",
    "no_rate": "no file says it",
    "no_images": "there are no moving images to see it in",
    "by_word": "the word for a camera in the names of files",
    "by_number": "the number after the word for a camera, as the words differ",
    "by_side": "the sides that the names say",
    "by_stem": "the names of files that are otherwise alike",
    "by_folder": "the folders that hold files of the same name",
    "by_run": "the part in which names of otherwise equal files differ",
    "of_file": "as {path} names them",
    "of_recording": "as {path} says",
    "of_fields": "twice the {rate_hz:g} images a second of {path}",
    "named": "its name says {word}",
    "no_word": "no word in its name says that it is anything else",
    "stated": "you said so",
    "digitised": "UM²AS's digitised centroids, a file a camera",
    "holds_rods": "it describes hanging rods",
    "holds_rig": "it holds a calibration",
    "holds_rig_without_unit": "it holds a calibration, as anipose, caliscope and Pose2Sim write it",
    "holds_dlt": "it holds DLT parameters of {cameras} cameras",
    "holds_points": "it holds control points and their places in the images",
    "holds_places": "it holds the measured places of control points, whose images are still to be pointed at",
    "still_of_points": "it is one image a camera, and is called as {path} is",
    "holds_measured": "it holds {n} measured places of control balls, whose images are still to be pointed at",
    "holds_trajectories": "trajectories need no session: kinemark info, fill and angles take them",
    "named_and_moving": "its points have names of markers, by which those of the trials are named; it is taken for the "
    "same subject with the same markers",
    "named_and_still": "its points have names of markers, and hardly move; it is taken for the same subject with the "
    "same markers",
    "holds_template": "it is a template of {markers} markers that was kept",
    "few_names": "it has {names} named markers among {points} points, without computed ones; wanted are four",
    "several_subjects": "it is of several subjects, each of whom wants [label.subjects]; see docs/session.md",
    "other_markers": "it shares {shared} of its {markers} markers with {path}, so that it is of another marker set",
    "other_subject": "{percent} % of the distances on segments differ from {path}: it looks like another subject",
    "which_subject": "{path} and {other} look like two subjects; say which of them is recorded here",
    "another_static": "{path} stands still as well and shows more, and nothing tells whether both are one subject",
    "unreadable": "{error}",
    "no_camera_in_name": "nothing in its name says which camera took it",
    "lacks_cameras": "{role} of {has} alone, without {cameras}",
    "damaged": "{path} cannot be opened: copy it again",
    "another_rate": "{path} says {rate_hz:g} Hz, another rate than that above",
    "nothing_moved": "too little moved in {path}, or markers are too small, to see fields",
    "whole_frames": "what moves in {path} shows whole frames",
    "fields": "what moves in {path} shows two fields in an image",
    "markers_dark": "markers are darker than their ground in {path}",
    "calibrated_another_day": "the name of {path} says another day, {day}: check that no camera was moved since",
    "also_calibrates": "{path} could calibrate as well, by {role}",
    "no_calibration": "no recording calibrates the cameras",
    "no_target_file": "{path} may show a target, and no file says where its markers are: rods.toml or points.csv",
    "no_trials": "no recording is a trial; [[trials]] wants one",
}
"""By the kind of a reason."""

QUESTIONS = {
    "rate_hz": "How many frames a second (fields, if interlaced), Hz?",
    "cameras.size_px": "Width and height of the cameras' images, px, as 1280 1024?",
    "calibration.way": "What moves in {about}: a wand, or a single_marker?",
    "calibration.length_unit": "The unit of length of {about}: mm, cm, m or in?",
    "calibration.wand.lengths_mm": "Gaps between neighbouring markers of the wand, centre to centre, mm, as 120 280?",
    "calibration.wand.marker_diameter_mm": "Diameter of the wand's spheres, mm? Without it they are taken as points.",
    "calibration.control_points.marker_diameter_mm": "Diameter of the control balls, mm? Without it they are points.",
    "calibration.l_frame.arms_mm": "From the L-frame's corner to the marker on its long and short arm, mm, as 400 250?",
    "calibration.l_frame.height_mm": "Height of its markers' centres above the floor, mm? Without it they lie on it.",
    "calibration.linearisation.grid": "Columns and rows of the grid, of dots or inner corners, as 20 15?",
    "calibration.linearisation.pitch_mm": "Distance of neighbours in the grid, mm?",
}
"""By the key of a question."""


ROLES = {
    "trial": "trial",
    "static": "static trial",
    "wand": "wand",
    "l_frame": "L-frame on the floor",
    "control_frame": "control frame of rods",
    "control_points": "control balls",
    "single_marker": "single marker, moved",
    "linearisation": "lens grid",
    "empty": "empty room",
    "calibration": "some calibration",
    "file": "ready-made calibration",
    "template": "labelled trial that names the markers",
    "static_template": "labelled static trial that names them",
    "unused": "not used",
}
"""By what a recording may be for."""


class HasKind(Protocol):
    """A reason: its kind and values."""

    @property
    def kind(self) -> str:
        """Which words it has."""
        ...

    @property
    def values(self) -> Any:
        """What stands in them."""
        ...


class Asked(Protocol):
    """A question: its key, and what it is about."""

    @property
    def key(self) -> str:
        """Where the answer goes."""
        ...

    @property
    def about(self) -> str:
        """The recording."""
        ...


def reason_text(reason: HasKind) -> str:
    """A reason in words, in one line."""
    values = {name: _plain(value) for name, value in dict(reason.values).items()}
    return " ".join(REASONS[reason.kind].format_map(values).split())


def question_text(question: Asked) -> str:
    """What is asked."""
    return QUESTIONS[question.key].format(about=question.about)


def _plain(value: Any) -> Any:
    """Lists as words; anything else as it is."""
    return ", ".join(map(str, value)) if isinstance(value, Sequence) and not isinstance(value, str) else value
