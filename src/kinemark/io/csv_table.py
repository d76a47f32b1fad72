"""Tables of numbers as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from .files import replacing
from .number_text import plain


def cell(value: float) -> str:
    """Six decimals; empty for NaN and infinity."""
    return plain(round(float(value), 6)) if np.isfinite(value) else ""


def write_table(path: Path | str, heading: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a heading and rows in UTF-8, whole or not at all.

    Raises:
        KinemarkError: the file cannot be written.
    """
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heading)
        writer.writerows(rows)
