"""Calibration targets as they are found in a session's images, to be looked at beside the calibration.

Rods, a grid and a wand are recognised as a calibration does it, each image by itself (the wand with those about it, by
which its ends agree). The L-frame is where the last calibration has it: over its image, it shows whether that is right.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..calibrate import order_grid, recognise_control_frame, wand_points
from ..calibrate.lens.chessboard import find_corners
from ..data import Detections, KinemarkError, Rig
from ..data.array_types import Floats, GreyLevels
from ..detect import Centroids
from ..digitise import find_markers
from ..geometry import project_all
from ..io.images import ImageSource
from ..io.rods_toml import read_rods
from .recordings import methods_of, open_cameras
from .settings import LinearisationGrid, Settings

TOGETHER = 40
"""Images in which a wand is recognised together; chosen: its ends are told apart by 16 that two cameras share."""
KINDS = ("control_frame", "wand", "l_frame", "linearisation")
"""Tables of `[calibration]` whose images show a target."""


class FoundTarget(NamedTuple):
    """A target in an image.

    Attributes:
        size: width and height, px. frames: images of the camera.
        names: (n) of its markers. uv: (n, 2) px. lines: pairs of markers that are joined.
        spots: (m, 2) px all markers in the image. words: why it is not found, else what is.
    """

    size: tuple[int, int]
    frames: int
    names: tuple[str, ...]
    uv: Floats
    lines: tuple[tuple[int, int], ...]
    spots: Floats
    words: str


def targets_of(settings: Settings) -> tuple[str, ...]:
    """The targets of a session that have images."""
    found = ((kind, getattr(settings.calibration, kind)) for kind in KINDS)
    return tuple(kind for kind, table in found if table is not None and table.images is not None)


def target_image(root: Path, settings: Settings, kind: str, camera: str, frame: int) -> GreyLevels:
    """The image (H, W); raises a KinemarkError where there is no such target, camera or frame."""
    return _images(_source(root, settings, kind, camera), frame, 1)[0]


def found_target(root: Path, settings: Settings, kind: str, camera: str, frame: int, rig: Rig | None) -> FoundTarget:
    """A target in a camera's image `frame`, counted from 1.

    Args:
        root: the session's folder. settings: of it. kind: one of `targets_of`.
        camera: its name. rig: the last calibration, for the L-frame.

    Raises:
        KinemarkError: there is no such target, camera or frame.
    """
    source = _source(root, settings, kind, camera)
    image, method = _images(source, frame, 1)[0], _method(settings, camera)
    spots = find_markers(image, method=method).uv
    found = FoundTarget((image.shape[1], image.shape[0]), source.n_frames, (), np.zeros((0, 2)), (), spots, "")
    try:
        names, uv, lines = _recognised(root, settings, kind, camera, frame, rig, image, spots)
    except KinemarkError as error:
        return found._replace(words=str(error))
    kept = np.flatnonzero(np.isfinite(uv).all(1))
    at = {int(k): n for n, k in enumerate(kept)}
    joined = tuple((at[a], at[b]) for a, b in lines if a in at and b in at)
    words = f"{len(kept)} of {len(uv)} markers are found."
    return found._replace(names=tuple(names[k] for k in kept), uv=uv[kept], lines=joined, words=words)


def _recognised(
    root: Path,
    settings: Settings,
    kind: str,
    camera: str,
    frame: int,
    rig: Rig | None,
    image: GreyLevels,
    spots: Floats,
) -> tuple[list[str], Floats, list[tuple[int, int]]]:
    """Names (n), places (n, 2) px, NaN where not found, and which are joined."""
    way: Any = getattr(settings.calibration, kind)
    if kind == "control_frame":
        rods = read_rods(root / way.rods)
        uv = recognise_control_frame(spots, rods)
        names = [f"{rod}{k + 1}" for rod in rods.names for k in range(uv.shape[1])]
        present = rods.present.reshape(-1)
        return names, uv.reshape(-1, 2), [(a, b) for a, b in _rows(*uv.shape[:2]) if present[b]]
    if kind == "wand":
        uv = _wand(root, settings, frame)[settings.cameras.names.index(camera)]
        return [str(k + 1) for k in range(len(uv))], uv, _rows(1, len(uv))
    if kind == "linearisation":
        return _grid(way, image, spots)
    if rig is None or camera not in rig.names:
        raise KinemarkError("The L-frame is shown where the calibration puts it: calibrate the cameras first.")
    long, short = way.arms_mm
    xyz = np.array([[long, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, short, 0.0]]) + np.array([0.0, 0.0, way.height_mm])
    return ["X", "corner", "Y"], project_all(rig.select([camera]), xyz)[0], _rows(1, 3)


def _grid(way: LinearisationGrid, image: GreyLevels, spots: Floats) -> tuple[list[str], Floats, list[tuple[int, int]]]:
    columns, rows = way.grid
    if way.pattern == "dots":
        index = order_grid(spots, columns=columns, rows=rows)
        uv = np.where(index[..., None] >= 0, spots[index], np.nan)
    else:
        uv = find_corners(image, columns=columns, rows=rows)
    return [""] * (rows * columns), uv.reshape(-1, 2), _rows(rows, columns)


def _rows(rows: int, columns: int) -> list[tuple[int, int]]:
    """Neighbours in each row."""
    return [pair for row in range(rows) for pair in pairwise(range(row * columns, (row + 1) * columns))]


def _wand(root: Path, settings: Settings, frame: int) -> Floats:
    """(C, K, 2) px in a frame, by all cameras and frames about it."""
    names, way = settings.cameras.names, settings.calibration.wand
    assert way is not None
    sources = [_source(root, settings, "wand", name) for name in names]
    first = max(1, min(frame, min(source.n_frames for source in sources) - TOGETHER + 1))
    seen = [
        [find_markers(one, method=_method(settings, name)).uv for one in _images(source, first, TOGETHER)]
        for name, source in zip(names, sources, strict=True)
    ]
    n = min(map(len, seen))
    counts = [[len(uv) for uv in own[:n]] for own in seen]
    uv = np.concatenate([one for own in seen for one in own[:n]]).reshape(-1, 2)
    found, _ = wand_points(Detections.build(names, settings.rate_hz or 1.0, counts, uv), lengths=way.lengths_mm)
    return np.asarray(found[:, frame - first])


def _source(root: Path, settings: Settings, kind: str, camera: str) -> ImageSource:
    if kind not in targets_of(settings) or camera not in settings.cameras.names:
        raise KinemarkError(f"There is no image of {kind} by a camera {camera}. Look at the list again.")
    way: Any = getattr(settings.calibration, kind)
    return open_cameras(root, settings, way.images, [camera])[camera]


def _images(source: ImageSource, frame: int, n: int) -> list[GreyLevels]:
    """Up to n images from a frame on."""
    if not 1 <= frame <= source.n_frames:
        raise KinemarkError(f"There is no frame {frame}, but 1 to {source.n_frames}.")
    last = min(source.n_frames, frame - 1 + n)
    images: list[NDArray[Any]] = list(source.frames_at(np.arange(frame - 1, last)))
    return images


def _method(settings: Settings, camera: str) -> Centroids:
    own = methods_of(settings, settings.cameras.names).get(camera, settings.detect)
    return own if isinstance(own, Centroids) else Centroids()
