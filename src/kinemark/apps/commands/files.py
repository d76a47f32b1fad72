"""`kinemark info`, `convert` and `starts`: what is in files, their other formats, when cameras were started."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ...data import KinemarkError
from ...data.typed import typed
from ...engine.describe import describe, described
from ...engine.folders import check_folder, trials_in
from ...engine.formats import convert as convert_file
from ...engine.system import system as describe_system
from ...io.formats import ReadOptions
from ...io.notes import file_note_figures, file_note_text
from ..output import Json, LengthUnit, Partial, Rate, print_note, print_result


def info(
    *files: Path,
    system: Annotated[bool, Parameter(negative="")] = False,
    length_unit: LengthUnit = None,
    rate_hz: Rate = None,
    partial: Partial = False,
    json: Json = False,
) -> None:
    """Say what is in files: C3D, TDF, TRC, CSV, rig TOML, DLT, HDF5, video, images or a session.

    Args:
        files: files, sessions, or folders, for all C3D, TRC, TDF and TDC files in them.
        system: say instead what Kinemark runs on: versions, threads, and whether its compiled library is used.
    """
    if system == bool(files):
        raise KinemarkError("Say what is wanted: files, or --system.")
    if system:
        here = describe_system()
        print_result(here.figures() if json else here.text())
        return
    found: dict[str, dict[str, object]] = {}
    for one in trials_in(files, say=print_note):
        try:
            check_folder(one)
            found[str(one)] = describe(one, ReadOptions(rate_hz, length_unit, partial))
        except KinemarkError as error:  # one bad file keeps nobody from seeing the others
            found[str(one)] = {"error": str(error)}
    if json:
        print_result(found)
    else:
        for name, facts in found.items():
            print_result("\n".join([name, *(f"  {line}" for line in described(facts))]))
    if any("error" in facts for facts in found.values()):
        sys.exit(1)


def convert(
    source: Path,
    target: Path,
    *,
    what: Literal["trajectories", "detections", "rig"] | None = None,
    length_unit: LengthUnit = None,
    rate_hz: Rate = None,
    partial: Partial = False,
    up: Literal["x", "y", "z"] | None = None,
    json: Json = False,
) -> None:
    """Convert between formats: trajectories (C3D, TRC, CSV, HDF5, TDC), rigs (TOML, DLT), detections (HDF5, CSV).

    Args:
        source: the file to read.
        target: the file to write; an existing one is not replaced.
        what: which part, where the names do not tell.
        up: turn trajectories and force plates so that this axis goes up, as y for OpenSim; as in the source where none
            is given.
    """
    notes = convert_file(source, target, what=what, length_unit=length_unit, rate_hz=rate_hz, partial=partial, up=up)
    if json:
        print_result({"written": str(target), "notes": file_note_figures(notes)})
        return
    for note in notes:
        print_result(f"note: {file_note_text(note)}")
    print_result(f"{target} is written. What it holds: kinemark info {typed(target)}")


def starts(
    detections: Path,
    cameras: Path | None = None,
    *,
    flash: bool = False,
    trial: str | None = None,
    most_s: float = 10.0,
    length_unit: LengthUnit = None,
    rate_hz: Rate = None,
    json: Json = False,
) -> None:
    """When each camera of a recording was started, from its markers or a flash: what to write as delays_ms.

    Args:
        detections: a file of detections, the images of each camera numbered from its own start; with --flash a session.
        cameras: a file of the calibrated cameras, TOML; not with --flash.
        flash: look in the session's images for the one that a flash lights as a whole, in every camera.
        trial: of the session; its first with images where none is given.
        most_s: seconds that two cameras may be apart, by their markers.
    """
    from ...engine.camera_checks.start_files import starts_by_flash, starts_of_files

    if flash == (cameras is not None):
        raise KinemarkError(
            "Say by what the cameras are put together: DETECTIONS and CAMERAS, by markers, or SESSION --flash."
        )
    if flash:
        found = starts_by_flash(detections, trial, rate_hz=rate_hz)
    else:
        assert cameras is not None
        found = starts_of_files(detections, cameras, most_s=most_s, rate_hz=rate_hz, length_unit=length_unit)
    if json:
        print_result(found)
        return
    late = [f"  {name:16} {images:6d} images later than the first" for name, images in found["images"].items()]
    late += [f"  {name:16} lit by the flash in image {image}" for name, image in found.get("flash", {}).items()]
    delays = ", ".join(f"{name} = {ms:g}" for name, ms in found["delays_ms"].items())
    doubt = [f"  {' and '.join(pair)} say otherwise" for pair in found.get("disagreeing", [])]
    print_result("\n".join([*late, *doubt, "In session.toml:  [cameras]", f"  delays_ms = {{ {delays} }}"]))
