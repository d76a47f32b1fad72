"""Names of markers that a person stated: a CSV with a row for each, anchored in time and place.

    trial,frame,x_mm,y_mm,z_mm,name
    walk01,120,812.5,-40.1,951.0,SACR

`frame` counts from 1 in the recording; the place is that of the marker there, as the report or any viewer shows it. A
name that is empty says that the track there is no marker. Tracks' numbers are no anchor: they change when the tracker
is told otherwise.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from ..data import KinemarkError
from .number_text import wanted_number
from .text_rows import csv_rows

HEAD = ("trial", "frame", "x_mm", "y_mm", "z_mm", "name")


class StatedName(NamedTuple):
    """That the marker at a place (3) mm in a frame of a trial, counted from 1, is this one; no marker where empty."""

    trial: str
    frame: int
    place: tuple[float, float, float]
    name: str


def read_stated_names(path: Path) -> tuple[StatedName, ...]:
    """The statements of a file.

    Raises:
        KinemarkError: it is absent, has other columns, or a row has no numbers where there should be.
    """
    rows = csv_rows(path)
    if not rows or tuple(cell.strip() for cell in rows[0][1]) != HEAD:
        raise KinemarkError(f"{path} begins with {rows[0][1] if rows else 'nothing'}. Wanted are the columns {HEAD}.")
    return tuple(_stated(path, k, row) for k, row in rows[1:] if any(map(str.strip, row)))


def _stated(path: Path, line: int, row: list[str]) -> StatedName:
    cells = [cell.strip() for cell in row]
    try:
        trial, frame, x, y, z, name = cells
        place = (wanted_number(x), wanted_number(y), wanted_number(z))
        found = StatedName(trial, int(frame), place, name)
        if "_" in frame or found.frame < 1 or not all(map(math.isfinite, place)):
            raise ValueError
    except ValueError:
        raise KinemarkError(
            f"{path}, line {line}: {','.join(row)}. Wanted are a trial, a frame from 1, three lengths in mm and a name."
        ) from None
    return found
