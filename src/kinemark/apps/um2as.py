"""The upper limb system of the University of Manitoba: digitise by hand and by machine, calibrate, calculate.

Camera information: snap, reference, calibrate, digitise. Data calculation: coordinates, angles. To look: view.
Files end in the number of their camera: box.cp1, box.rf1 and feeding.da1 are of camera 1.
"""

from __future__ import annotations

import sys
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import App, Parameter

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.errors import users_mistake
from ..data.typed import typed
from .terminal import Terminal, pointed, say
from .um2as_options import CameraOptions, ImageOptions, Many, OtherCameras, ReferenceOptions

if TYPE_CHECKING:  # these take long to import, and --help does without
    from ..digitise import DigitisedImages, SemiAutomatic


um2as = App(name="um2as", help=__doc__)  # the menu of figures 3.3 to 3.20

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print the figures for a machine.")]
WHITE = 253  # grey level of 8 bits of a marker in the picture; chosen


@um2as.command
def snap(
    images: Path,
    output: Path | None = None,
    *,
    frame: int = 1,
    look: Annotated[ImageOptions | None, Parameter(name="*")] = None,
) -> None:
    """Snap Image, Image Threshold: turn a frame into black and white, and list its markers.

    Choose the threshold so that all markers are white and nothing else is.

    Args:
        images: the camera's video, or its images as 'cam1/%04d.png'.
        output: a PNG file for the black and white image.
        frame: which one, counted from 1.
        look: how markers are found.
    """
    from ..io.images import write_png

    found = (look or ImageOptions()).markers(images, frame)
    if output is not None:
        write_png(output, np.where(found.owner >= 0, WHITE, 0).astype(np.uint8))
    rows = [f"{k + 1:4d} {u:12.7f} {v:12.7f}" for k, (u, v) in enumerate(found.uv)]
    say("\n".join([f"{len(found.uv)} markers in frame {frame}:", "   n            U            V", *rows]))


@um2as.command
def reference(
    image: Path,
    output: Path,
    *,
    at: str | None = None,
    frame: int = 1,
    look: Annotated[CameraOptions | None, Parameter(name="*")] = None,
) -> None:
    """Reference Marker: digitise the marker that never moves, and keep its place.

    Its shift shows by how much an image lies otherwise than when the camera was calibrated.

    Args:
        image: of the calibration.
        output: the file, as box.rf1 for camera 1.
        at: any white pixel of the marker, as '115 443'; asked for where it is not given.
        frame: which one, counted from 1.
        look: how markers are found.
    """
    from ..io.um2as import camera_number, write_rf

    look = look or CameraOptions()
    camera_number(output, "rf")
    uv = pointed(look.markers(image, frame), "the reference marker", at)
    uv = uv * look.square()
    write_rf(output, uv)
    say(f"{output} is written: {uv[0]:.7f} {uv[1]:.7f}")


@um2as.command
def calibrate(
    measured: Path,
    image: Path,
    output: Path,
    *,
    at: Annotated[list[str] | None, Many] = None,
    made: str | None = None,
    frame: int = 1,
    look: Annotated[CameraOptions | None, Parameter(name="*")] = None,
) -> None:
    """Calibration Parameters: point at the control balls, and get the eleven parameters of the camera.

    The balls are digitised in ascending order, ball 1 first, as they stand in the file of measured places. Repeat it
    for every camera.

    Args:
        measured: the file of measured places, as box.msr, X Y Z of a ball in cm on each line.
        image: of the control balls, taken by this camera.
        output: the file for the parameters, as box.cp1 for camera 1.
        at: any white pixel of each ball, as '312 204' '118 96' …; asked for where they are not given.
        made: the date for camera 1's file, as 1992-11-27; today without it.
        frame: which one, counted from 1.
        look: how markers are found.
    """
    from ..engine.um2as.flow import calibrate_file, table
    from ..io.um2as import camera_number

    look = look or CameraOptions()
    camera = camera_number(output, "cp")
    found = look.markers(image, frame)
    n = len(at) if at else len(table(measured)[1])
    uv = np.array([pointed(found, f"control ball {i + 1}", at[i] if at else None) for i in range(n)]).reshape(-1, 2)
    _, residual = calibrate_file(measured, output, uv * look.square(), made=_date(made) if camera == 1 else None)
    rms = float(np.sqrt((residual**2).sum(1).mean()))
    say(
        f"{output} is written. The balls are {rms:.2f} px off on average (RMS), at most "
        f"{np.hypot(*residual.T).max():.2f}."
    )


