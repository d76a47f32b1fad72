"""Control points: where they are in the world, and where an operator pointed at them in the images.

The CSV file has the columns `name, x_mm, y_mm, z_mm` and, for every camera, `{camera}_u_px, {camera}_v_px`; cells are
empty where a camera does not see the point.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import Detections, KinemarkError
from .number_text import read_text

SNAP = 8.0  # px; an operator points within this distance of a marker's centre; chosen


class DigitisedControlPoints(NamedTuple):
    """xyz (N, 3) mm; uv (C, N, 2) px, NaN unseen; cov (C, N, 2, 2) px², or None where nothing states it; names (N)."""

    xyz: NDArray[np.float64]
    uv: NDArray[np.float64]
    cov: NDArray[np.float64] | None
    names: tuple[str, ...] = ()


def read_control_points(path: Path, cameras: Sequence[str], seen: Detections | None = None) -> DigitisedControlPoints:
    """Control points of a CSV file; with detections, each place is moved to the nearest marker within `SNAP`.

    Raises:
        KinemarkError: a column is missing, a cell is no number, or no marker is where the operator pointed.
    """
    try:
        reader = csv.DictReader(read_text(path).splitlines())
        rows, heading = list(reader), reader.fieldnames or ()
    except csv.Error as error:
        raise KinemarkError(f"{path} is no CSV file: {error}. Save it again.") from error
    wanted = ["x_mm", "y_mm", "z_mm", *(f"{c}_{axis}_px" for c in cameras for axis in "uv")]
    if missing := [name for name in wanted if name not in heading]:
        raise KinemarkError(f"{path} lacks the columns {', '.join(missing)}. Add them; cells may be empty.")
    try:
        table = np.array([[float(row[name] or "nan") for name in wanted] for row in rows])
    except (TypeError, ValueError) as error:
        raise KinemarkError(f"{path} has a cell that is no number: {error}. Correct it.") from error
    if not len(table):
        raise KinemarkError(f"{path} has a heading and no control points. Add them, one a line.")
    xyz, uv = table[:, :3], table[:, 3:].reshape(len(table), len(cameras), 2).transpose(1, 0, 2)
    if not np.isfinite(xyz).all():
        raise KinemarkError(f"{path} has a control point without x, y and z. Fill them in.")
    names = tuple((row.get("name") or str(n + 1)).strip() for n, row in enumerate(rows))
    found = DigitisedControlPoints(xyz, uv, None) if seen is None else _snapped(path, xyz, uv, seen)
    return found._replace(names=names)


def _snapped(path: Path, xyz: NDArray[np.float64], uv: NDArray[np.float64], seen: Detections) -> DigitisedControlPoints:
    """The control points at the markers' centroids."""
    exact, cov = np.full(uv.shape, np.nan), np.full((*uv.shape, 2), np.nan)
    for c, camera in enumerate(seen.cameras):
        rows = seen.rows(c, 0)
        for n in np.flatnonzero(np.isfinite(uv[c]).all(1)):
            distance = np.linalg.norm(seen.uv[rows] - uv[c, n], axis=1)
            if not distance.min(initial=np.inf) <= SNAP:
                raise KinemarkError(
                    f"{path}: camera {camera} has no marker within {SNAP:g} px of point {n + 1} at {uv[c, n]}. "
                    "Correct the place, or empty its cells."
                )
            nearest = rows.start + int(distance.argmin())
            exact[c, n], cov[c, n] = seen.uv[nearest], seen.cov[nearest]
    return DigitisedControlPoints(xyz, exact, cov)
