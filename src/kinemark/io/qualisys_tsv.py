"""The TSV that Qualisys Track Manager exports: names and values, a line each, then a row a frame.

    NO_OF_FRAMES    344                            the words in capitals begin a line; a tab goes before each value
    NO_OF_MARKERS   49
    FREQUENCY       100                            frames a second
    DATA_INCLUDED   3D                             6D, analog and force files hold no markers
    EVENT           heel strike    120    1.19     name, frame, s; as many lines as there are events
    MARKER_NAMES    LASI    RASI    …
    Frame    Time    LASI X    LASI Y    LASI Z …  this line, and both its first columns, are there where asked for
    1        0.00000    512.3    …

Positions are mm. (0, 0, 0), an empty cell and NULL are gaps. The file does not say which axis goes up (with QTM it is
z), nor where force plates stand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import Events, KinemarkError, MarkerTrajectory, Trajectories, Trial
from ..data.array_types import Floats
from .c3d.points import distinct
from .cut_off import AGAIN, ends_its_line, without_cut_row
from .number_text import MISSING, bad_line, first_frame, numbers, read_text, wanted_number
from .text_rows import TextRows
from .units import USUAL_UNITS, mm_per

NAMES = "MARKER_NAMES"
SIGN = "NO_OF_FRAMES"
"""What begins the file."""
HEADING = 1000
"""Lines in which `NAMES` is looked for; chosen: a heading has some ten, and a line for each event."""


class Lines(NamedTuple):
    """The lines of a file, each with its number: values by the word that begins the line, events, rows of numbers."""

    values: dict[str, list[str]]
    events: list[list[str]]
    heading: list[str]
    rows: TextRows


def read_qualisys_tsv(
    path: Path | str, *, rate_hz: float | None = None, length_unit: str | None = None, partial: bool = False
) -> Trial:
    """Markers in mm, events and date of a TSV that Qualisys Track Manager exported.

    Args:
        path: the file.
        rate_hz: frames a second; length_unit: "mm", "cm", "m" or "in": where the file is wrong about them.
        partial: read what there is of a file that holds less than its heading says, or is cut off within a row.

    Raises:
        KinemarkError: the file is absent, malformed or cut off, or holds no markers.
    """
    found = _lines(path)
    names = [name.strip() for name in found.values.get(NAMES, [])]
    while names and not names[-1]:
        names.pop()
    if not names:
        what = " ".join(found.values.get("DATA_INCLUDED", [])).strip() or "no MARKER_NAMES"
        raise KinemarkError(f"{path} holds {what}, and no markers. Export the 3D data of QTM as TSV, or as C3D.")
    if not found.rows:
        raise KinemarkError(f"{path} has a heading and no frames. Export it again.")
    if (mm := mm_per(length_unit or "mm")) is None:
        raise KinemarkError(f"The unit {length_unit!r} is none. Wanted is {USUAL_UNITS}.")
    lines, before, values, lost = _table(path, found, len(names), partial)
    first, odd = first_frame(path, lines, values[:, 0]) if before else (1, ())
    xyz = values[:, before:].reshape(len(values), -1, 3)
    xyz[(xyz == 0).all(-1) | np.isnan(xyz).any(-1)] = np.nan
    called = distinct(names, len(names), "*")
    paths = tuple(MarkerTrajectory.measured(name, xyz[:, k] * mm) for k, name in enumerate(called))
    trajectories = Trajectories(paths, _rate(path, found, rate_hz), first)
    return Trial(Path(path).stem, trajectories, events=_events(found), about=_about(found), notes=(*lost, *odd))


def is_qualisys(first_line: str) -> bool:
    """Whether the first line is that of QTM."""
    return first_line.startswith(SIGN)


def holds_markers(path: Path) -> bool:
    """Whether a TSV is one of markers: those of analog signals and forces end alike. False if it is not read."""
    try:
        with path.open("rb") as file:
            return any(line.startswith(NAMES.encode()) for line in islice(file, HEADING))
    except OSError:
        return False


def _lines(path: Path | str) -> Lines:
    """The lines of a file by what they are."""
    lines = [(k, line) for k, line in enumerate(read_text(path).splitlines(), 1) if line.strip()]
    found = Lines({}, [], [], TextRows((), str.split))
    for k, (_, line) in enumerate(lines):
        cells = line.split("\t")
        word = cells[0].strip()
        if _is_number(word) or (not word and NAMES in found.values):  # a row may begin with a gap
            return found._replace(rows=TextRows(lines[k:], lambda row: row.replace(",", ".").split("\t")))
        if NAMES in found.values and not (word.isupper() and "_" in word):
            found.heading.extend(cell.strip() for cell in cells)
        elif word == "EVENT":
            found.events.append(cells[1:])
        else:
            found.values[word] = cells[1:]
    return found


def _is_number(text: str) -> bool:
    try:
        wanted_number(text.replace(",", "."))
    except ValueError:
        return MISSING.fullmatch(text) is not None
    return True


def _table(path: Path | str, found: Lines, n: int, partial: bool) -> tuple[list[int], int, Floats, tuple[str, ...]]:
    """Numbers of the lines, columns before the markers, the values (F, columns), and what the file lacks.

    Raises:
        KinemarkError: the file has other columns or fewer frames than it says.
    """
    widths = [len(cells) - (cells[-1].strip() == "") for _, cells in found.rows]
    before = (2 if "Time" in found.heading[:2] else 1) if "Frame" in found.heading[:1] else max(widths) - 3 * n
    if before not in (0, 1, 2):
        raise bad_line(path, found.rows[0][0], f"has {max(widths)} cells, wanted {3 * n} for the {n} MARKER_NAMES.")
    width = before + 3 * n
    rows, lost = without_cut_row(path, found.rows, width, ends=ends_its_line(path), partial=partial)
    lines = [line for line, _ in rows]
    stated = _whole(found.values.get("NO_OF_FRAMES"))
    if stated is not None and len(lines) < stated:
        if not partial:
            raise KinemarkError(f"{path} has {len(lines)} frames, its heading says {stated}. {AGAIN}")
        lost = (*lost, f"the heading says {stated} frames, the table has {len(lines)}; all of the table is read")
    return lines, before, numbers(path, lines, (cells for _, cells in rows), width), lost


def _whole(cells: Sequence[str] | None) -> int | None:
    """The first cell as a number."""
    text = cells[0].strip() if cells else ""
    return int(text) if text.isdigit() else None


def _rate(path: Path | str, found: Lines, said: float | None) -> float:
    """Frames a second, as said, else as the file states."""
    text = (found.values.get("FREQUENCY") or [""])[0].strip()
    try:
        rate = wanted_number(text.replace(",", ".")) if said is None else said
    except ValueError:
        rate = math.nan
    if not 0 < rate < math.inf:
        raise KinemarkError(f"{path} states a FREQUENCY of {text or 'nothing'}. State it with --rate-hz.")
    return rate


def _about(found: Lines) -> dict[str, str]:
    """When it was recorded: "2020-01-31, 10:11:12" and, behind it, a counter of the system's."""
    text = (found.values.get("TIME_STAMP") or [""])[0].strip()
    return {"date": text.replace(", ", "T")} if text else {}


def _events(found: Lines) -> Events:
    """Events at their times; a side only where the name says it."""
    known = [(cells[0].strip(), cells[2]) for cells in found.events if len(cells) > 2 and _is_number(cells[2])]
    sides = [next((side for side in ("Left", "Right") if side.lower() in name.lower()), "") for name, _ in known]
    times = np.array([float(text.replace(",", ".")) for _, text in known])
    return Events(tuple(name for name, _ in known), tuple(sides), times)
