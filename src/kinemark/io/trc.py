"""TRC, the tab-separated marker file of Motion Analysis and OpenSim.

line 1  PathFileType  4  (X/Y/Z)  name
line 2  names of the values in line 3: DataRate, CameraRate, NumFrames, NumMarkers, Units, …
line 4  Frame#  Time  NAME  ·  ·  NAME  ·  ·  …
line 5  ·  ·  X1  Y1  Z1  X2  …
then, mostly after an empty line, a row a frame; an empty cell is a gap
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..data import KinemarkError, Trajectories
from ..data import MarkerTrajectory as MarkerPath
from .files import replacing
from .number_text import bad_line, numbers, plain, read_text, whole
from .units import USUAL, mm_per

HEADINGS = ("DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units")
ORIGINAL = ("OrigDataRate", "OrigDataStartFrame", "OrigNumFrames")


def read_trc(path: Path | str) -> Trajectories:
    """Markers of a TRC file in mm, on the axes of the file; empty or NaN samples are missing.

    Raises:
        KinemarkError: the file is absent, empty, no TRC, in an unknown unit, or shorter than its header says.
    """
    lines = read_text(path).splitlines()
    if len(lines) < 5 or not lines[0].startswith("PathFileType"):
        raise KinemarkError(
            f"{path} is not a TRC file: its first line does not begin with PathFileType. Check the path."
        )
    rate, n_frames, n_markers, scale = header(path, lines)
    names = [cell.strip() for cell in lines[3].split("\t")[2:]]
    names = [name for name in names if name]
    if len(names) != n_markers:
        raise bad_line(path, 4, f"has {len(names)} markers, line 3 says {n_markers}. Export the file again.")
    rows = [(k, line.split("\t")) for k, line in enumerate(lines[5:], 6) if line.strip()]
    at = [k for k, _ in rows]
    table = numbers(path, at, [cells for _, cells in rows], 2 + 3 * n_markers)
    if len(table) != n_frames:
        raise KinemarkError(f"{path} has {len(table)} frames, its header says {n_frames}. Copy or export it again.")
    frame = whole(path, at, table[:, 0], "the frame")
    if (jump := np.flatnonzero(np.diff(frame) != 1)).size:
        raise bad_line(path, at[int(jump[0]) + 1], "the frame does not follow the one before. Export every frame.")
    xyz = table[:, 2:].reshape(n_frames, n_markers, 3).transpose(1, 0, 2) * scale
    first = int(frame[0]) if n_frames else 1
    return Trajectories(tuple(MarkerPath.measured(n, x) for n, x in zip(names, xyz, strict=True)), rate, first)


def header(path: Path | str, lines: list[str]) -> tuple[float, int, int, float]:
    """Rate in Hz, frames, markers and the factor to mm, as lines 2 and 3 say."""
    values = dict(zip(lines[1].split("\t"), (cell.strip() for cell in lines[2].split("\t")), strict=False))
    if missing := [name for name in HEADINGS if not values.get(name)]:
        raise bad_line(path, 3, f"does not say {', '.join(missing)}")
    if (mm := mm_per(values["Units"])) is None:
        raise bad_line(path, 3, f"Units is {values['Units']!r}, wanted {USUAL}")
    try:
        rate, n_frames, n_markers = float(values["DataRate"]), int(values["NumFrames"]), int(values["NumMarkers"])
    except ValueError as error:
        raise bad_line(path, 3, f"{error}") from error
    if not 0 < rate < math.inf:
        raise bad_line(path, 3, f"DataRate is {rate}, wanted a positive number")
    return rate, n_frames, n_markers, mm


def write_trc(path: Path | str, trajectories: Trajectories) -> None:
    """Write markers in mm, every digit kept; covariance, residual and origin have no place in a TRC file.

    Raises:
        ValueError: a marker's name is empty or has a tab or line break.
        KinemarkError: the file cannot be written.
    """
    path = Path(path)
    names = trajectories.names
    if bad := [name for name in names if not name.strip() or len(f"{name}.".splitlines()) > 1 or "\t" in name]:
        raise ValueError(f"marker names must be without tabs and line breaks and not empty, found {bad}")
    n, rate, first = trajectories.n_frames, plain(trajectories.rate), trajectories.first_frame
    rows = [
        ["PathFileType", "4", "(X/Y/Z)", path.name],
        [*HEADINGS, *ORIGINAL],
        [rate, rate, str(n), str(len(names)), "mm", rate, str(first), str(n)],
        ["Frame#", "Time", *(cell for name in names for cell in (name, "", ""))],
        ["", "", *(f"{axis}{m + 1}" for m in range(len(names)) for axis in "XYZ")],
        [],
    ]
    flat = trajectories.xyz.transpose(1, 0, 2).reshape(n, -1)
    for f, values in enumerate(flat.tolist(), first):
        rows.append([str(f), plain((f - 1) / trajectories.rate), *map(plain, values)])
    with replacing(path) as beside:
        beside.write_text("".join("\t".join(row) + "\n" for row in rows), encoding="utf-8", newline="\n")
