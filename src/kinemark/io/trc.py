"""TRC, the tab-separated marker file of Motion Analysis and OpenSim.

line 1  PathFileType  4  (X/Y/Z)  name
line 2  names of the values in line 3: DataRate, CameraRate, NumFrames, NumMarkers, Units, …
line 4  Frame#  Time  NAME  ·  ·  NAME  ·  ·  …
line 5  ·  ·  X1  Y1  Z1  X2  …
then, mostly after an empty line, a row a frame; an empty cell or (0, 0, 0) is a gap

`trc_table` reads what other programs make of this.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..data import KinemarkError, Trajectories, Trial
from ..data import MarkerTrajectory as MarkerPath
from .c3d.points import distinct
from .cut_off import AGAIN
from .files import replacing
from .number_text import bad_line, first_frame, plain, read_text, row_text, wanted_number
from .trc_table import HEADINGS, ORIGINAL, TrcTable, parse_trc
from .units import USUAL_UNITS, mm_per

SMALL = 20.0
"""Extent of all markers, in the unit of a file that does not say it, below which it is m and not mm; chosen."""
SAME_RATE = 0.05
"""Share by which the rate of the heading and that of the times may differ without a note; chosen, times are rounded."""
NOWHERE = 9_999_999.0
"""What stands in all three cells of a marker that is missing, in the file's unit; conventional (Motion Analysis)."""
TAB = "\t"
OFF_ORIGIN = 1e-6
"""mm from (0, 0, 0) at which a sample at the very origin is written, because zeros say missing; chosen."""


def read_trc(
    path: Path | str, *, length_unit: str | None = None, rate_hz: float | None = None, partial: bool = False
) -> Trajectories:
    """Markers of a TRC file in mm, on the axes of the file; empty, NaN, (0, 0, 0) and 9999999 are missing.

    Args:
        path: the file.
        length_unit: "mm", "cm", "m" or "in", where the file is silent or wrong about it.
        rate_hz: frames a second, where the file is silent or wrong about it.
        partial: read what there is of a file that holds less than its heading says, or is cut off within a row.

    Raises:
        KinemarkError: the file is absent, empty, no TRC, in an unknown unit, or shorter than its heading says.
    """
    return read_trc_trial(path, length_unit=length_unit, rate_hz=rate_hz, partial=partial).trajectories


def read_trc_trial(
    path: Path | str, *, length_unit: str | None = None, rate_hz: float | None = None, partial: bool = False
) -> Trial:
    """As `read_trc`, with what was odd in the file as the notes of the trial."""
    found = parse_trc(path, read_text(path), partial=partial)
    places = found.table[:, 2:].reshape(len(found.table), len(found.names), 3)
    places[(places == NOWHERE).all(2)] = np.nan
    complete = _complete(path, found, partial)
    mm, unit = _unit(path, found, length_unit)
    rate, timing = _rate(path, found, rate_hz)
    first, step = first_frame(path, found.lines, found.table[:, 0])
    xyz = found.table[:, 2:].reshape(len(found.table), len(found.names), 3).transpose(1, 0, 2) * mm
    xyz[(xyz == 0).all(2)] = np.nan
    names = distinct(found.names, len(found.names), "*")
    paths = tuple(MarkerPath.measured(name, x) for name, x in zip(names, xyz, strict=True))
    notes = (*found.notes, *complete, *unit, *timing, *step)
    return Trial(Path(path).stem, Trajectories(paths, rate, first), notes=notes)


def _complete(path: Path | str, found: TrcTable, partial: bool) -> tuple[str, ...]:
    """What the heading says of frames and markers other than the table has.

    Raises:
        KinemarkError: the heading promises more than there is, and `partial` is false.
    """
    notes = []
    for name, what, have in (("nummarkers", "markers", len(found.names)), ("numframes", "frames", len(found.table))):
        stated = _number(path, found, name)
        if math.isnan(stated) or stated == have:
            continue
        if stated > have and not partial:
            if what == "markers":
                raise bad_line(path, found.naming, f"has {have} markers, line {found.heading} says {stated:g}. {AGAIN}")
            raise KinemarkError(f"{path} has {have} frames, its header says {stated:g}. {AGAIN}")
        notes.append(f"the heading says {stated:g} {what}, the table has {have}; all of the table is read")
    return tuple(notes)


