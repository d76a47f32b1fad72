"""Trajectories as CSV: `frame, time_s`, then `NAME_x_mm, NAME_y_mm, NAME_z_mm` a marker; an empty cell is a gap.

So is (0, 0, 0), as in TRC and C3D: other programs write it where a marker is missing.

Spreadsheets of countries that write 2,5 save such a table with semicolons or tabs and decimal commas: read too.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..data import KinemarkError, Trajectories, Trial
from ..data import MarkerTrajectory as MarkerPath
from ..data.array_types import Floats
from .c3d.points import distinct
from .cut_off import ends_its_line, without_cut_row
from .files import replacing
from .number_text import bad_line, numbers, plain, row_text, whole
from .text_rows import csv_rows
from .trc import OFF_ORIGIN

AXES = ("_x_mm", "_y_mm", "_z_mm")
UNEVEN, ROUNDED = 1.5, 0.01
"""A step of time above UNEVEN times the mean step and ROUNDED s is a jump; chosen, times are rounded to 0.01 s."""


def read_trajectories_csv(path: Path | str, *, rate: float | None = None, partial: bool = False) -> Trajectories:
    """Markers in mm from a CSV file.

    Args:
        path: the file.
        rate: Hz; without it, frames over time of the first and last row, to twelve digits.
        partial: read what there is of a file that is cut off within a row.

    Raises:
        KinemarkError: the file is absent, malformed or cut off, a frame is left out, or nothing tells the rate: the
            times do not rise, or jump.
    """
    return read_csv_trial(path, rate=rate, partial=partial).trajectories


def read_csv_trial(path: Path | str, *, rate: float | None = None, partial: bool = False) -> Trial:
    """As `read_trajectories_csv`, with its errors; what was odd in the file stands in the notes of the trial."""
    rows = csv_rows(path)
    if not rows:
        raise KinemarkError(f"{path} has no header line. Check the path.")
    names = markers(path, rows[0][1])
    wide = 2 + 3 * len(names)
    body, notes = without_cut_row(path, rows[1:], wide, ends=ends_its_line(path), partial=partial)
    at = [k for k, _ in body]
    table = numbers(path, at, (cells for _, cells in body), wide)
    frame = whole(path, at, table[:, 0], "frame")
    if (jump := np.flatnonzero(np.diff(frame) != 1)).size:
        raise bad_line(path, at[int(jump[0]) + 1], "the frame does not follow the one before. Export every frame.")
    rate = rate if rate is not None else rate_of(path, table[:, 1], at)
    xyz = table[:, 2:].reshape(len(table), len(names), 3).transpose(1, 0, 2)
    first = int(frame[0]) if len(frame) else 1
    zero = (xyz == 0).all(2)
    xyz[zero] = np.nan
    odd = (f"(0, 0, 0) is taken for missing; samples: {zero.sum()}",) if zero.any() else ()
    paths = (MarkerPath.measured(n, x) for n, x in zip(distinct(names, len(names), "*"), xyz, strict=True))
    return Trial(Path(path).stem, Trajectories(tuple(paths), rate, first), notes=(*notes, *odd))


def markers(path: Path | str, heading: list[str]) -> list[str]:
    """Names of the markers, from the heading."""
    cells = [cell.strip() for cell in heading]
    names = [cell.removesuffix(AXES[0]) for cell in cells[2::3]]
    if cells != ["frame", "time_s", *(name + axis for name in names for axis in AXES)]:
        raise bad_line(path, 1, f"wanted frame, time_s, then NAME{', NAME'.join(AXES)} a marker; found {cells[:5]} …")
    return names


def rate_of(path: Path | str, time: Floats, lines: Sequence[int]) -> float:
    """Frames a second of times (F) s that stand in these lines; see `read_trajectories_csv`."""
    if not len(time):
        raise KinemarkError(f"{path} has a heading and no frames. Export it again.")
    span = time[-1] - time[0] if len(time) > 1 else np.nan
    if not 0 < span < np.inf:
        raise KinemarkError(
            f"{path} does not tell its rate: time_s does not rise. Say it with --rate-hz (in Python: rate)."
        )
    step = np.diff(time)
    if (jump := np.flatnonzero(step > max(UNEVEN * span / len(step), ROUNDED))).size:
        k = int(jump[0])
        what = f"time_s goes on by {step[k]:g} s, by {np.median(step):g} s elsewhere. If no frame is missing: --rate-hz"
        raise bad_line(path, lines[k + 1], what)
    return float(f"{(len(time) - 1) / span:.12g}")


def write_trajectories_csv(path: Path | str, trajectories: Trajectories) -> None:
    """Write markers in mm, every digit kept, a sample at the very origin 10⁻⁶ mm off it.

    Frame and time count as C3D does, from 1 and 0 s.

    Raises:
        KinemarkError: the file cannot be written.
    """
    n, first = trajectories.n_frames, trajectories.first_frame
    xyz = trajectories.xyz.transpose(1, 0, 2)
    xyz[(xyz == 0).all(2)] = OFF_ORIGIN
    flat = xyz.reshape(n, -1)
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        heading = ["frame", "time_s", *(name + axis for name in trajectories.names for axis in AXES)]
        csv.writer(file, lineterminator="\n").writerow(heading)
        file.writelines(
            f"{f},{plain((f - 1) / trajectories.rate)},{row_text(values.tolist(), ',')}\n"
            for f, values in enumerate(flat, first)
        )
