"""Masks as TOML: for each camera a table `[[camera]]` with `name`, `size` (px) and `polygons`, lists of corners [x, y].

Pixel (0, 0) is the centre of the top left pixel, so that a rectangle over pixels a … b goes from a − 0.5 to b + 0.5.
Masks of interlaced video are in the lines of a field.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from ..data import KinemarkError
from ..data.masks import Masks
from .files import replacing
from .number_text import read_text


def write_masks(path: Path | str, masks: Masks) -> None:
    """Write masks as TOML, a polygon a line.

    Raises:
        KinemarkError: the file cannot be written.
    """
    document = tomlkit.document()
    document.add(tomlkit.comment("What is masked in the images of each camera, px; see docs/how-to/masks.md."))
    document["camera"] = tables = tomlkit.aot()
    for name, size, polygons in zip(masks.cameras, masks.sizes, masks.polygons, strict=True):
        lines = tomlkit.array().multiline(True)
        lines.extend(polygon.tolist() for polygon in polygons)
        tables.append(tomlkit.item({"name": name, "size": size.tolist(), "polygons": lines}))
    with replacing(path) as beside:
        beside.write_text(tomlkit.dumps(document), encoding="utf-8")


def read_masks(path: Path | str) -> Masks:
    """The masks in a file.

    Raises:
        KinemarkError: the file is absent, no TOML, or a table is not as it should be; the message names it.
    """
    try:
        table = tomllib.loads(read_text(path))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise KinemarkError(f"{path} is no TOML: {error}. docs/how-to/masks.md shows a file of masks.") from None
    entries = table.get("camera", [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise KinemarkError(f"{path}: camera must be tables [[camera]] with name, size and polygons.")
    if unknown := sorted(set(table) - {"camera"}):
        raise KinemarkError(f"{path} has {', '.join(unknown)}, wanted tables [[camera]] alone. Correct the name.")
    parts = [_camera(path, k, entry) for k, entry in enumerate(entries)]
    try:
        sizes = np.array([size for _, size, _ in parts], np.int64).reshape(-1, 2)
        return Masks(tuple(name for name, _, _ in parts), sizes, tuple(tuple(polygons) for _, _, polygons in parts))
    except (ValueError, OverflowError) as error:
        raise KinemarkError(f"{path}: {error}. Correct it.") from None


def _camera(path: Path | str, k: int, entry: dict[str, Any]) -> tuple[str, list[int], list[Any]]:
    name, size, polygons = (entry.get(key) for key in ("name", "size", "polygons"))
    if not isinstance(name, str) or set(entry) - {"name", "size", "polygons"}:
        raise KinemarkError(f"{path}: camera {k + 1} has {', '.join(entry)}, wanted name, size and polygons.")
    if not (isinstance(size, list) and len(size) == 2 and all(type(n) is int and 0 < n < 1 << 16 for n in size)):
        raise KinemarkError(f"{path}: camera {name} has size = {size!r}, wanted [width, height] of its images, px.")
    if not isinstance(polygons, list) or not all(_is_polygon(polygon) for polygon in polygons):
        raise KinemarkError(
            f"{path}: polygons of camera {name} must be lists of three or more corners [x, y], px, finite numbers."
        )
    return name, size, polygons


def _is_polygon(value: Any) -> bool:
    corners = value if isinstance(value, list) else []
    return len(corners) >= 3 and all(
        isinstance(corner, list) and len(corner) == 2 and all(_is_number(x) for x in corner) for corner in corners
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e6
