"""Numbers in text, also those of frames."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats, Ints
from .files import read_bytes

MOST_BYTES = 1 << 31  # of a file; chosen for memory
HEAD_BYTES = 1 << 20
"""Bytes that tell what a file is; chosen: a heading of ten thousand columns."""
MOST_HEADING = 10_000
"""Characters in which the mark between cells is looked for; chosen: the lines above a heading are short."""
MISSING = re.compile(r"-?1\.#[a-z]+\d*|-?nan(\(\w*\))?|n/?a|null|none|-+", re.IGNORECASE)
"""How programs write that there is no number, besides an empty cell."""
AGAIN = "Copy or export the file again, or correct that line."


def read_text(path: Path | str) -> str:
    """A text file in UTF-8, in UTF-16, or in Windows' Latin where it is not; without the Ctrl-Z that ends it in DOS.

    Raises:
        KinemarkError: it is absent, empty, larger than 2 GiB, or binary.
    """
    return _decoded(path, read_bytes(path, most=MOST_BYTES))


def read_head(path: Path | str) -> str:
    """The beginning of a text file, which tells what it is; the first MiB, so that its last character may be cut.

    Raises:
        KinemarkError: it is absent, empty, unreadable or binary.
    """
    try:
        with Path(path).open("rb") as file:
            data = file.read(HEAD_BYTES)
    except OSError as error:
        raise KinemarkError(f"{path} cannot be read: {error.strerror}. Check the path.") from error
    if not data:
        raise KinemarkError(f"{path} is empty. Export or copy it again.")
    return _decoded(path, data)


def _decoded(path: Path | str, data: bytes) -> str:
    """The text in the bytes of a file."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", "replace")
    begin = data[:4096]
    if b"\0" in begin:  # Latin letters in UTF-16 have a zero byte each, on one side
        for encoding, zeros, letters in (
            ("utf-16-le", begin[1::2], begin[::2]),
            ("utf-16-be", begin[::2], begin[1::2]),
        ):
            if b"\0" not in letters and zeros.count(0) > len(zeros) // 2:
                return data.decode(encoding, "replace")
        raise KinemarkError(f"{path} is a binary file, wanted text. Check the path.")
    data = data.rstrip(b"\x1a") if data.endswith(b"\x1a") else data
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def bad_line(path: Path | str, line: int, what: str) -> KinemarkError:
    """The error that names a line, counted from 1."""
    return KinemarkError(f"{path}, line {line}: {what}")


def separator(text: str) -> str:
    """The comma, semicolon or tab between the cells of a table, by its first line that has two of them.

    A single comma may be in a number, as in the rate 29,97; with semicolons or tabs each cell may have one.
    """
    begin = text[:MOST_HEADING]
    for line in begin.splitlines():
        count = {mark: line.count(mark) for mark in "\t;,"}
        if sum(count.values()) > 1:
            return next(mark for mark in count if mark == "," or count[mark] >= max(1, count[","] - 1))
    return next((character for character in begin if character in ",;\t"), ",")


def numbers(path: Path | str, lines: Sequence[int], cells: Iterable[Sequence[str]], width: int) -> Floats:
    """(N, width) the cells of N lines as numbers; an empty cell is NaN, and so is one that says it (`MISSING`).

    Args:
        path: for the message.
        lines: (N) number of each line, for the message.
        cells: (N) rows of text; empty cells beyond `width` are ignored.
        width: columns.

    Raises:
        KinemarkError: a row has another number of cells, or a cell is no number; the message has the line.
    """
    table = np.full((len(lines), width), np.nan)
    for k, row in enumerate(cells):
        if len(row) != width and (len(row) < width or any(cell.strip() for cell in row[width:])):
            raise bad_line(path, lines[k], f"has {len(row)} cells, wanted {width}. {AGAIN}")
        try:
            table[k] = _row(row[:width])
        except ValueError as error:
            wrong = str(error).rpartition(": ")[2]
            raise bad_line(
                path, lines[k], f"{wrong} is no number. Correct the cell; an empty one means missing."
            ) from error
    return table


def _row(cells: Sequence[str]) -> list[float]:
    """Cells as numbers: all at once, and one by one only where one is none, or is Python's own."""
    if "_" not in "".join(cells):
        try:
            return list(map(float, cells))
        except ValueError:
            pass
    return list(map(number, cells))


def number(cell: str) -> float:
    """The number in a cell; NaN where it is empty or says that there is none.

    Raises:
        ValueError: it is none.
    """
    try:
        return wanted_number(cell)
    except ValueError:
        text = cell.strip()
        if not text or MISSING.fullmatch(text):
            return np.nan
        raise


def wanted_number(cell: str) -> float:
    """The number in a cell that must have one.

    Raises:
        ValueError: it has none. Python's own 1_000 is none either: in a file it is a name, or damaged.
    """
    if "_" in cell:
        raise ValueError(f"could not convert string to float: {cell!r}")
    return float(cell)


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


def row_text(values: Sequence[float], mark: str) -> str:
    """Numbers as `plain` writes them, with a mark between them."""
    text = mark.join(map(repr, values))
    return text.replace("nan", "") if "nan" in text else text


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
