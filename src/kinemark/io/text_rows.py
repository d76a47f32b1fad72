"""Rows of a table in text, cut into cells where they are asked for: all cells of a long one fill memory."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple, overload

from .number_text import bad_line, read_text, separator


class Line(NamedTuple):
    """Number of a line, from 1, and its cells."""

    number: int
    cells: list[str]


class TextRows(Sequence[Line]):
    """The lines of a table, each with its number; a row is cut into cells every time that it is asked for."""

    def __init__(self, lines: Sequence[tuple[int, str]], cut: Callable[[str], list[str]]) -> None:
        self._lines, self._cut = lines, cut

    def __len__(self) -> int:
        return len(self._lines)

    def __iter__(self) -> Iterator[Line]:
        return (Line(number, self._cut(line)) for number, line in self._lines)

    @overload
    def __getitem__(self, at: int) -> Line: ...
    @overload
    def __getitem__(self, at: slice) -> TextRows: ...
    def __getitem__(self, at: int | slice) -> Line | TextRows:
        if isinstance(at, slice):
            return TextRows(self._lines[at], self._cut)
        number, line = self._lines[at]
        return Line(number, self._cut(line))

    def where(self, keep: Callable[[Line], bool]) -> TextRows:
        """The rows of which this is true."""
        kept = [line for line, row in zip(self._lines, self, strict=True) if keep(row)]
        return TextRows(kept, self._cut)


def csv_rows(path: Path | str) -> Sequence[tuple[int, list[str]]]:
    """The lines of a CSV file that are not empty, each with its number, as cells; decimal commas become points.

    Raises:
        KinemarkError: the file is absent, empty, binary, or its quotes do not end.
    """
    text = read_text(path)
    mark = separator(text)
    quotes = '"' in text
    lines = (text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text).split("\n")
    if quotes and any(line.count('"') % 2 for line in lines):  # a cell goes on in the next line
        return _quoted_rows(path, text, mark)
    del text
    blank = f'{mark}"' if quotes else mark
    kept = [(number, line) for number, line in enumerate(lines, 1) if line.strip(blank)]
    del lines
    if mark != "," and not any("." in line for _, line in kept[1:]):
        head = int(any(map(str.isalpha, kept[0][1]))) if kept else 0  # a table may have no heading, as one of DLT
        kept[head:] = [(number, line.replace(",", ".")) for number, line in kept[head:]]

    def cut(line: str) -> list[str]:
        return next(csv.reader([line], delimiter=mark)) if '"' in line else line.split(mark)

    return TextRows(kept, cut)


def csv_table(path: Path | str) -> tuple[list[str], list[dict[str, str]]]:
    """The heading of a CSV file and its rows, each by the names of the columns; "" where a row ends early.

    Raises:
        KinemarkError: as `csv_rows`.
    """
    rows = csv_rows(path)
    heading = [cell.strip() for cell in rows[0][1]] if rows else []
    return heading, [dict(zip_longest(heading, cells[: len(heading)], fillvalue="")) for _, cells in rows[1:]]


def _quoted_rows(path: Path | str, text: str, mark: str) -> list[tuple[int, list[str]]]:
    """The same where cells in quotes have line breaks in them."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=mark)
    try:
        rows = [(reader.line_num, cells) for cells in reader if any(cells)]
    except csv.Error as error:
        raise bad_line(path, reader.line_num, f"{error}") from error
    if mark == "," or any("." in cell for _, cells in rows[1:] for cell in cells):
        return rows
    return rows[:1] + [(line, [cell.replace(",", ".") for cell in cells]) for line, cells in rows[1:]]
