"""CSV files of DLTdv and easyWand (Hedrick 2008; Theriault et al. 2014): DLT coefficients and digitised points.

Coefficients: eleven rows, a column a camera, no heading. Points: a heading, then a row a frame; `xypts.csv` has the
columns `pt1_cam1_X, pt1_cam1_Y, pt1_cam2_X, …, pt2_cam1_X, …`, `xyzpts.csv` has `pt1_X, pt1_Y, pt1_Z, pt2_X, …`.
Numbers stay as they are: units and the corner from which pixels count are the file's.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..data import KinemarkError
from ..data.array_types import Floats
from .files import write_text
from .number_text import bad_line, numbers, plain
from .text_rows import csv_rows

N_DLT = 11  # coefficients of a camera; of the format (KISS eq. 7)
MOST_CAMERAS = 1024  # in a file; chosen, lest a broken file take memory


def read_dlt_csv(path: Path | str) -> Floats:
    """(C, 11) DLT coefficients, a row a camera, in the file's units.

    Raises:
        KinemarkError: the file is absent or has not eleven rows of numbers.
    """
    rows = csv_rows(path)
    if len(rows) != N_DLT or not 0 < len(rows[0][1]) <= MOST_CAMERAS:
        raise KinemarkError(f"{path} has {len(rows)} rows, wanted {N_DLT} coefficients with a column a camera.")
    table = numbers(path, [k for k, _ in rows], (cells for _, cells in rows), len(rows[0][1]))
    if not np.isfinite(table).all():
        k = int(np.flatnonzero(~np.isfinite(table).all(1))[0])
        raise bad_line(path, rows[k][0], "a coefficient is missing. Calibrate that camera, or remove its column.")
    return np.ascontiguousarray(table.T)


def write_dlt_csv(path: Path | str, L: ArrayLike) -> None:
    """Write DLT coefficients (C, 11), every digit kept.

    Raises:
        ValueError: L has another shape or is not finite.
        KinemarkError: the file cannot be written.
    """
    L = np.asarray(L, np.float64)
    if L.ndim != 2 or L.shape[1] != N_DLT or not len(L) or not np.isfinite(L).all():
        raise ValueError(f"L has shape {L.shape}, wanted (cameras, {N_DLT}), all finite")
    write_text(path, "".join(",".join(map(plain, row)) + "\n" for row in L.T.tolist()))


def read_dltdv_xy(path: Path | str) -> Floats:
    """(C, P, F, 2) digitised pixels of P points in C cameras over F frames; NaN where a point was not digitised.

    Raises:
        KinemarkError: the file is absent or its columns are not those of DLTdv.
    """
    heading, table = points(path)
    names = [re.fullmatch(r"pt(\d{1,6})_cam(\d{1,4})_([XY])", cell) for cell in heading]
    n_cameras = max((int(m[2]) for m in names if m), default=0)
    n_points = len(heading) // max(2 * n_cameras, 1)
    wanted = [f"pt{p + 1}_cam{c + 1}_{a}" for p in range(n_points) for c in range(n_cameras) for a in "XY"]
    if heading != wanted or not wanted:
        raise bad_line(path, 1, f"wanted pt1_cam1_X, pt1_cam1_Y, pt1_cam2_X, …; found {heading[:4]} …")
    return table.reshape(-1, n_points, n_cameras, 2).transpose(2, 1, 0, 3)


def read_dltdv_xyz(path: Path | str) -> Floats:
    """(P, F, 3) points over F frames in the unit of the calibration, mostly m; NaN where missing.

    Raises:
        KinemarkError: the file is absent or its columns are not those of DLTdv.
    """
    heading, table = points(path)
    n_points = len(heading) // 3
    wanted = [f"pt{p + 1}_{a}" for p in range(n_points) for a in "XYZ"]
    if heading != wanted or not wanted:
        raise bad_line(path, 1, f"wanted pt1_X, pt1_Y, pt1_Z, pt2_X, …; found {heading[:4]} …")
    return table.reshape(-1, n_points, 3).transpose(1, 0, 2)


def points(path: Path | str) -> tuple[list[str], Floats]:
    """The heading and the numbers below it."""
    rows = csv_rows(path)
    if not rows:
        raise KinemarkError(f"{path} has no heading. Check the path.")
    heading = [cell.strip() for cell in rows[0][1]]
    return heading, numbers(path, [k for k, _ in rows[1:]], (cells for _, cells in rows[1:]), len(heading))
