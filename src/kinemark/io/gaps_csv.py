"""What became of the gaps of many files, as CSV: a row a gap.

    file, marker, first_frame, last_frame, length_s, state, reason, method, expected_mm, sd_max_mm, hold_out_gaps

state is "filled" or "open", for the reason; hold_out_gaps are those by which the error is expected. An empty cell is
not known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .csv_table import cell, write_table

NUMBERS = ("expected_mm", "sd_max_mm")
HEADING = (
    "file", "marker", "first_frame", "last_frame", "length_s", "state", "reason", "method", *NUMBERS, "hold_out_gaps",
)  # fmt: skip


def write_gaps_csv(path: Path | str, each: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """Write the table.

    Args:
        path: of it; an existing one is replaced. each: gaps by file, as the figures of filling list them.

    Raises:
        KinemarkError: the file cannot be written.
    """
    rows = (
        [file, gap["marker"], str(gap["first_frame"]), str(gap["last_frame"]), cell(gap["length_s"]),
         gap["state"], gap["reason"], gap["method"],
         *("" if gap[name] is None else cell(gap[name]) for name in NUMBERS), str(gap["tests"])]
        for file, gaps in each.items() for gap in gaps
    )  # fmt: skip
    write_table(path, HEADING, rows)


def is_gaps_csv(path: Path) -> bool:
    """Whether a file begins as such a table does.

    Raises:
        OSError: it cannot be read.
    """
    heading = ",".join(HEADING).encode()
    with path.open("rb") as file:
        return file.read(len(heading) + 1).rstrip(b"\r\n") == heading
