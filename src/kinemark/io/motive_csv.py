"""The CSV that OptiTrack's Motive exports (format 1.2 and later).

    Format Version,1.23,Take Name,walk,…,Export Frame Rate,120.0,…,Length Units,Meters,…
    ,Type,Marker,Marker,Marker,Rigid Body,…       older versions leave the words Type, Name, ID out
    ,Name,Anna:LASI,Anna:LASI,Anna:LASI,…         a marker that nobody named is "Unlabeled 1204"
    ,ID,…
    ,,Position,Position,Position,Rotation,…       what stands in the column
    Frame,Time (Seconds),X,Y,Z,X,…
    0,0.000000,0.5123,…                           an empty cell is a gap

Columns of the type Marker are what cameras measured and are read. "Rigid Body Marker" and "Bone Marker" are where
the program expects markers of an asset, and with rotations, bones and errors they are left out. Y goes up in Motive.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from ..data.array_types import Floats
from ..data.trial import UP
from .c3d.points import distinct
from .cut_off import Row, ends_its_line, without_cut_row
from .number_text import bad_line, first_frame, numbers
from .text_rows import csv_rows
from .units import USUAL_UNITS, mm_per

SIGN = "format version"
MARKER, POSITION = "marker", "position"
UNLABELED = re.compile(r"(?:.*:)?Unlabeled[ _]?(\w+)")
RATES = ("export frame rate", "capture frame rate")
"""What the heading calls the rate of the rows, the one that counts first."""
SAME_RATE = 0.01
"""Share by which the rate of the heading and that of the times may differ; chosen: times have six decimals."""
TELLS_UP = "y is taken to go up, as it does in Motive; the file does not say it: export it with Motive's own axes"


class Heading(NamedTuple):
    """What stands above the numbers, a cell for each of K columns.

    Attributes:
        values: of the first line, by name in small letters.
        types, names, what, axes: (K) as Marker, LASI, Position, X.
        line: number of the last line of the heading.
    """

    values: Mapping[str, str]
    types: list[str]
    names: list[str]
    what: list[str]
    axes: list[str]
    line: int


def is_motive(first_line: str) -> bool:
    """Whether the first line is that of Motive."""
    return first_line.strip().strip('"').lower().startswith(SIGN)


def read_motive_csv(
    path: Path | str, *, rate_hz: float | None = None, length_unit: str | None = None, partial: bool = False
) -> Trial:
    """Measured markers of a CSV that Motive exported, mm, y upwards.

    Args:
        path: the file.
        rate_hz: frames a second; length_unit: "mm", "cm", "m" or "in": where the file is silent or wrong about them.
        partial: read what there is of a file that is cut off within a row.

    Raises:
        KinemarkError: the file is absent, malformed or cut off, has no measured markers, leaves frames out, or tells no
            unit or rate.
    """
    rows = csv_rows(path)
    top = _heading(path, rows)
    body, lost = _body(path, rows, top, partial)
    lines = [line for line, _ in body]
    cells = ([cell.replace(",", ".") for cell in row] for _, row in body)
    at = _markers(path, top)
    table = numbers(
        path, lines, _only(path, lines, cells, [0, 1, *(k + i for k in at for i in range(3))], top), 2 + 3 * len(at)
    )
    mm = _mm(path, top, length_unit)
    rate, notes = _rate(path, top, table[:, 1], rate_hz)
    first, odd = first_frame(path, lines, table[:, 0])
    xyz = table[:, 2:].reshape(len(table), len(at), 3).transpose(1, 0, 2) * mm
    names = distinct([_name(top.names[k]) for k in at], len(at), "*")
    paths = tuple(MarkerTrajectory.measured(name, x) for name, x in zip(names, xyz, strict=True))
    return Trial(
        Path(path).stem,
        Trajectories(paths, rate, first),
        about={UP: "+Y"},
        notes=(*lost, *notes, *odd, *_left(top), TELLS_UP),
    )


def _heading(path: Path | str, rows: Sequence[tuple[int, list[str]]]) -> Heading:
    """The lines above the numbers."""
    frame = next((k for k, (_, cells) in enumerate(rows) if cells[0].strip().lower() == "frame"), 0)
    if frame < 4:
        raise bad_line(
            path, 1, "wanted lines of types, names and positions above Frame, Time. Export it with its heading."
        )
    axes = [cell.strip() for cell in rows[frame][1]]
    kinds, names, *_, what = ([c.strip() for c in (*row, *[""] * len(axes))] for _, row in rows[1:frame])
    first = [cell.strip().strip('"') for cell in rows[0][1]]
    values = {name.lower(): value for name, value in zip(first[::2], first[1::2], strict=False)}
    return Heading(values, kinds, names, what, axes, rows[frame][0])


def _body(path: Path | str, rows: Sequence[Row], top: Heading, partial: bool) -> tuple[Sequence[Row], tuple[str, ...]]:
    """The rows below the heading, and a note of a last one that is cut off."""
    body = rows[next((k for k, row in enumerate(rows) if row[0] > top.line), len(rows)) :]
    if not body:
        raise KinemarkError(f"{path} has a heading and no frames. Export it again.")
    return without_cut_row(path, body, len(top.axes), ends=ends_its_line(path), partial=partial)


def _markers(path: Path | str, top: Heading) -> list[int]:
    """The first column of each measured marker."""
    places = [
        k
        for k in range(2, len(top.axes) - 2)
        if top.axes[k : k + 3] == ["X", "Y", "Z"] and top.what[k].lower() == POSITION
    ]
    at = [k for k in places if top.types[k].lower() == MARKER]
    if not at:
        have = ", ".join(dict.fromkeys(top.types[k] for k in places if top.types[k])) or "nothing"
        raise KinemarkError(f"{path} holds positions of {have}, and no measured markers. Export it again with Markers.")
    return at


def _only(
    path: Path | str, lines: Sequence[int], cells: Iterable[Sequence[str]], at: Sequence[int], top: Heading
) -> Iterator[list[str]]:
    """The cells of these columns."""
    for line, row in zip(lines, cells, strict=True):
        if len(row) <= max(at):
            what = f"has {len(row)} cells, wanted {len(top.axes)}. Copy or export the file again."
            raise bad_line(path, line, what)
        yield [row[k] for k in at]


def _mm(path: Path | str, top: Heading, stated: str | None) -> float:
    """mm in the unit of the file."""
    text = stated or top.values.get("length units", "")
    if (mm := mm_per(text)) is None:
        raise bad_line(path, 1, f"Length Units is {text!r}, wanted {USUAL_UNITS}. State it with --length-unit.")
    return mm


def _rate(path: Path | str, top: Heading, time: Floats, said: float | None) -> tuple[float, tuple[str, ...]]:
    """Frames a second: what the caller says, the heading, or the times."""
    if said is not None:
        return said, ()
    step = np.diff(time)
    usual = float(np.median(step)) if step.size else np.nan
    timed = 1 / usual if usual > 0 else np.nan
    stated = [text for name in RATES if (text := top.values.get(name))]
    try:
        rate = float(stated[0]) if stated else timed
    except ValueError as error:
        raise bad_line(path, 1, f"the frame rate: {error}. State it with --rate-hz.") from error
    if not 0 < rate < np.inf:
        raise bad_line(path, 1, "neither a frame rate nor the times tell the rate. State it with --rate-hz.")
    if abs(timed - rate) > SAME_RATE * rate:
        return rate, (f"the heading says {rate:g} Hz, the times go at {timed:g} Hz; the heading counts",)
    return rate, ()


def _name(text: str) -> str:
    """The marker's name; `*1204` where nobody named it."""
    found = UNLABELED.fullmatch(text)
    return f"*{found[1]}" if found else text


def _left(top: Heading) -> tuple[str, ...]:
    """The types of columns that are not read, with how many things there are of each."""
    owners = {(kind, name) for kind, name in zip(top.types, top.names, strict=False) if kind and name}
    count = Counter(kind for kind, _ in owners if kind.lower() not in (MARKER, "type"))
    return tuple(f"{kind} ({n}) is not measured and is not read" for kind, n in sorted(count.items()))
