"""The CSV that Vicon Nexus exports ("ASCII"): blocks one below the other, a blank line between them.

    Trajectories                                  the title of the block: Devices, Joints, Model Outputs, Trajectories
    100                                           samples a second
    ,,Anna:LASI,,,Anna:RASI,,                     whose the columns are; of a device, its name
    Frame,Sub Frame,X,Y,Z,X,Y,Z                   perhaps followed by velocities X', Y', Z' and accelerations X'', …
    ,,mm,mm,mm,mm,mm,mm
    1,0,512.3,…                                   an empty cell is a gap; a sub frame is a sample between frames

Events come as a block of their own: Subject, Context, Name, Time (s), Description. Trajectories, channels of devices
and events are read; joints and model outputs are named in a note. The file does not say where force plates stand, nor
which axis goes up (with Nexus it is z).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import Analog, Events, KinemarkError, MarkerTrajectory, Trajectories, Trial
from ..data.array_types import Floats
from .c3d.points import distinct
from .cut_off import ends_its_line, without_cut_row
from .number_text import bad_line, first_frame, numbers, wanted_number
from .text_rows import csv_rows
from .units import USUAL_UNITS, mm_per

MARKERS, DEVICES, EVENTS = "trajectories", "devices", "events"
TITLES = (MARKERS, DEVICES, EVENTS, "joints", "segments", "model outputs")
"""What a block is called, in small letters; segments are the joints of older versions."""
EVENT_COLUMNS = ("context", "name", "time (s)")
Row = tuple[int, list[str]]


class Block(NamedTuple):
    """A block of the file: its title as written, and the lines below it, each with its number."""

    title: str
    rows: Sequence[Row]


class Table(NamedTuple):
    """The numbers of a block of N rows and K columns.

    Attributes:
        rate: samples a second, Hz.
        names: (K) whose each column is. axes: (K) as X. units: (K) as mm.
        lines: (N) number of each line.
        values: (N, K); NaN where a cell is empty.
    """

    rate: float
    names: list[str]
    axes: list[str]
    units: list[str]
    lines: list[int]
    values: Floats


def is_nexus(first_line: str) -> bool:
    """Whether the first line that is not empty is the title of a block."""
    return first_line.strip().strip(",;\t").strip().lower() in TITLES


def read_nexus_csv(
    path: Path | str, *, rate_hz: float | None = None, length_unit: str | None = None, partial: bool = False
) -> Trial:
    """Markers in mm, channels and events of a CSV that Nexus exported.

    Args:
        path: the file.
        rate_hz: frames a second; length_unit: "mm", "cm", "m" or "in": where the file is wrong about them.
        partial: read what there is of a file that is cut off within a row.

    Raises:
        KinemarkError: the file is absent, malformed or cut off, has no trajectories, leaves frames out, or has another
            unit.
    """
    blocks = _blocks(path)
    named = {block.title.lower(): block for block in blocks}
    if MARKERS not in named:
        have = ", ".join(block.title for block in blocks)
        raise KinemarkError(f"{path} holds {have}, and no Trajectories. Export it again with these.")
    ends = ends_its_line(path)
    tables = {
        title: _table(path, block, ends=ends or block is not blocks[-1], partial=partial)
        for title, block in named.items()
        if title in (MARKERS, DEVICES)
    }
    table, lost = tables[MARKERS]
    trajectories, odd = _trajectories(path, table, rate_hz, length_unit)
    devices, lost_too = tables.get(DEVICES, (None, ()))
    analog = (_channels(devices, trajectories),) if devices is not None else ()
    events = _events(path, named[EVENTS]) if EVENTS in named else Events()
    left = [block.title for block in blocks if block.title.lower() not in (MARKERS, DEVICES, EVENTS)]
    notes = (*lost, *lost_too, *odd, *(f"the block {title} is not read" for title in left))
    return Trial(Path(path).stem, trajectories, analog, events=events, notes=notes)


def _blocks(path: Path | str) -> list[Block]:
    """The blocks in their order; a title is a line of one cell that is a known word."""
    rows = csv_rows(path)
    titles = [
        k
        for k, (_, cells) in enumerate(rows)
        if cells[0].strip().lower() in TITLES and not any(map(str.strip, cells[1:]))
    ]
    return [Block(rows[k][1][0].strip(), rows[k + 1 : end]) for k, end in pairwise([*titles, len(rows)])]


def _table(path: Path | str, block: Block, *, ends: bool, partial: bool) -> tuple[Table, tuple[str, ...]]:
    """The rate, the headings and the numbers of a block, and a note of a last row that is cut off."""
    if len(block.rows) < 4:
        line = block.rows[-1][0] if block.rows else 1
        raise bad_line(path, line, f"{block.title} ends before its first row. Export the file again.")
    (at, rate_cells), (_, names), (heading, axes), (_, units) = block.rows[:4]
    rate = _positive(rate_cells[0])
    if rate is None:
        raise bad_line(path, at, f"wanted samples a second below {block.title}, found {rate_cells[0]!r}")
    if [cell.strip().lower() for cell in axes[:2]] != ["frame", "sub frame"]:
        raise bad_line(path, heading, f"wanted Frame, Sub Frame, then the columns of {block.title}; found {axes[:3]}")
    axes = [cell.strip() for cell in axes]
    while axes and not axes[-1]:
        axes.pop()
    width = len(axes)
    rows, lost = without_cut_row(path, block.rows[4:], width, ends=ends, partial=partial)
    lines = [line for line, _ in rows]
    cells = ([cell.replace(",", ".") for cell in row] for _, row in rows)
    values = numbers(path, lines, cells, width)
    return Table(rate, _cells(names, width), axes, _cells(units, width), lines, values), lost


def _positive(text: str) -> float | None:
    """A finite number above 0; None if it is none."""
    try:
        number = wanted_number(text.replace(",", "."))
    except ValueError:
        return None
    return number if 0 < number < np.inf else None


def _cells(row: Sequence[str], width: int) -> list[str]:
    """The cells of a heading without blanks, as many as there are columns."""
    return [cell.strip() for cell in (*row, *[""] * width)][:width]


def _trajectories(
    path: Path | str, table: Table, rate_hz: float | None, length_unit: str | None
) -> tuple[Trajectories, tuple[str, ...]]:
    """The columns X, Y, Z of each marker."""
    if (between := np.flatnonzero(table.values[:, 1] > 0)).size:
        raise bad_line(path, table.lines[int(between[0])], "Trajectories have a sub frame, wanted whole frames alone")
    first, odd = first_frame(path, table.lines, table.values[:, 0])
    at = [k for k in range(2, len(table.axes) - 2) if table.axes[k : k + 3] == ["X", "Y", "Z"]]
    names = distinct([table.names[k] for k in at], len(at), "*")
    paths = tuple(
        MarkerTrajectory.measured(name, table.values[:, k : k + 3] * _mm(path, table, k, length_unit))
        for name, k in zip(names, at, strict=True)
    )
    return Trajectories(paths, rate_hz or table.rate, first), odd


def _mm(path: Path | str, table: Table, k: int, stated: str | None) -> float:
    """mm in the unit of a marker's columns."""
    units = {stated} if stated else set(table.units[k : k + 3])
    unit = units.pop()
    if units or (mm := mm_per(unit)) is None:
        found = ", ".join(table.units[k : k + 3])
        what = f"{table.names[k]} is in {found or 'no unit'}, wanted {USUAL_UNITS}. State it with --length-unit."
        raise bad_line(path, table.lines[0] - 1 if table.lines else 1, what)
    return mm


