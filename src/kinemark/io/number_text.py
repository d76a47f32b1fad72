"""Numbers in text, also those of frames."""

from __future__ import annotations

import codecs
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats, Ints
from .files import read_bytes

MOST_BYTES = 1 << 29  # of a file; chosen for memory
AGAIN = "Copy or export the file again, or correct that line."


def read_text(path: Path | str) -> str:
    """A text file in UTF-8, in UTF-16 with its mark, or in Windows' Latin where it is not.

    Raises:
        KinemarkError: it is absent, empty, larger than 512 MiB, or binary.
    """
    data = read_bytes(path, most=MOST_BYTES)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", "replace")
    if b"\0" in data[:4096]:
        raise KinemarkError(f"{path} is a binary file, wanted text. Check the path.")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def bad_line(path: Path | str, line: int, what: str) -> KinemarkError:
    """The error that names a line, counted from 1."""
    return KinemarkError(f"{path}, line {line}: {what}")


def separator(text: str) -> str:
    """The comma, semicolon or tab that comes first in a table."""
    return next((character for character in text[:1000] if character in ",;\t"), ",")


def numbers(path: Path | str, lines: Sequence[int], cells: Sequence[Sequence[str]], width: int) -> Floats:
    """(N, width) the cells of N lines as numbers; an empty cell is NaN.

    Args:
        path: for the message.
        lines: (N) number of each line, for the message.
        cells: (N) rows of text; empty cells beyond `width` are ignored.
        width: columns.

    Raises:
        KinemarkError: a row has another number of cells, or a cell is no number; the message has the line.
    """
    table = np.full((len(cells), width), np.nan)
    for k, row in enumerate(cells):
        if len(row) < width or any(cell.strip() for cell in row[width:]):
            raise bad_line(path, lines[k], f"has {len(row)} cells, wanted {width}. {AGAIN}")
        try:
            table[k] = [float(cell) if cell.strip() else np.nan for cell in row[:width]]
        except ValueError as error:
            wrong = str(error).rpartition(": ")[2]
            raise bad_line(
                path, lines[k], f"{wrong} is no number. Correct the cell; an empty one means missing."
            ) from error
    return table


def whole(path: Path | str, lines: Sequence[int], values: Floats, name: str) -> Ints:
    """Numbers that must be whole, as integers.

    Raises:
        KinemarkError: one of them is missing or has a fraction.
    """
    wrong = ~(np.abs(values) < 2**53) | (values != np.floor(values))
    if wrong.any():
        k = int(np.flatnonzero(wrong)[0])
        raise bad_line(path, lines[k], f"{name} is {values[k]:g}, wanted a whole number")
    return values.astype(np.int64)


def plain(value: float) -> str:
    """The shortest text that reads back as the same number; empty for NaN."""
    return "" if value != value else repr(float(value))


def first_frame(path: Path | str, lines: Sequence[int], numbers: Floats) -> tuple[int, tuple[str, ...]]:
    """The number of the first frame, and what is odd about the numbers (F), which stand in these lines.

    Raises:
        KinemarkError: frames are missing between others, or a number is none.
    """
    if not len(numbers) or np.isnan(numbers).all():
        return 1, ()
    frame = whole(path, lines, numbers, "the frame")
    steps = np.diff(frame)
    if steps.size and (steps == steps[0]).all() and steps[0] > 1:
        return int(frame[0]), (f"only every {steps[0]}th frame is numbered; they are read as one after the other",)
    if (jump := np.flatnonzero(steps != 1)).size:
        line = lines[int(jump[0]) + 1]
        raise bad_line(path, line, "the frame does not follow the one before. Export every frame.")
    return int(frame[0]), ()
