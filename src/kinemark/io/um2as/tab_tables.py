"""Rows of numbers between tabs, the header over them, and 999."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError
from ...data.array_types import Floats
from ..files import write_text
from ..number_text import bad_line, read_text, wanted_number
from ..units import MM as UNITS_MM

MM = UNITS_MM["cm"]
"""mm in a unit of the files, cm."""

ABSENT = 999.0  # stands for what is missing; of the format (UM²AS eq. 2.6)
HEADER = re.compile(r"\s*Number of frames:\s*(\d+)\s+Number of markers:\s*(\d+)\s*", re.IGNORECASE)
MOST = 10_000_000  # numbers in a file; chosen for memory


class TabHeader(NamedTuple):
    """What the first line of `.da1` and `.tdc` says."""

    frames: int
    markers: int


class TabRows(NamedTuple):
    """A file's header, if it has one, its numbers (N, k) with 999 as NaN, and the line that each row stands in."""

    header: TabHeader | None
    values: Floats
    line: list[int]


def camera_number(path: Path | str, letters: str) -> int:
    """Which camera's file this is, from 1, as `.da2` says.

    Raises:
        KinemarkError: the name does not end so.
    """
    found = re.fullmatch(rf"\.{letters}([1-9]\d?)", Path(path).suffix.lower())
    if not found:
        raise KinemarkError(f"{path} does not end in .{letters} and a camera's number, as .{letters}1. Name it so.")
    return int(found[1])


def read_rows(path: Path | str, *widths: int, absent: bool = True) -> TabRows:
    """The rows of a file that all have one of these widths.

    Args:
        path: the file.
        widths: numbers a row.
        absent: whether 999 means missing; it must then stand in the whole row.

    Raises:
        KinemarkError: the file is absent or has no rows; a row has other numbers; 999 stands in a part of a row.
    """
    lines = [(n, text) for n, text in enumerate(read_text(path).splitlines(), 1) if text.strip()]
    header = HEADER.fullmatch(lines[0][1]) if lines else None
    if header:
        lines = lines[1:]
    if not lines:
        raise KinemarkError(f"{path} has no rows of numbers. Check the path, or make it again.")
    width = len(lines[0][1].split())
    wanted = " or ".join(map(str, widths))
    if width not in widths:
        raise bad_line(path, lines[0][0], f"has {width} entries, wanted {wanted} numbers")
    values = np.array([_row(path, n, text.split(), width, absent) for n, text in lines])
    return TabRows(TabHeader(int(header[1]), int(header[2])) if header else None, values, [n for n, _ in lines])


def _row(path: Path | str, line: int, cells: list[str], width: int, absent: bool) -> list[float]:
    """One row; all NaN where it is 999."""
    if len(cells) != width:
        raise bad_line(path, line, f"has {len(cells)} entries, wanted {width} as in the lines before")
    try:
        row = [wanted_number(cell) for cell in cells]
    except ValueError:
        raise bad_line(path, line, f"{' '.join(cells)!r} is not {width} numbers. Correct the line.") from None
    if not np.isfinite(row).all():
        raise bad_line(path, line, f"{' '.join(cells)!r} is not finite. What is not there is {ABSENT:g}.")
    missing = [absent and value == ABSENT for value in row]
    if any(missing) and not all(missing):
        raise bad_line(path, line, f"999, for what was not seen, in one column only: {' '.join(cells)}. Put it in all.")
    return [np.nan] * width if any(missing) else row


def write_rows(path: Path | str, rows: Floats, *, decimals: int, heading: str | None = None) -> None:
    """Rows (N, k) between tabs with so many decimals; a row with NaN becomes 999.

    A number that would read as 999 is written one unit of the last decimal beside it.

    Raises:
        ValueError: a number is infinite.
        KinemarkError: the file cannot be written.
    """
    if np.isinf(rows).any():
        raise ValueError("rows have infinite numbers, wanted finite ones or NaN")
    text = [heading] if heading else []
    for row in rows.tolist():
        gone = any(value != value for value in row)
        text.append("\t".join(["999"] * len(row) if gone else [number(value, decimals) for value in row]))
    write_lines(path, text)


def number(value: float, decimals: int) -> str:
    """A number as the files have it."""
    text = f"{value:.{decimals}f}"
    return f"{ABSENT + 10.0**-decimals:.{decimals}f}" if float(text) == ABSENT else text


def write_lines(path: Path | str, lines: list[str]) -> None:
    """Lines of text, whole or not at all."""
    write_text(path, "".join(f"{line}\n" for line in lines))


def heading(header: TabHeader) -> str:
    """The first line of `.da1` and `.tdc`."""
    return f"Number of frames: {header.frames} Number of markers: {header.markers}"


def shaped(path: Path | str, rows: TabRows, header: TabHeader) -> Floats:
    """(M, F, k) from rows frame after frame.

    Raises:
        KinemarkError: there are more or fewer rows than frames times markers.
    """
    frames, markers = header
    if not 0 < frames * markers <= MOST:
        raise KinemarkError(f"{path} announces {frames} frames of {markers} markers. Correct its first line.")
    if len(rows.values) != frames * markers:
        raise KinemarkError(
            f"{path} has {len(rows.values)} rows, and {frames} frames of {markers} markers are {frames * markers}. "
            "Was it cut off, or made with other markers? Make it again, or correct the first line."
        )
    return np.ascontiguousarray(rows.values.reshape(frames, markers, -1).transpose(1, 0, 2))