def _channels(table: Table, trajectories: Trajectories) -> Analog:
    """The channels of all devices, as "device channel"; units as the file states them."""
    names, owner = [], ""
    for own, axis in zip(table.names[2:], table.axes[2:], strict=True):
        owner = own or owner  # a device's name stands above its first column
        names.append(f"{owner} {axis}".strip())
    later = table.values[0, 0] - trajectories.first_frame if len(table.values) else 0.0
    start = 0.0 if np.isnan(later) else float(later) / trajectories.rate
    return Analog(
        distinct(names, len(names), "channel "), tuple(table.units[2:]), table.rate, table.values[:, 2:].T, start
    )


def _events(path: Path | str, block: Block) -> Events:
    """What happened when; the line of the rate, if there is one, is passed over."""
    heads = [k for k, (_, cells) in enumerate(block.rows) if {c.strip().lower() for c in cells} >= set(EVENT_COLUMNS)]
    if not heads:
        return Events()
    columns = [cell.strip().lower() for cell in block.rows[heads[0]][1]]
    side, label, time = (columns.index(name) for name in EVENT_COLUMNS)
    rows = [(line, cells) for line, cells in block.rows[heads[0] + 1 :] if len(cells) > max(side, label, time)]
    try:
        times = [wanted_number(cells[time].replace(",", ".")) for _, cells in rows]
    except ValueError as error:
        raise bad_line(path, rows[0][0], f"among the times of events: {error}") from error
    return Events(
        tuple(cells[label].strip() for _, cells in rows),
        tuple(cells[side].strip() for _, cells in rows),
        np.array(times),
    )