def _unit(path: Path | str, found: TrcTable, stated: str | None) -> tuple[float, tuple[str, ...]]:
    """mm in the unit of the file."""
    text = stated or found.values.get("units", "")
    if text:
        if (mm := mm_per(text)) is None:
            raise bad_line(
                path, found.heading, f"Units is {text!r}, wanted {USUAL_UNITS}. State it with --length-unit."
            )
        return mm, ()
    places = found.table[:, 2:]
    extent = float(np.nanmax(places) - np.nanmin(places)) if np.isfinite(places).any() else math.inf
    guess = "m" if extent < SMALL else "mm"
    note = f"no unit is stated; {guess} is taken, as the markers extend over {extent:.4g}. Else state it: --length-unit"
    return mm_per(guess) or 1.0, (note,)


def _rate(path: Path | str, found: TrcTable, said: float | None) -> tuple[float, tuple[str, ...]]:
    """Frames a second."""
    step = np.diff(found.table[:, 1])
    usual = float(np.sort(step)[step.size // 2]) if step.size and np.isfinite(step).all() else 0.0
    timed = 1 / usual if usual > 0 else math.nan
    if said is not None:
        return said, ()
    stated = _number(path, found, "datarate")
    if stated == 0 and not math.isnan(timed):
        stated = math.nan  # nobody filled it in
    if stated <= 0 or math.isinf(stated):
        raise bad_line(path, found.heading, f"DataRate is {stated}, wanted a positive number. State it with --rate-hz.")
    if stated > 0:
        odd = abs(timed - stated) > SAME_RATE * stated
        return stated, ((f"DataRate is {stated:g} Hz, the times go at {timed:g} Hz; DataRate counts",) if odd else ())
    if math.isnan(timed):
        raise bad_line(path, found.heading, "does not say DataRate, nor do the times. State it with --rate-hz.")
    rate = float(round(timed)) if abs(timed - round(timed)) < SAME_RATE else timed
    return rate, (f"no DataRate is stated; the times go at {rate:g} Hz",)


def _number(path: Path | str, found: TrcTable, name: str) -> float:
    """A value of the heading; NaN where it is absent."""
    text = found.values.get(name, "")
    try:
        return wanted_number(text.replace(",", ".")) if text else math.nan
    except ValueError as error:
        raise bad_line(path, found.heading, f"{name} is {text!r}, wanted a number. Correct that line.") from error


def write_trc(path: Path | str, trajectories: Trajectories) -> None:
    """Write markers in mm, every digit kept, a sample at the very origin 10⁻⁶ mm off it.

    Covariance, residual and origin have no place in a TRC file.

    Raises:
        ValueError: a marker's name is empty or has a tab or line break.
        KinemarkError: the file cannot be written.
    """
    path = Path(path)
    names = trajectories.names
    if bad := [name for name in names if not name.strip() or len(f"{name}.".splitlines()) > 1 or "\t" in name]:
        raise ValueError(f"marker names must be without tabs and line breaks and not empty, found {bad}")
    n, rate, first = trajectories.n_frames, plain(trajectories.rate), trajectories.first_frame
    rows = [
        ["PathFileType", "4", "(X/Y/Z)", path.name],
        [*HEADINGS, *ORIGINAL],
        [rate, rate, str(n), str(len(names)), "mm", rate, str(first), str(n)],
        ["Frame#", "Time", *(cell for name in names for cell in (name, "", ""))],
        ["", "", *(f"{axis}{m + 1}" for m in range(len(names)) for axis in "XYZ")],
        [],
    ]
    xyz = trajectories.xyz.transpose(1, 0, 2)
    xyz[(xyz == 0).all(2)] = OFF_ORIGIN
    flat = xyz.reshape(n, -1)
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines("\t".join(row) + "\n" for row in rows)
        file.writelines(
            f"{f}\t{plain((f - 1) / trajectories.rate)}\t{row_text(values.tolist(), TAB)}\n"
            for f, values in enumerate(flat, first)
        )