@um2as.command(name="digitise")
def digitise_file(
    images: Path,
    output: Path,
    *,
    markers: Annotated[list[str], Many],
    anchor: Annotated[ReferenceOptions | None, Parameter(name="*")] = None,
    last_frame: int | None = None,
    every: int = 1,
    look: Annotated[CameraOptions | None, Parameter(name="*")] = None,
    answers: Path | None = None,
    save_all: Annotated[bool, Parameter(negative="")] = False,
    proposing: Annotated[OtherCameras | None, Parameter(name="*")] = None,
    history: int = 2,
    json: Json = False,
) -> None:
    """Motion Data Acquisition: digitise the markers of one camera, frame by frame.

    You point at every marker in the first two frames; then the program follows them, and asks for those that it does
    not find. Answer with any white pixel of the marker, as '312 204', or with - if it is not present; y takes what
    other cameras propose.

    When all markers of a frame are settled: save keeps the frame and goes on (nothing is kept before); verify goes
    through it marker by marker, and a wrong one is put where you say; hand digitises the whole frame anew. At any time:
    frame 12 goes back to a saved frame, undo takes the last answer back, and quit stops; the same command goes on from
    there.

    Args:
        images: the camera's video, or its images as 'cam1/%04d.png'.
        output: the file for the saved frames, as feeding.da1 for camera 1.
        markers: how many there are in a frame, the reference marker included; or their names in order.
        anchor: the reference marker.
        last_frame: the last frame to be processed, counted among those that are taken.
        every: number of frames skipped: 1 takes every frame, 2 every other one.
        look: how markers are found.
        answers: the file in which your answers are kept; beside the output without it.
        save_all: save frames of which all markers are settled without asking.
        proposing: what other cameras know.
        history: frames for which a hidden marker is remembered; 2 as in UM²AS, where it must be seen in both before.
    """
    from ..engine.digitising.files import DigitisedFrames, digitise_camera
    from ..io.images import open_images
    from ..io.um2as import camera_number, write_da

    anchor, look, proposing = anchor or ReferenceOptions(), look or CameraOptions(), proposing or OtherCameras()
    method = _semi_automatic(
        markers, anchor.reference, confirm_reference=anchor.confirm_reference,
        take_proposals=proposing.take_proposals, history=history,
    )  # fmt: skip
    square, camera = look.square(), camera_number(output, "da")
    reel = DigitisedFrames(open_images(images, every=every), method=look.centroids(), last=last_frame)
    place = anchor.place()
    done = digitise_camera(
        reel,
        method=method,
        answers=answers or output.with_name(output.name + ".csv"),
        operator=Terminal(reel),
        refuse=lambda error: say(f"  {error}"),
        save_all=save_all,
        constant=None if place is None else place / square,
        views=proposing.views(camera, len(method.markers), square),
    )
    write_da(output, done.uv * square)
    say(done.figures if json else _said(output, done, reel.n_frames))


@um2as.command
def coordinates(
    output: Path,
    *,
    calibration: Annotated[list[Path], Many],
    data: Annotated[list[Path], Many],
    markers: int | None = None,
) -> None:
    """X, Y and Z Coordinate Calculation: from two, three or more cameras to places in space.

    Every pair of cameras that sees a marker gives a place. With three, a place that is twice as far from the others as
    they are from each other is left out, and the mean of the rest counts. A marker that fewer than two cameras see
    gets 999 999 999.

    Args:
        output: the file for the places in cm, as feeding.tdc.
        calibration: the parameters of the cameras, as box.cp1 box.cp2 box.cp3.
        data: what was digitised of the same cameras, as feeding.da1 feeding.da2 feeding.da3.
        markers: how many in a frame; only where camera 1's file, which says it, is not among the data.
    """
    from ..engine.um2as.flow import coordinates_files

    found = coordinates_files(calibration, data, output, markers=markers)
    gone = int(np.isnan(found.xyz[..., 0]).sum())
    say(f"{output} is written: {found.n_frames} frames of {len(found)} markers, {gone} places not known (999).")


