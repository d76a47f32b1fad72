"""The menu of UM²AS over a session: its entries as the thesis has them, and how far each is.

An entry is a level of the menu or a task of it. What a task needs and whether it was done is read from the files: one
that is older than what it was made of has to be made again, and so has one that depends on what the session said
otherwise then, and all that is made of those.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ...data import KinemarkError
from .files import Um2asFiles

State = Literal["", "done", "open", "again", "waits"]
Place = Literal["menu", "here", "cameras", "detect", "digitise", "angles"]
"""Where a task is done: on the menu's own screen, or on another one, which leads back."""


@dataclass(frozen=True, slots=True)
class MenuEntry:
    """An entry of the menu.

    Attributes:
        key: of it; above: key of the level that it is in, empty at the top.
        title: as the thesis says it. about: what is done there. figure: of the thesis, or the section.
        place: where it is done.
    """

    key: str
    above: str
    title: str
    about: str
    figure: str
    place: Place


@dataclass(frozen=True, slots=True)
class Standing:
    """How far an entry is: in words, and the files that it reads or writes."""

    state: State
    words: str
    files: tuple[Path, ...] = ()


MENU = (
    MenuEntry("camera", "", "Camera Information", "Calibrate the cameras, and digitise the markers.", "3.3", "menu"),
    MenuEntry("data", "", "Data Calculation", "From digitised markers to places and angles.", "3.3", "menu"),
    MenuEntry("calibration", "camera", "Calibration Parameters",
              "Eleven L parameters of each camera from control balls at measured places.", "3.4", "menu"),
    MenuEntry("digitising", "camera", "Marker Coordinate Digitizing",
              "The markers' centroids in every frame of every camera.", "3.5", "menu"),
    MenuEntry("aspect", "camera", "Aspect Ratio",
              "By a bar of markers that is turned before each camera: what V is multiplied by in all files.",
              "4.1", "here"),
    MenuEntry("xyz", "data", "X, Y, Z Coordinate Calculation",
              "Places of the markers in space, by two cameras or more.", "3.6", "menu"),
    MenuEntry("euler", "data", "Calculate Euler Angles", "Angles of shoulder, elbow and wrist.", "3.7", "menu"),
    MenuEntry("calibration-start", "calibration", "Start Up Information",
              "The date of camera 1's file, today unless it is said; black markers on white ground are chosen "
              "beside the threshold.", "3.6", "here"),
    MenuEntry("calibration-files", "calibration", "Input & Output Data Files",
              "Measured places of the balls are read, L parameters written.", "3.7", "here"),
    MenuEntry("calibration-threshold", "calibration", "Image Threshold",
              "White pixels are shown on the image while it is moved.", "3.8", "cameras"),
    MenuEntry("calibration-snap", "calibration", "Snap Image",
              "The image of the balls, black and white.", "3.4", "cameras"),
    MenuEntry("calibration-reference", "calibration", "Reference Marker",
              "Asked for after the last ball of each camera: clicked, or of a file.", "3.9", "cameras"),
    MenuEntry("calibration-digitise", "calibration", "Digitize Image",
              "Click any white pixel of each ball, in their order.", "3.10", "cameras"),
    MenuEntry("calibration-process", "calibration", "Process L Parameters",
              "Writes the files of all cameras.", "3.4", "here"),
    MenuEntry("calibration-view", "calibration", "View L Parameters", "What is in the files.", "3.5", "here"),
    MenuEntry("digitising-start", "digitising", "Start Up Information",
              "Markers, which of them is the reference, last frame, frames skipped, date.", "3.13", "digitise"),
    MenuEntry("digitising-output", "digitising", "Output File",
              "What the digitised markers are written to.", "3.12", "here"),
    MenuEntry("digitising-reference", "digitising", "Reference Marker",
              "In the start-up: by files, or the first frame says it.", "3.9", "digitise"),
    MenuEntry("digitising-threshold", "digitising", "Image Threshold",
              "Tried on any frame, white pixels shown, then applied to all.", "3.8", "detect"),
    MenuEntry("digitising-snap", "digitising", "Snap Image", "Any frame of any camera.", "3.5", "digitise"),
    MenuEntry("digitising-digitise", "digitising", "Digitize Image",
              "Two frames by hand, then the program asks for what it does not find.", "3.14", "digitise"),
    MenuEntry("digitising-verify", "digitising", "Verify Digitization",
              "Marker by marker, yes or no, before a frame is saved: V.", "3.15", "digitise"),
    MenuEntry("digitising-save", "digitising", "Save Data",
              "Frames are kept when they are saved; this writes the files of all cameras.", "3.5", "here"),
    MenuEntry("digitising-view", "digitising", "View Data", "What is in the files, frame by frame.", "3.12", "here"),
    MenuEntry("xyz-start", "xyz", "Start Up Information",
              "Which cameras are used: two, three or all.", "3.16", "here"),
    MenuEntry("xyz-calibration", "xyz", "Calibration Input Files", "One a camera.", "3.19", "here"),
    MenuEntry("xyz-data", "xyz", "Marker Data Files", "One a camera.", "3.19", "here"),
    MenuEntry("xyz-output", "xyz", "Output File", "What the places are written to.", "3.17", "here"),
    MenuEntry("xyz-process", "xyz", "Process Coordinates",
              "Every pair of cameras gives a place; the mean of those that agree counts.", "3.16", "here"),
    MenuEntry("xyz-display", "xyz", "Display Coordinates",
              "One frame at a time: the space bar goes on, Backspace back.", "3.6", "here"),
    MenuEntry("euler-input", "euler", "Input File", "Places, by all cameras or some.", "3.20", "here"),
    MenuEntry("euler-output", "euler", "Output Files", "Of shoulder, elbow and wrist.", "3.21", "here"),
    MenuEntry("euler-process", "euler", "Process", "Angles about z, x' and y''.", "3.20", "here"),
    MenuEntry("euler-view", "euler", "View Angles", "What is in the files, frame by frame.", "3.21", "here"),
    MenuEntry("euler-curves", "euler", "Curves",
              "Curves, smoothing and the limb from any side, of the trial as it was run.",
              "5, recommendation 3", "angles"),
)  # fmt: skip
"""By definition: chapter 3 of the thesis. Figures are its own; `Aspect Ratio` as an entry, `View
Angles` and `Curves` are ours."""


