"""The table of a TRC file of any program: lines are recognised by their content, not by their position.

Motion Analysis (EVaRT, Cortex), OpenSim, BTK and Mokka, MOtoNMS, Pose2Sim and many scripts write TRC, each in its own
way: units left out, headings that stand one cell off their values, blanks for tabs or commas for points, names without
the empty cells between them or once for each axis, no line of axes, rows that end at the last marker seen. What the
table itself says counts; a heading that promises more than the table holds says that something is lost.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from .cut_off import without_cut_row
from .number_text import bad_line, numbers, wanted_number
from .text_rows import Line, TextRows
from .units import mm_per

HEADINGS = ("DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units")
ORIGINAL = ("OrigDataRate", "OrigDataStartFrame", "OrigNumFrames")
MOST_LINES = 20
"""Lines within which a table begins; chosen, the format has 5 or 6."""
AXIS = re.compile(r"[_ .:-]?[xyz]\d*$", re.IGNORECASE)
"""What follows a marker's name where there is one for each of its axes."""


class TrcTable(NamedTuple):
    """A TRC file as it stands.

    Attributes:
        values: what the heading says, by the names in lower case; numbers as text.
        names: (M) of the markers; "" where there is none.
        table: (F, 2 + 3 M) frame, time and coordinates in the file's unit; NaN where a cell is empty.
        lines: (F) number of each row's line. heading, naming: those of the lines with the values and the names.
        notes: what was odd, in words.
    """

    values: dict[str, str]
    names: tuple[str, ...]
    table: Floats
    lines: list[int]
    heading: int
    naming: int
    notes: tuple[str, ...]


