"""What was chosen for detection, written into `session.toml` and the file of masks; every comment there stays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...data.array_types import Floats
from ...data.masks import Masks
from ...io.masks_toml import change_masks
from ..session_changes import parsed, table_in, write_session
from ..session_name import FILE
from .open_detection import Draft, OpenDetection

MASKS = "masks.toml"
"""What a file of masks is called where the session has none yet."""


def apply(opened: OpenDetection, draft: Draft) -> None:
    """Write a draft; all or nothing of the session file.

    Raises:
        KinemarkError: the file would not be understood then, or cannot be written.
    """
    opened.methods(draft)
    root = opened.session.root
    file = root / FILE
    document = parsed(file)
    _detect(document, draft)
    masks = _masks_file(opened) if draft.masks else None
    if masks is not None:
        _write_masks(masks, opened, draft.masks)
        table_in(document, "masks")["file"] = (
            masks.relative_to(root).as_posix() if masks.is_relative_to(root) else str(masks)
        )
    write_session(file, document)


def _detect(document: Any, draft: Draft) -> None:
    """`[detect]` and its cameras."""
    if not draft.every and not draft.cameras:
        return
    detect = table_in(document, "detect")
    _set(detect, draft.every)
    for name, own in draft.cameras.items():
        cameras = table_in(detect, "cameras", within=True)
        camera = table_in(cameras, name)
        _set(camera, own)
        if not len(camera):
            cameras.remove(name)
        if not len(cameras):
            detect.remove("cameras")


def _set(table: Any, values: Mapping[str, Any]) -> None:
    """Values into a table, a key's comment kept; None takes the key out."""
    for key, value in values.items():
        if value is None:
            if key in table:
                table.remove(key)
        else:
            table[key] = _plain(value)


def _plain(value: Any) -> Any:
    """A number as people write it."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _masks_file(opened: OpenDetection) -> Path:
    """That of `[masks]`, or one that is not there yet."""
    way, root = opened.session.settings.masks, opened.session.root
    if way is not None and way.file is not None:
        return root / way.file
    names = (MASKS, *(f"masks-{k}.toml" for k in range(2, 1000)))
    return next(root / name for name in names if not (root / name).exists())


def _write_masks(file: Path, opened: OpenDetection, tried: Mapping[str, tuple[Floats, ...]]) -> None:
    """The masks of the file with those of the cameras named here in the place of theirs."""
    drawn = opened.drawn()
    polygons = dict(zip(drawn.cameras, drawn.polygons, strict=True)) if drawn else {}
    sizes = dict(zip(drawn.cameras, drawn.sizes.tolist(), strict=True)) if drawn else {}
    polygons |= {name: tuple(of) for name, of in tried.items()}
    sizes |= {name: list(opened.size(name)) for name in tried}
    names = tuple(name for name in polygons if polygons[name])
    change_masks(
        file, Masks(names, np.array([sizes[n] for n in names]).reshape(-1, 2), tuple(polygons[n] for n in names))
    )
