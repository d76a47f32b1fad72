"""Trajectories as CSV: `frame, time_s`, then `NAME_x_mm, NAME_y_mm, NAME_z_mm` a marker; an empty cell is a gap."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError, Trajectories
from ..data import MarkerTrajectory as MarkerPath
from .files import replacing
from .number_text import bad_line, numbers, plain, read_text, whole

AXES = ("_x_mm", "_y_mm", "_z_mm")


def read_trajectories_csv(path: Path | str, *, rate: float | None = None) -> Trajectories:
    """Markers in mm from a CSV file.

    Args:
        path: the file.
        rate: Hz; without it, frames over time of the first and last row, to twelve digits.

    Raises:
        KinemarkError: the file is absent or malformed, a frame is left out, or nothing tells the rate.
    """
    rows = list(csv_rows(path))
    if not rows:
        raise KinemarkError(f"{path} has no header line. Check the path.")
    names = markers(path, rows[0][1])
    at = [k for k, _ in rows[1:]]
    table = numbers(path, at, [cells for _, cells in rows[1:]], 2 + 3 * len(names))
    frame = whole(path, at, table[:, 0], "frame")
    if (jump := np.flatnonzero(np.diff(frame) != 1)).size:
        raise bad_line(path, at[int(jump[0]) + 1], "the frame does not follow the one before. Export every frame.")
    rate = rate if rate is not None else rate_of(path, table[:, 1])
    xyz = table[:, 2:].reshape(len(table), len(names), 3).transpose(1, 0, 2)
    first = int(frame[0]) if len(frame) else 1
    return Trajectories(tuple(MarkerPath.measured(n, x) for n, x in zip(names, xyz, strict=True)), rate, first)


def csv_rows(path: Path | str) -> list[tuple[int, list[str]]]:
    """The lines of a CSV file that are not empty, each with its number, as cells."""
    reader = csv.reader(io.StringIO(read_text(path), newline=""))
    try:
        return [(reader.line_num, cells) for cells in reader if any(cells)]
    except csv.Error as error:
        raise bad_line(path, reader.line_num, f"{error}") from error


def markers(path: Path | str, heading: list[str]) -> list[str]:
    """Names of the markers, from the heading."""
    cells = [cell.strip() for cell in heading]
    names = [cell.removesuffix(AXES[0]) for cell in cells[2::3]]
    if cells != ["frame", "time_s", *(name + axis for name in names for axis in AXES)]:
        raise bad_line(path, 1, f"wanted frame, time_s, then NAME{', NAME'.join(AXES)} a marker; found {cells[:5]} …")
    return names


def rate_of(path: Path | str, time: NDArray[np.float64]) -> float:
    """Frames a second; see `read_trajectories_csv`."""
    span = time[-1] - time[0] if len(time) > 1 else np.nan
    if not 0 < span < np.inf:
        raise KinemarkError(f"{path} does not tell its rate: time_s does not rise. Say it with rate or --rate-hz.")
    return float(f"{(len(time) - 1) / span:.12g}")


def write_trajectories_csv(path: Path | str, trajectories: Trajectories) -> None:
    """Write markers in mm, every digit kept; frame and time count as C3D does, from 1 and 0 s.

    Raises:
        KinemarkError: the file cannot be written.
    """
    n, first = trajectories.n_frames, trajectories.first_frame
    flat = trajectories.xyz.transpose(1, 0, 2).reshape(n, -1)
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["frame", "time_s", *(name + axis for name in trajectories.names for axis in AXES)])
        for f, values in enumerate(flat.tolist(), first):
            writer.writerow([str(f), plain((f - 1) / trajectories.rate), *map(plain, values)])