def standings(
    files: Um2asFiles, *, saved: dict[str, tuple[int, int]] | None, cameras: Sequence[str], tdc: Path
) -> dict[str, Standing]:
    """How far each task is, by its key.

    Args:
        files: of the session and the trial.
        saved: frames saved and to be saved of each camera; None where nobody digitises the trial by hand yet.
        cameras: that are chosen for the coordinates; all where empty.
        tdc: the file that angles are taken of.
    """
    place = files.tdc(cameras)
    made = written(tuple(files.cps()), tuple(balls_of(files)), why=files.parameters_changed())
    digitised = saved is not None and all(n == of for n, of in saved.values())
    answers = tuple(answers_of(files)) if digitised else ()
    marked = written(tuple(files.das()), answers, why=files.markers_changed())
    sources = (*files.cps(cameras), *files.das(cameras))
    placed = written((place,), sources, why=_again(made, marked))
    before = _again(made, marked, *([placed] if tdc == place else []))
    turned = written(tuple(files.angle_files(tdc)), (tdc,), why=before)
    factor = files.session.settings.cameras.aspect_ratio
    return {
        "aspect": Standing("", "Pixels count as square." if factor is None else f"V × {factor:g} in all files."),
        **_of_calibration(files, made),
        **_of_digitising(files, saved, marked),
        **_of_coordinates(files, cameras, placed),
        **_of_angles(files, tdc, turned),
    }


def _of_calibration(files: Um2asFiles, made: Standing) -> dict[str, Standing]:
    """Of the tasks of L Parameters; made: the standing of their files."""
    balls, reference = _balls(files)
    return {
        "calibration-start": Standing("", ""),
        "calibration-files": Standing("", "", (*([files.measured] if files.measured else []), *files.cps())),
        "calibration-threshold": _threshold(files),
        "calibration-snap": Standing("", ""),
        "calibration-reference": reference,
        "calibration-digitise": balls,
        "calibration-process": _after(balls, made),
        "calibration-view": _seen(made),
    }


def _of_digitising(
    files: Um2asFiles, saved: dict[str, tuple[int, int]] | None, marked: Standing
) -> dict[str, Standing]:
    """Of the tasks of digitising; saved: as `standings` takes it; marked: the standing of their files."""
    return {
        "digitising-start": Standing("open" if saved is None else "done", "" if saved else "Name the markers."),
        "digitising-output": Standing("", "", tuple(files.das())),
        "digitising-reference": _marks(files),
        "digitising-threshold": _threshold(files),
        "digitising-snap": Standing("", ""),
        "digitising-digitise": _frames(saved),
        "digitising-verify": Standing("", ""),
        "digitising-save": _after(_frames(saved), marked),
        "digitising-view": _seen(marked),
    }


def _of_coordinates(files: Um2asFiles, cameras: Sequence[str], placed: Standing) -> dict[str, Standing]:
    """Of the tasks of 3D coordinates; placed: the standing of their file."""
    chosen, place = cameras or files.cameras, (files.tdc(cameras),)
    return {
        "xyz-start": Standing("done", f"{len(chosen)} of {len(files.cameras)} cameras: {', '.join(chosen)}."),
        "xyz-calibration": _there(tuple(files.cps(cameras)), "Process L Parameters first."),
        "xyz-data": _there(tuple(files.das(cameras)), "Save Data of Marker Coordinate Digitizing first."),
        "xyz-output": Standing("", "", place),
        "xyz-process": placed,
        "xyz-display": _there(place, "Process Coordinates first."),
    }


