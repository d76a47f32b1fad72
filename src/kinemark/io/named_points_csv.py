"""2D points with names, of other programs: one table of all cameras, or a file a camera.

A wide table has a row a frame and two columns for each marker and camera: `MARKER_CAMERA_X, MARKER_CAMERA_Y`, as DLTdv
writes them (`pt1_cam1_X`; Hedrick 2008), or `MARKER_CAMERA_u_px, MARKER_CAMERA_v_px`; a column `frame` may come first.
DeepLabCut (Mathis et al. 2018) writes a file a camera with three lines of headings, `scorer`, `bodyparts`, `coords`,
and `x, y, likelihood` for each body part. Numbers stay as they are: the corner from which pixels count is the file's.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from ..data import Detections, KinemarkError
from ..data.array_types import Floats
from .detections_csv import MARKER, NamedDetections, read_detections_csv, read_long
from .number_text import bad_line, numbers, read_head, separator, whole
from .text_rows import csv_rows

LIKELY = 0.6  # likelihood below which DeepLabCut's own plots leave a point out (its `pcutoff`); convention
DEEPLABCUT = ("scorer", "bodyparts", "coords")
AXIS = re.compile(r"(?P<stem>.+?)_(?P<axis>X|Y|u_px|v_px|u|v)")
SIDES = {"X": 0, "Y": 1, "u_px": 0, "v_px": 1, "u": 0, "v": 1}
MOST_COLUMNS = 100_000  # of a heading that is looked at; chosen, lest a broken file take memory

Layout = Literal["long", "wide", "deeplabcut"]


class Columns(NamedTuple):
    """The columns of a wide table: (camera, marker, axis) of each, and how many come before them."""

    place: list[tuple[str, str, int]]
    before: int


def layout_of(path: Path | str) -> Layout | None:
    """How a CSV file names its 2D points; None where it does not name any.

    Raises:
        KinemarkError: the file is absent or no text.
    """
    heads = _heads(path)
    cells = heads[0] if heads else []
    if heads and cells[0].lower() == "scorer":
        return "deeplabcut"
    if MARKER in cells and ("camera" in cells or "frame" in cells):
        return "long"
    own = [cell for cell in cells[:MOST_COLUMNS] if cell not in ("frame", "Frame")]
    wide = [AXIS.fullmatch(cell) for cell in own]
    fits = own and all(match is not None and "_" in match["stem"] for match in wide)
    return "wide" if fits and "x_mm" not in cells else None


def _heads(path: Path | str) -> list[list[str]]:
    """The first four lines as cells, without blanks."""
    lines = [*read_head(path).splitlines()[:4], *[""] * 4][:4]
    mark = separator(lines[0])
    return [[cell.strip().strip('"') for cell in line.split(mark)] for line in lines]


def read_named_detections(
    path: Path | str, *, rate: float, cameras: Sequence[str] | None = None, camera: str = "camera"
) -> NamedDetections:
    """2D points with the names of their markers, from any of the layouts.

    Args:
        path: the file.
        rate: frames a second, Hz; the file does not say it.
        cameras: names of the session's cameras, which tell a marker's name from a camera's in a wide table; without
            them the camera is what follows the last underscore.
        camera: of the file, for DeepLabCut, which does not say it.

    Raises:
        KinemarkError: the file is absent, names no markers, or a column is missing; the message has the line.
    """
    layout = layout_of(path)
    if layout == "long":
        return read_long(path, rate=rate)
    if layout == "wide":
        return _wide(path, rate, cameras)
    if layout == "deeplabcut":
        return _deeplabcut(path, rate, camera)
    raise bad_line(
        path, 1, "names no markers. Wanted camera, frame, marker, u_px, v_px; or MARKER_CAMERA_X, MARKER_CAMERA_Y of "
        "each marker and camera, as DLTdv writes; or DeepLabCut's scorer, bodyparts, coords."
    )  # fmt: skip


def detections_of_csv(path: Path | str, *, rate: float) -> Detections:
    """2D points of a CSV file in any layout; names are left aside."""
    if layout_of(path) in ("wide", "deeplabcut"):
        return read_named_detections(path, rate=rate).detections
    return read_detections_csv(path, rate=rate)


def read_camera_files(paths: Mapping[str, Path], *, rate: float) -> NamedDetections:
    """Named points of one file a camera, by the camera's name, in that order; markers are those of any of them.

    Raises:
        KinemarkError: a file cannot be read, or the files have different numbers of frames.
    """
    found = {name: read_named_detections(path, rate=rate, camera=name) for name, path in paths.items()}
    lengths = {name: one.detections.n_frames for name, one in found.items()}
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{name} {n}" for name, n in lengths.items())
        raise KinemarkError(f"Cameras have different numbers of frames: {said}. Cut the files to the same frames.")
    if wrong := [name for name, one in found.items() if one.detections.cameras != (name,)]:
        raise KinemarkError(f"{paths[wrong[0]]} has several cameras. Name it without {{camera}}.")
    names = tuple(dict.fromkeys(marker for one in found.values() for marker in one.names))
    n_frames = max(lengths.values(), default=0)
    uv = np.full((len(found), len(names), n_frames, 2), np.nan)
    for c, one in enumerate(found.values()):
        at = np.array([names.index(marker) for marker in one.names], np.int64)[one.marker]
        uv[c, at, one.detections.frame] = one.detections.uv
    return _built(tuple(found), names, uv, rate)


def _built(cameras: tuple[str, ...], names: tuple[str, ...], uv: Floats, rate: float) -> NamedDetections:
    """Places (C, M, F, 2) px, NaN where not seen, as rows of camera, frame and marker."""
    places = uv.transpose(0, 2, 1, 3)  # (C, F, M, 2)
    seen = np.isfinite(places).all(-1)
    marker = np.broadcast_to(np.arange(len(names)), seen.shape)[seen]
    return NamedDetections(Detections.build(cameras, rate, seen.sum(2), places[seen]), marker, names)


def _wide(path: Path | str, rate: float, cameras: Sequence[str] | None) -> NamedDetections:
    """A row a frame, two columns for each marker and camera."""
    rows = csv_rows(path)
    heading = [cell.strip() for cell in rows[0][1]]
    columns = _columns(path, heading, cameras)
    lines = [k for k, _ in rows[1:]]
    table = numbers(path, lines, (cells for _, cells in rows[1:]), len(heading))
    names = tuple(dict.fromkeys(marker for _, marker, _ in columns.place))
    seeing = tuple(dict.fromkeys(camera for camera, _, _ in columns.place))
    frame = whole(path, lines, table[:, 0], "frame") if columns.before else np.arange(len(table))
    if len(frame) and (np.diff(frame) != 1).any():
        at = int(np.flatnonzero(np.diff(frame) != 1)[0]) + 1
        raise bad_line(path, lines[at], "the frame does not follow the one before. Export every frame.")
    uv = np.full((len(seeing), len(names), len(table), 2), np.nan)
    for k, (camera, marker, axis) in enumerate(columns.place, columns.before):
        uv[seeing.index(camera), names.index(marker), :, axis] = table[:, k]
    return _built(seeing, names, uv, rate)


def _columns(path: Path | str, heading: list[str], cameras: Sequence[str] | None) -> Columns:
    """Which camera, marker and axis each column is.

    Raises:
        KinemarkError: a column is no such, or the other axis of a marker is missing.
    """
    before = int(heading[0].lower() == "frame")
    place: list[tuple[str, str, int]] = []
    for cell in heading[before:]:
        match = AXIS.fullmatch(cell)
        if match is None:
            raise bad_line(path, 1, f"column {cell!r} is no MARKER_CAMERA_X or MARKER_CAMERA_Y. Remove it.")
        stem = match["stem"]
        camera = next((name for name in cameras or () if stem.endswith(f"_{name}")), stem.rpartition("_")[2])
        place.append((camera, stem.removesuffix(f"_{camera}"), SIDES[match["axis"]]))
    for camera, marker, axis in place:
        if place.count((camera, marker, axis)) > 1 or (camera, marker, 1 - axis) not in place:
            raise bad_line(
                path, 1, f"marker {marker!r} of camera {camera!r} wants one X and one Y column. Correct them."
            )
    return Columns(place, before)


def _deeplabcut(path: Path | str, rate: float, camera: str) -> NamedDetections:
    """One camera's points, of those that are likely."""
    rows = csv_rows(path)
    heads = {cells[0].strip().lower(): [cell.strip() for cell in cells[1:]] for _, cells in rows[:4]}
    n_heads = 1 + list(heads).index("coords") if "coords" in heads else 0
    if missing := [name for name in DEEPLABCUT if name not in heads]:
        raise bad_line(
            path, 1, f"has no line {missing[0]!r}; DeepLabCut writes scorer, bodyparts, coords. Export it again."
        )
    several = len(set(heads.get("individuals", ()))) > 1
    part = [
        f"{who}_{name}" if several else name
        for who, name in zip(heads.get("individuals", heads["bodyparts"]), heads["bodyparts"], strict=True)
    ]
    names = tuple(dict.fromkeys(part))
    column = {key: k for k, key in enumerate(zip(part, heads["coords"], strict=True), 1)}
    for name in names:
        if missing := [axis for axis in "xy" if (name, axis) not in column]:
            raise bad_line(path, n_heads, f"body part {name!r} has no column {missing[0]!r}. Export it again.")
    body = rows[n_heads:]
    table = numbers(path, [k for k, _ in body], (cells for _, cells in body), len(heads["coords"]) + 1)
    uv = np.stack([table[:, [column[name, "x"], column[name, "y"]]] for name in names])
    likely = np.stack([table[:, column[name, "likelihood"]] if (name, "likelihood") in column else np.ones(len(table))
                       for name in names])  # fmt: skip
    return _built((camera,), names, np.where((likely >= LIKELY)[..., None], uv, np.nan)[None], rate)
