"""Tables that end within a row, as a copy that was broken off leaves them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..data import KinemarkError
from .number_text import bad_line

AGAIN = "Copy or export it again, or write what is left to another file: kinemark convert FROM TO --partial."
"""What helps with a file that is cut off."""
Row = tuple[int, list[str]]
"""Number of a line, from 1, and its cells."""


def ends_its_line(path: Path | str) -> bool:
    """Whether the last line of a file has its end; of UTF-16 an end takes two bytes.

    Raises:
        KinemarkError: the file cannot be read.
    """
    try:
        with Path(path).open("rb") as file:
            file.seek(max(0, file.seek(0, 2) - 2))
            last = file.read()
    except OSError as error:
        raise KinemarkError(f"{path} cannot be read: {error.strerror}. Check the path.") from error
    return last[-1:] in (b"\n", b"\r") or last in (b"\n\0", b"\r\0", b"\0\n", b"\0\r")


def without_cut_row(
    path: Path | str, body: Sequence[Row], wide: int, *, ends: bool, partial: bool
) -> tuple[Sequence[Row], tuple[str, ...]]:
    """The rows of a table without a last one that is cut off, and a note of it.

    A last number with fewer decimals than any other of its column has may have lost digits: its sample is missing.

    Args:
        path: for messages. body: the rows. wide: cells of a row.
        ends: whether the file ends its last line; where it does, nothing is cut off.
        partial: whether to read what there is.

    Raises:
        KinemarkError: the last row lacks cells, and `partial` is false or it is the only one.
    """
    if ends or not body:
        return body, ()
    others, (line, cells) = body[:-1], body[-1]
    if len(cells) < wide:
        if not (partial and others):
            raise bad_line(path, line, f"has {len(cells)} cells, wanted {wide}, for the file is cut off. {AGAIN}")
        return others, (f"line {line} is cut off and left out",)
    column = [_decimals(row[wide - 1]) for _, row in others if len(row) >= wide and row[wide - 1]]
    if wide > 3 and column and cells[wide - 1] and _decimals(cells[wide - 1]) < min(column):
        note = f"the file ends within line {line}, maybe within its last number, whose sample counts as missing"
        return [*others, (line, [*cells[: wide - 1], "", *cells[wide:]])], (note,)
    return body, ()


def _decimals(text: str) -> int:
    """How many digits a number has after its point."""
    return len(text.replace(",", ".").partition(".")[2])