def parse_trc(path: Path | str, text: str, *, partial: bool = False) -> TrcTable:
    """The table in the text of a TRC file; where `partial`, without a last row that is cut off.

    Raises:
        KinemarkError: the text is no TRC, or a row is not of one width or has a cell that is no number.
    """
    ends = text.endswith(("\n", "\r"))
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip(' \t\r,;"')]
    del text  # a long one is held once alone
    if not lines or not is_trc(lines[0][1]):
        raise KinemarkError(
            f"{path} is not a TRC file: its first line does not begin with PathFileType. Check the path."
        )
    split = separator(lines)
    rows = TextRows(lines, split)
    headings, heading = _heading(path, rows)
    naming = next((i for i, row in enumerate(rows[:MOST_LINES]) if is_naming(row)), None)
    if naming is None or naming < headings:
        raise bad_line(path, rows[min(3, len(rows) - 1)].number, "wanted Frame#, Time and the names of the markers")
    body = rows[naming + 1 :].where(lambda row: _is_number(row.cells[0]) or not _is_axes(row))
    lead = 2 if len(rows[naming].cells) > 1 and rows[naming].cells[1].casefold().startswith("time") else 1
    width = _width(body, lead)
    names = names_of(rows[naming].cells[lead:], (width - lead) // 3)
    wide = lead + 3 * max(len(names), 1)
    kept, notes = without_cut_row(path, body, wide, ends=ends, partial=partial)
    numbered = [line for line, _ in kept]
    short = _short(kept, wide, ends=ends)
    filled = (cells + [""] * (wide - len(cells)) if k in short else cells for k, (_, cells) in enumerate(kept))
    table = numbers(path, numbered, filled, wide)
    if lead == 1:
        table = np.insert(table, 1, np.nan, axis=1)
    if short:
        notes += (f"{len(short)} rows end before the last marker; the markers that they lack count as missing",)
    values = _values(rows[headings].cells, rows[heading].cells, len(names), len(numbered))
    at = (rows[heading].number, rows[naming].number)
    return TrcTable(values, names, table[:, : 2 + 3 * len(names)], numbered, *at, notes)


def is_trc(first_line: str) -> bool:
    """Whether the first line is that of a TRC file."""
    return first_line.strip('" \t').casefold().startswith(("pathfiletype", "datarate"))


def separator(lines: Sequence[tuple[int, str]]) -> Callable[[str], list[str]]:
    """How the lines of a file are cut into cells: at tabs, commas, semicolons or, where there are none, blanks."""
    naming = next((line for _, line in lines[:MOST_LINES] if line.strip('" \t').casefold().startswith("frame")), "")
    mark = next((mark for mark in "\t;," if mark in naming), None)
    comma = (
        mark != "," and not any("." in line for _, line in lines[-3:]) and any("," in line for _, line in lines[-3:])
    )

    def split(line: str) -> list[str]:
        cells = line.split(mark) if mark else line.split()
        if " " in line or '"' in line:
            cells = [cell.strip().strip('"').strip() for cell in cells]
        return [cell.replace(",", ".") for cell in cells] if comma and _is_number(cells[0]) else cells

    return split


def _is_number(text: str) -> bool:
    try:
        wanted_number(text.replace(",", "."))
    except ValueError:
        return False
    return True


def is_naming(row: Line) -> bool:
    """Whether a line is the one with the names of the markers."""
    return any(cell.casefold().startswith("frame") for cell in row.cells[:2])


def _is_axes(row: Line) -> bool:
    """Whether a line says X1, Y1, Z1, …, wherever these stand."""
    found = [cell for cell in row.cells if cell]
    return all(re.fullmatch(r"[xyzXYZ][\w.:-]*", cell) for cell in found)


def _heading(path: Path | str, rows: TextRows) -> tuple[int, int]:
    """The places of the line that names the values, and of the line that has them."""
    known = {name.casefold() for name in (*HEADINGS, *ORIGINAL)}
    for i, row in enumerate(rows[:MOST_LINES]):
        words = {word.casefold() for cell in row.cells for word in cell.split()}
        if len(words & known) >= 2:
            if i + 1 >= len(rows) or is_naming(rows[i + 1]):
                break
            return i, i + 1
    raise bad_line(path, min(3, len(rows)), f"does not say {', '.join(HEADINGS)}")


def _width(body: TextRows, lead: int) -> int:
    """Cells of whole markers in the widest row; a row that alone is the widest is not believed."""
    widths = sorted((_extent(row) for row in body), reverse=True)
    if not widths:
        return lead
    most = widths[0] if len(widths) < 3 or widths[1] == widths[0] else widths[1]
    return most + (lead - most) % 3


def _extent(row: Line) -> int:
    """Cells up to the last that is not empty."""
    return next((i for i in range(len(row.cells), 0, -1) if row.cells[i - 1]), 0)


def names_of(cells: Sequence[str], columns: int) -> tuple[str, ...]:
    """The names of the markers; "" for columns without one.

    Args:
        cells: behind Frame# and Time. columns: markers that the rows have.
    """
    found = [cell for cell in cells if cell]
    for once in (found, [AXIS.sub("", cell) for cell in found]):  # once for each axis, or with the axis behind it
        if len(found) > columns and _in_threes(once):
            found = once[::3]
            break
    placed = [cells[i] for i in range(0, len(cells), 3)]
    if len(found) < columns and [cell for cell in placed if cell] == found:
        found = placed[:columns]  # a marker without a name, in its place
    return (*found, *[""] * (columns - len(found)))


def _in_threes(names: Sequence[str]) -> bool:
    """Whether each name stands three times."""
    return len(names) % 3 == 0 and all(len(set(names[i : i + 3])) == 1 for i in range(0, len(names), 3))


def _short(body: Sequence[tuple[int, list[str]]], wide: int, *, ends: bool) -> set[int]:
    """Which rows lack whole markers at their end.

    The last row of a file that does not end its last line may have been cut off.
    """
    last = len(body) if ends else len(body) - 1
    return {
        k
        for k, (_, cells) in enumerate(body)
        if len(cells) < wide and k < last and (wide - _extent(Line(k, cells))) % 3 == 0
    }


def _values(headings: Sequence[str], cells: Sequence[str], markers: int, frames: int) -> dict[str, str]:
    """What the heading says: cell by cell, or number by number where that fits the table better."""
    names = [word.casefold() for cell in headings for word in cell.split()]
    words = [word for cell in cells for word in cell.split()]
    texts = [word for word in words if not _is_number(word)]
    unit = next((word for word in texts if mm_per(word) is not None), next(iter(texts), ""))
    figures = [word for word in words if word != unit]
    by_cell = dict(zip((n.casefold() for n in headings), cells, strict=False))
    by_number = dict(zip((n for n in names if not n.startswith("unit")), figures, strict=False))
    ways = [{**way, "units": unit} for way in (by_cell, by_number)]

    def fits(way: dict[str, str]) -> int:
        wanted = {"nummarkers": markers, "numframes": frames}
        return sum(_equals(way.get(name, ""), value) for name, value in wanted.items())

    return max(ways, key=fits)


def _equals(text: str, value: int) -> bool:
    return _is_number(text) and math.isclose(float(text.replace(",", ".")), value)