@um2as.command
def angles(coordinates: Path, *outputs: Path, inverse_cosines: Annotated[bool, Parameter(negative="")] = False) -> None:
    """Calculate Euler Angles: of shoulder, elbow and wrist, from the places of markers 1 to 7.

    Args:
        coordinates: the file of places, as feeding.tdc.
        outputs: the files for shoulder, elbow and wrist, as feeding.shd feeding.elb feeding.wst; beside it else.
        inverse_cosines: as UM²AS calculates them, without the sign of the first and third angle.
    """
    from ..engine.um2as.flow import angles_files

    found = angles_files(coordinates, outputs, signed=not inverse_cosines)
    low, high = np.nanmin(found.deg, 1), np.nanmax(found.deg, 1)
    rows = [f"{joint}: {_range(low[j], high[j])}" for j, joint in enumerate(found.joints)]
    say("\n".join(["Angles about z, x', y'', deg, from … to:", *rows]))


@um2as.command
def view(file: Path, *, frame: int | None = None, markers: int | None = None) -> None:
    """View L Parameters, View Data, Display Coordinates: show what is in a file of UM²AS.

    Args:
        file: any of them.
        frame: only this frame, counted from 1.
        markers: how many in a frame; for the data of a camera other than the first, whose file does not say it.
    """
    from ..engine.um2as.flow import table

    heading, rows = table(file, markers=markers)
    shown = [row for row in rows if frame is None or row[0] == frame]
    if not shown:
        raise KinemarkError(f"{file} has no frame {frame}, but 1 to {rows[-1][0]}. Name another.")
    say("\n".join([heading, *("\t".join(map(_cell, row)) for row in shown)]))


def digitise(session: Path, trial: str, *, camera: str | None = None, json: Json = False) -> None:
    """Digitise a session's trial, camera by camera: point at markers, answer what the program asks.

    Answers are kept in the files that the trial names; kinemark run then does the rest. What can be answered is told
    by: kinemark um2as digitise --help

    Args:
        session: a folder with a session.toml, or such a file.
        trial: its name.
        camera: stop after this one; all without it.
    """
    from ..engine.digitising.files import digitise_trial
    from ..engine.session import Session

    opened = Session.open(session)
    task = opened.digitising(trial, opened.calibrate().rig)
    if camera is not None and camera not in task.images:
        raise KinemarkError(f"There is no camera {camera!r}; the session has {', '.join(task.images)}.")
    _, figures = digitise_trial(
        task,
        operator=Terminal,
        refuse=lambda error: say(f"  {error}"),
        announce=lambda name: say(f"camera {name}", file=sys.stderr),
        stop_after=camera,
    )
    command = f"kinemark run {typed(session)} {typed(trial)}"
    say(figures if json else f"{figures['questions']} questions were asked. Next: {command}")


def _semi_automatic(markers: list[str], reference: str | None, **options: Any) -> SemiAutomatic:
    """How markers are followed; one that is a number says how many there are."""
    from ..digitise import SemiAutomatic

    names = [str(m + 1) for m in range(int(markers[0]))] if len(markers) == 1 and markers[0].isdecimal() else markers
    with users_mistake():
        return SemiAutomatic(tuple(names), reference, **options)


def _date(text: str | None) -> date:
    try:
        return date.fromisoformat(text) if text else date.today()
    except ValueError:
        raise KinemarkError(f"{text!r} is no date. Say it as 1992-11-27.") from None


def _said(output: Path, done: DigitisedImages, n_frames: int) -> str:
    """What came of digitising, in words."""
    f = done.figures
    why = ", ".join(f"{n} {reason.replace('_', ' ')}" for reason, n in f["questions_by_reason"].items() if n)
    rest = f" {n_frames - f['frames']} frames are still to be digitised." if f["frames"] < n_frames else ""
    return (
        f"{output} is written: {f['frames']} frames of {f['markers']} markers, {f['not_present']} not present.{rest}\n"
        f"{f['questions']} questions were asked{f' ({why})' if why else ''}, {f['corrected']} places corrected."
    )


def _range(low: Floats, high: Floats) -> str:
    return ", ".join(f"{a:.2f} … {b:.2f}" for a, b in zip(low, high, strict=True))


def _cell(value: float | int) -> str:
    return str(value) if isinstance(value, int) else "999" if value != value else f"{value:.7f}"