def _of_angles(files: Um2asFiles, tdc: Path, turned: Standing) -> dict[str, Standing]:
    """Of the tasks of joint angles; turned: the standing of their files."""
    angles = tuple(files.angle_files(tdc))
    return {
        "euler-input": _there((tdc,), "Process Coordinates first."),
        "euler-output": Standing("", "", angles),
        "euler-process": turned,
        "euler-view": _there(angles, "Process first."),
        "euler-curves": Standing("", ""),
    }


def level_standing(key: str, of: dict[str, Standing]) -> Standing:
    """A level's, from those of its tasks: done where the last one that writes files is."""
    below = [entry.key for entry in MENU if entry.above == key]
    states = [(of[one] if one in of else level_standing(one, of)).state for one in below]
    counted = [state for state in states if state]
    n = sum(state == "done" for state in counted)
    found: State = "done" if n == len(counted) else "again" if "again" in counted else "open" if n else "waits"
    found = "open" if found == "waits" and "open" in counted else found
    return Standing(found, f"{n} of {len(counted)} done")


def written(files: tuple[Path, ...], sources: tuple[Path, ...], *, why: str = "") -> Standing:
    """Whether files were written, after what they are made of; `why` they have to be again besides."""
    if not all(path.is_file() for path in files):
        there = all(path.is_file() for path in sources)
        return Standing("open" if there else "waits", "Not written yet.", files)
    oldest = min(path.stat().st_mtime_ns for path in files)
    newer = [path.name for path in sources if path.is_file() and path.stat().st_mtime_ns > oldest]
    if newer:
        return Standing("again", f"{newer[0]} was changed since: do it again.", files)
    if why:
        return Standing("again", why, files)
    return Standing(
        "done", f"{', '.join(path.name for path in files)} {'is' if len(files) == 1 else 'are'} written.", files
    )


def _again(*before: Standing) -> str:
    """Why what is made of these has to be made again, in words; empty where it need not."""
    found = [one.files[0].name for one in before if one.state == "again"]
    return f"{found[0]} is to be made again, and then this." if found else ""


def balls_of(files: Um2asFiles) -> list[Path]:
    """The file of balls that were pointed at, where the session has one."""
    try:
        return [files.balls.file]
    except KinemarkError:
        return []


def answers_of(files: Um2asFiles) -> list[Path]:
    """The files of answers of the trial."""
    pattern = files.session.trial(files.trial).entry.answers
    if pattern is None:
        return []
    return [files.session.root / pattern.replace("{camera}", name) for name in files.cameras]


def _balls(files: Um2asFiles) -> tuple[Standing, Standing]:
    """How far the balls are, and the reference marker."""
    calibration = files.session.settings.calibration
    marks = calibration.reference_marker or {}
    marked = Standing("done", f"Known in {', '.join(marks)}.") if marks else Standing("", "It may be left out.")
    try:
        points = files.balls.points
    except KinemarkError:
        return Standing("done", "Not needed: this session is calibrated another way."), marked
    asked, n = int(points.asked.sum()), points.asked.size
    if asked == n:
        absent = int(np.isnan(points.uv[..., 0]).sum())
        return Standing("done", f"All {n} are said{f', {absent} not seen' if absent else ''}."), marked
    each = ", ".join(
        f"{name} {int(own.sum())} of {len(own)}" for name, own in zip(points.cameras, points.asked, strict=True)
    )
    return Standing("open", f"Balls said: {each}."), marked


def _threshold(files: Um2asFiles) -> Standing:
    """What is white; every image says it itself where nobody did."""
    method = files.session.settings.detect
    ground = ", black on white" if getattr(method, "inverted", False) else ""
    level = getattr(method, "threshold", None)
    return Standing(
        "", f"White above {level:g}{ground}." if level is not None else f"Of each image's own grey{ground}."
    )


def _marks(files: Um2asFiles) -> Standing:
    method = files.session.settings.digitise
    if method is None or method.reference is None:
        return Standing("", "None is chosen.")
    known = files.session.settings.calibration.reference_marker
    words = "its place at the calibration counts" if known else "the first frame says where it is"
    return Standing("done", f"{method.reference}; {words}.")


def _frames(saved: dict[str, tuple[int, int]] | None) -> Standing:
    if saved is None:
        return Standing("waits", "Start Up Information first.")
    each = ", ".join(f"{name} {n} of {of}" for name, (n, of) in saved.items())
    done = all(n == of for n, of in saved.values())
    return Standing("done" if done else "open", f"Frames saved: {each}.")


def _after(before: Standing, own: Standing) -> Standing:
    """A task that waits for another."""
    if before.state == "done" or own.state == "done":
        return own
    return Standing("waits", before.words, own.files)


def _seen(own: Standing) -> Standing:
    """What can be looked at."""
    there = all(path.is_file() for path in own.files)
    return Standing("done" if there else "waits", "" if there else "Not written yet.", own.files)


def _there(files: tuple[Path, ...], otherwise: str) -> Standing:
    missing = [path.name for path in files if not path.is_file()]
    if missing:
        return Standing(
            "waits", f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not there. {otherwise}", files
        )
    return Standing("done", ", ".join(path.name for path in files), files)
