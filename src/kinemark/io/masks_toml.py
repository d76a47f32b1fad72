"""Masks as TOML: for each camera a table `[[camera]]` with `name`, `size` (px) and `polygons`, lists of corners [x, y].

Pixel (0, 0) is the centre of the top left pixel, so that a rectangle over pixels a … b goes from a − 0.5 to b + 0.5.
Masks of interlaced video are in the lines of a field.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from ..data import KinemarkError
from ..data.masks import Masks
from .files import replacing
from .number_text import read_text
from .toml_text import toml_table


def write_masks(path: Path | str, masks: Masks) -> None:
    """Write masks as TOML, a polygon a line.

    Raises:
        KinemarkError: the file cannot be written.
    """
    document = tomlkit.document()
    document.add(tomlkit.comment("What is masked in the images of each camera, px; see docs/how-to/masks.md."))
    document["camera"] = tables = tomlkit.aot()
    for name, size, polygons in _of(masks):
        tables.append(_table(name, size, polygons))
    _write(path, document)


def change_masks(path: Path | str, masks: Masks) -> None:
    """Make a file of masks say these, where it says others; its comments, and what is the same, stay as they are.

    A camera that has no masks any more keeps its table, and a polygon that goes takes the comment of its line with it.
    A file that is not there yet is written.

    Raises:
        KinemarkError: the file is no file of masks, or cannot be written.
    """
    if not Path(path).is_file():
        write_masks(path, masks)
        return
    read_masks(path)  # tells what is wrong with it
    document = tomlkit.parse(read_text(path))
    if not document.get("camera"):
        document["camera"] = tomlkit.aot()
    tables: Any = document["camera"]
    there = {str(table["name"]): table for table in tables}
    wanted = {name: (size, polygons) for name, size, polygons in _of(masks)}
    for name, (size, polygons) in wanted.items():
        if name not in there:
            tables.append(_table(name, size, polygons))
            continue
        if there[name]["size"] != size:
            there[name]["size"] = size
        _change(there[name], polygons)
    for name in there.keys() - wanted.keys():
        _change(there[name], [])
    _write(path, document)


def _of(masks: Masks) -> list[tuple[str, list[int], list[Any]]]:
    return [
        (name, size.tolist(), [polygon.tolist() for polygon in polygons])
        for name, size, polygons in zip(masks.cameras, masks.sizes, masks.polygons, strict=True)
    ]


def _table(name: str, size: list[int], polygons: list[Any]) -> Any:
    lines = tomlkit.array().multiline(True)
    lines.extend(polygons)
    return tomlkit.item({"name": name, "size": size, "polygons": lines})


def _change(table: Any, polygons: list[Any]) -> None:
    """The polygons of a table: those that go are taken out, those that come stand last, in their order."""
    lines, left = table["polygons"], list(polygons)
    for k in range(len(lines) - 1, -1, -1):
        if lines[k].unwrap() in left:
            left.remove(lines[k].unwrap())
        else:
            del lines[k]
    for polygon in left:
        lines.append(polygon)


def _write(path: Path | str, document: tomlkit.TOMLDocument) -> None:
    with replacing(path) as beside:
        beside.write_bytes(tomlkit.dumps(document).encode())  # its ends of lines are the document's


def read_masks(path: Path | str) -> Masks:
    """The masks in a file.

    Raises:
        KinemarkError: the file is absent, no TOML, or a table is not as it should be; the message names it.
    """
    table = toml_table(read_text(path), str(path), advice="docs/how-to/masks.md shows a file of masks.")
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
