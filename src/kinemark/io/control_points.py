"""Control points: where they are in the world, and where an operator pointed at them in the images.

The CSV file has the columns `name, x_mm, y_mm, z_mm` and, for every camera, `{camera}_u_px, {camera}_v_px`; cells are
empty, or `nan`, where a camera does not see the point.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..data import Detections, KinemarkError
from ..data.array_types import Bools, Floats
from .csv_table import write_table
from .number_text import number
from .text_rows import csv_table

SNAP = 8.0  # px; an operator points within this distance of a marker's centre; chosen


class DigitisedControlPoints(NamedTuple):
    """xyz (N, 3) mm; uv (C, N, 2) px, NaN unseen; cov (C, N, 2, 2) px², or None where nothing states it; names (N)."""

    xyz: Floats
    uv: Floats
    cov: Floats | None
    names: tuple[str, ...] = ()


def read_control_points(path: Path, cameras: Sequence[str], seen: Detections | None = None) -> DigitisedControlPoints:
    """Control points of a CSV file; with detections, each place is moved to the nearest marker within `SNAP`.

    Raises:
        KinemarkError: a column is missing, a cell is no number, or no marker is where the operator pointed.
    """
    heading, rows = csv_table(path)
    wanted = ["x_mm", "y_mm", "z_mm", *(f"{c}_{axis}_px" for c in cameras for axis in "uv")]
    if missing := [name for name in wanted if name not in heading]:
        raise KinemarkError(f"{path} lacks the columns {', '.join(missing)}. Add them; cells may be empty.")
    try:
        table = np.array([[number(row[name]) for name in wanted] for row in rows])
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


def _snapped(path: Path, xyz: Floats, uv: Floats, seen: Detections) -> DigitisedControlPoints:
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


class PointedPoints(NamedTuple):
    """What an operator said of control points until now.

    names (N); xyz (N, 3) mm; cameras (C); uv (C, N, 2) px, NaN where not; asked (C, N) whether it was said where the
    camera sees the point, or that it does not.
    """

    names: tuple[str, ...]
    xyz: Floats
    cameras: tuple[str, ...]
    uv: Floats
    asked: Bools

    @classmethod
    def unseen(cls, names: Sequence[str], xyz: Floats) -> PointedPoints:
        """Points before there is a camera to point at them in."""
        n = len(names)
        return cls(tuple(names), xyz, (), np.empty((0, n, 2)), np.zeros((0, n), np.bool_))

    def said(self, camera: str, name: str, uv: tuple[float, float] | None, *, asked: bool = True) -> PointedPoints:
        """The same with one answer: a place, or None for not seen; `asked` False takes an answer back.

        Raises:
            KinemarkError: there is no such camera or point.
        """
        if camera not in self.cameras or name not in self.names:
            raise KinemarkError(f"There is no control point {name!r} in a camera {camera!r}. Look at the list again.")
        c, n = self.cameras.index(camera), self.names.index(name)
        places, asked_now = self.uv.copy(), self.asked.copy()
        places[c, n], asked_now[c, n] = np.nan if uv is None else uv, asked
        return self._replace(uv=places, asked=asked_now)


UNSEEN = "nan"
"""In a cell: the operator said that the camera does not see the point; an empty one was not asked yet."""


def read_pointed(path: Path, cameras: Sequence[str]) -> PointedPoints:
    """Control points of a CSV file that an operator is still pointing at: columns of cameras may be missing.

    Raises:
        KinemarkError: names or places are missing, a name comes twice, or a cell is no number.
    """
    _, rows = csv_table(path)
    wanted = [f"{c}_{axis}_px" for c in cameras for axis in "uv"]
    try:
        xyz = np.array([[number(row[f"{axis}_mm"]) for axis in "xyz"] for row in rows]).reshape(-1, 3)
        cells = np.array([[number(row.get(name, "")) for name in wanted] for row in rows])
    except (KeyError, TypeError, ValueError) as error:
        raise KinemarkError(f"{path} wants name, x_mm, y_mm and z_mm in numbers in each line: {error}.") from error
    names = tuple((row.get("name") or str(n + 1)).strip() for n, row in enumerate(rows))
    if not rows or len({*names}) < len(names) or not np.isfinite(xyz).all():
        raise KinemarkError(f"{path} wants control points with different names and places. Correct it.")
    uv = cells.reshape(len(rows), len(cameras), 2).transpose(1, 0, 2)
    asked = np.array([[bool((row.get(f"{c}_u_px") or "").strip()) for row in rows] for c in cameras], np.bool_)
    return PointedPoints(names, xyz, tuple(cameras), uv, asked.reshape(len(cameras), len(rows)))


def write_pointed(path: Path, points: PointedPoints) -> None:
    """Write control points as `read_control_points` and `read_pointed` read them, whole or not at all.

    Raises:
        KinemarkError: the file cannot be written.
    """
    heading = ["name", "x_mm", "y_mm", "z_mm", *(f"{c}_{axis}_px" for c in points.cameras for axis in "uv")]
    rows = []
    for n, name in enumerate(points.names):
        cells = [_cell(x, asked) for c, asked in enumerate(points.asked[:, n]) for x in points.uv[c, n]]
        rows.append([name, *(f"{x:.10g}" for x in points.xyz[n]), *cells])
    write_table(path, heading, rows)


def _cell(value: float, asked: bool) -> str:
    """A pixel, to a ten-thousandth."""
    return f"{value:.4f}" if np.isfinite(value) else UNSEEN if asked else ""
