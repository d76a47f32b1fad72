"""What an operator answered while digitising: `frame, marker, answer`, a row an answer, in the order of answering.

Frames count from 1; the marker is empty where the answer is of the whole frame; `data.answers` says what they are.

    frame,marker,answer
    1,ELB4,312 204
    1,MC37,-
    1,,save
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from ..data import KinemarkError
from ..data.answers import Given, answer_text, parse_answer
from .csv_table import write_table
from .number_text import bad_line, read_text

HEADING = ["frame", "marker", "answer"]


def read_answers(path: Path | str) -> list[Given]:
    """The answers of a file; none where it does not exist.

    Raises:
        KinemarkError: it has other columns, or a row that is no answer.
    """
    if not Path(path).exists():
        return []
    reader = csv.reader(io.StringIO(read_text(path), newline=""))
    try:
        if [cell.strip() for cell in next(reader, [])] != HEADING:
            raise bad_line(path, 1, f"wanted the heading {','.join(HEADING)}")
        return [_given(path, reader.line_num, row) for row in reader if row]
    except csv.Error as error:
        raise bad_line(path, reader.line_num, f"{error}") from error


def _given(path: Path | str, line: int, row: list[str]) -> Given:
    if len(row) != len(HEADING):
        raise bad_line(path, line, f"has {len(row)} cells, wanted {', '.join(HEADING)}")
    frame, marker, text = (cell.strip() for cell in row)
    if not frame.isdecimal() or int(frame) < 1:
        raise bad_line(path, line, f"frame is {frame!r}, wanted a number from 1")
    try:
        return Given(int(frame) - 1, marker, parse_answer(text))
    except ValueError as error:
        raise bad_line(path, line, str(error)) from None


def _row(one: Given) -> tuple[str, str, str]:
    return str(one.frame + 1), one.marker, answer_text(one.answer)


def write_answers(path: Path | str, answers: Sequence[Given]) -> None:
    """Write answers, all or nothing.

    Raises:
        KinemarkError: the file cannot be written.
    """
    write_table(path, HEADING, map(_row, answers))


def append_answer(path: Path | str, answer: Given) -> None:
    """One answer more, so that nothing that was said is lost when the program stops.

    Raises:
        KinemarkError: the file cannot be written.
    """
    path = Path(path)
    if not path.exists():
        write_answers(path, [])
    try:
        with path.open("a", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerow(_row(answer))
    except OSError as error:
        raise KinemarkError(f"{path} cannot be written: {error}. Choose a folder that you may write to.") from error
