"""The lenses of a session's cameras from images of a plane grid, where it has them (KISS 3.2)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...calibrate.lens.chessboard import find_corners
from ...calibrate.lens.dot_grid import order_grid, part_of_grid
from ...calibrate.lens.linearisation import GridView, LensFit, Linearisation, linearise
from ...data import Camera, Detections, Finding, KinemarkError, make_finding
from ...data.array_types import Floats
from ...data.progress import tell
from ...io.images import ImageSource
from ..recordings import open_cameras
from ..settings import LinearisationGrid, TargetRecording
from .task import Task

FEWEST_DOTS = 25
"""In a part of a grid that is used where the whole is not seen; chosen."""


class Lenses(NamedTuple):
    """The linearised cameras (C), or None; how straight rows of the grid are, name, before, after px; and findings."""

    cameras: tuple[Camera, ...] | None = None
    straight: tuple[tuple[str, float, float], ...] = ()
    findings: tuple[Finding, ...] = ()


def lenses_of(task: Task) -> Lenses:
    """The lenses by the session's `linearisation`; none where it has no such table.

    Raises:
        KinemarkError: a camera in none of whose images the grid is found, or whose lens does not follow from them.
    """
    way = task.settings.calibration.linearisation
    if way is None:
        return Lenses()
    sources = open_cameras(task.root, task.settings, way.images, task.names)
    fits, findings = [], []
    found = _dots(task, way) if way.pattern == "dots" else None
    for c, (name, source) in enumerate(sources.items()):
        views, failed = _views(way, source, found, c)
        if not views:
            raise KinemarkError(f"Camera {name}: the grid is in none of its images. {failed[0][1]}")
        findings += [make_finding(kind, cameras=[name], reason=reason) for kind, reason in failed]
        fits.append(linearise(name, source.size, views, method=Linearisation(way.radial, way.tangential)))
        tell(c + 1, len(sources))
    return Lenses(tuple(f.camera for f in fits), tuple(map(_straight, fits)), tuple(findings))


def _straight(fit: LensFit) -> tuple[str, float, float]:
    return fit.camera.name, *fit.straightness


def _dots(task: Task, way: LinearisationGrid) -> list[Detections]:
    """The dots in the images of each camera; cameras may have different numbers of images."""
    found = []
    for name in task.names:
        one = task._replace(
            settings=task.settings.model_copy(
                update={"cameras": task.settings.cameras.model_copy(update={"names": (name,)})}
            )
        )
        seen = TargetRecording(images=way.images.replace("{camera}", name))
        found.append(
            one.recorded(seen, "linearise", masked=False).detections
        )  # the grid may hang before what is masked
    return found


def _views(
    way: LinearisationGrid, source: ImageSource, dots: list[Detections] | None, c: int
) -> tuple[list[GridView], list[tuple[str, str]]]:
    """The images of one camera in which the grid is found, and the kind of finding and reason of the others."""
    columns, rows = way.grid
    row, column = np.mgrid[:rows, :columns].astype(np.float64)
    xy = way.pitch_mm * np.stack([column, row], -1).reshape(-1, 2)
    views, failed = [], []
    for f, image in enumerate(frame for batch in source.batches(1) for frame in batch):
        try:
            if dots is None:
                uv, cov = find_corners(image, columns=columns, rows=rows).reshape(-1, 2), None
            else:
                uv, cov = _ordered(dots[c], f, columns, rows)
            views.append(GridView(uv, xy, cov))
        except KinemarkError as error:
            part = None if dots is None else _part(dots[c], f, way.pitch_mm)
            views += [part] if part else []
            failed.append(("grid_partly_used" if part else "grid_image_unused", str(error)))
    return views, failed


def _part(dots: Detections, f: int, pitch: float) -> GridView | None:
    """Whatever part of a grid is in an image, if there is enough of it: a lens need not know which part it is."""
    here = np.flatnonzero(dots.valid & (dots.frame == f))
    try:
        index = part_of_grid(dots.uv[here])
    except KinemarkError:
        return None
    row, column = np.nonzero(index >= 0)
    if len(row) < FEWEST_DOTS:
        return None
    seen = here[index[row, column]]
    return GridView(dots.uv[seen], pitch * np.stack([column, row], -1).astype(np.float64), dots.cov[seen])


def _ordered(dots: Detections, f: int, columns: int, rows: int) -> tuple[Floats, Floats | None]:
    """The dots of one image as points of the grid (N, 2) px, NaN where missing, and their covariance."""
    here = np.arange(len(dots))[dots.rows(0, f)]
    here = here[dots.valid[here]]
    index = order_grid(dots.uv[here], columns=columns, rows=rows).reshape(-1)
    there = index >= 0
    uv, cov = np.full((len(index), 2), np.nan), np.full((len(index), 2, 2), np.nan)
    uv[there], cov[there] = dots.uv[here[index[there]]], dots.cov[here[index[there]]]
    return uv, cov if np.isfinite(cov[there]).all() else None
