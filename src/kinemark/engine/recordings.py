"""The recordings that a session names: images and videos of all cameras, and what is detected in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..data import Detections, KinemarkError
from ..data.array_types import Ints
from ..data.detections import NOT_ROWS
from ..data.masks import Masks as StaticMasks
from ..data.progress import tell
from ..detect import combined_masks, detect, learn_masks
from ..io.images import ImageSource, open_images
from ..io.masks_toml import read_masks
from ..io.named_points_csv import detections_of_csv
from ..io.records import load
from .keys import file_key
from .lost_images import check_no_image_lost
from .settings import Settings, TargetRecording, check_camera_names


class Recorded(NamedTuple):
    """What cameras saw: detections of them all, and the sizes (C, 2) of their images, px, 0 where unknown."""

    detections: Detections
    sizes: Ints


def open_cameras(
    root: Path, settings: Settings, pattern: str, names: Sequence[str], *, every: int = 1
) -> dict[str, ImageSource]:
    """The frames of each camera, one of so many, by a pattern with `{camera}` in it.

    Raises:
        KinemarkError: the pattern means one file for all cameras, or a camera has no usable images.
    """
    return _opened(root, settings.cameras.first_field, pattern, names, every)


def _opened(root: Path, first_field: Any, pattern: str, names: Sequence[str], every: int = 1) -> dict[str, ImageSource]:
    if "{camera}" not in pattern and len(names) > 1:
        raise KinemarkError(f"images = {pattern!r} has no {{camera}} in it: all cameras would be one. Put it in.")
    images = {}
    for name in names:
        try:
            path = root / pattern.replace("{camera}", name)
            images[name] = open_images(path, interlaced=first_field, every=every)
        except KinemarkError as error:
            raise KinemarkError(f"Camera {name!r} of [cameras] has no usable images: {error}") from error
    return images


def of_cameras(found: Detections, names: Sequence[str], file: Path) -> Detections | None:
    """Detections of cameras of these names, in their order; a table names no camera that saw nothing.

    None where another file lacks a camera, or a table names others, or fewer than two.
    """
    own = set(found.cameras)
    if set(names) <= own:
        return found.select(names)
    if file.suffix.lower() != ".csv" or not own <= set(names) or len(own) < 2:
        return None
    there = [name for name in names if name in own]
    part = found.select(there)
    counts = np.zeros((len(names), found.n_frames), np.int64)
    counts[[list(names).index(name) for name in there]] = part.counts
    columns = {f.name: getattr(part, f.name) for f in fields(part) if f.name not in NOT_ROWS}
    return Detections.build(tuple(names), found.rate, counts, **columns)


def recorded(
    root: Path,
    settings: Settings,
    seen: TargetRecording,
    names: Sequence[str],
    *,
    masked: bool = True,
    threads: int | None = None,
) -> Recorded:
    """What the cameras saw of something that calibrates them; masked as trials are, or not.

    Raises:
        KinemarkError: images or detections cannot be used, or a camera is not among them.
    """
    if seen.images is None:
        found = _read(root / str(seen.detections))
        whole = of_cameras(found, names, root / str(seen.detections))
        if whole is None:
            if not len(found):
                raise KinemarkError(f"{root / str(seen.detections)} has no points. Record or detect it again.")
            have, lack = ", ".join(found.cameras), ", ".join(sorted(set(names) - set(found.cameras)))
            raise KinemarkError(
                f"{root / str(seen.detections)} has cameras {have}, not {lack}. Give them the same names."
            )
        return Recorded(whole, size_of_cameras(root, settings, names))
    images = open_cameras(root, settings, seen.images, names)
    check_no_image_lost({name: i for name, i in images.items() if name not in settings.cameras.rates_hz})
    total = sum(source.n_frames for source in images.values())
    method: Any = settings.detect
    found = detect(
        list(images.values()),
        cameras=tuple(names),
        rate=_rate(root, settings, images, names),
        method=method,
        of_cameras=methods_of(settings, names),
        masks=masks_of(root, settings, names) if masked else None,
        progress=lambda done: tell(done, total),
        threads=threads,
    )
    return Recorded(found, np.array([images[name].size for name in names]))


def _rate(root: Path, settings: Settings, images: Mapping[str, ImageSource], names: Sequence[str]) -> float:
    """Hz of a film that calibrates: in the proportion of its file's rate to that of the first trial's; 1 if unknown."""
    stated, own = settings.rate_hz or 1.0, images[names[0]].rate
    pattern = next((trial.images for trial in settings.trials if trial.images), None)
    if own is None or pattern is None or not settings.rate_hz:
        return stated
    try:
        of_trials = _opened(root, settings.cameras.first_field, pattern, names[:1])[names[0]].rate
    except KinemarkError:  # trials may be copied later
        return stated
    return stated * own / of_trials if of_trials else stated


def methods_of(settings: Settings, names: Sequence[str]) -> dict[str, Any]:
    """What `[detect.cameras]` says of these cameras.

    Raises:
        KinemarkError: it names a camera that the session does not have.
    """
    if not settings.cameras.names:
        try:
            check_camera_names(settings.detect_cameras, names)
        except ValueError as error:
            raise KinemarkError(f"{error}. Correct the name in session.toml.") from error
    return {name: method for name, method in settings.detect_cameras.items() if name in names}


def masks_of(root: Path, settings: Settings, names: Sequence[str]) -> StaticMasks | None:
    """Where nothing is a marker, by the session's `[masks]`; None where it has none.

    Raises:
        KinemarkError: the file, or the recording of the empty volume, cannot be used.
    """
    way = settings.masks
    if way is None:
        return None
    drawn = read_masks(root / way.file) if way.file else None
    if way.empty is None:
        return drawn
    key = file_key(*files_of(root, settings, way.empty, names))
    field = settings.cameras.first_field
    methods = settings.detect, tuple(methods_of(settings, names).items())
    learned = _learned(root, way.empty, tuple(names), key, methods=methods, first_field=field, grow=way.grow_px)
    return learned if drawn is None else combined_masks(drawn, learned)


@lru_cache(maxsize=8)
def _learned(
    root: Path, pattern: str, names: tuple[str, ...], key: str, *, methods: Any, first_field: Any, grow: float | None
) -> StaticMasks:
    """The masks of an empty recording, learned once for all trials of a run; `key` changes when its files do.

    Raises:
        KinemarkError: the recording cannot be used.
    """
    sources = list(_opened(root, first_field, pattern, names).values())
    grown = {} if grow is None else {"grow": grow}
    try:
        return learn_masks(sources, cameras=names, method=methods[0], of_cameras=dict(methods[1]), **grown)
    except ValueError as error:
        raise KinemarkError(f"[masks] cannot be learned from the empty volume: {error}.") from error


def masks_key(root: Path, settings: Settings, names: Sequence[str]) -> list[object]:
    """What the masks depend on, for the key of a stage; nothing where there are none."""
    way = settings.masks
    if way is None:
        return []
    files = [root / way.file] if way.file else []
    said = [settings.detect, methods_of(settings, names)] if way.empty else []
    return [file_key(*files, *files_of(root, settings, way.empty, names)), way.model_dump_json(), *said]


def size_of_cameras(root: Path, settings: Settings, names: Sequence[str]) -> Ints:
    """(C, 2) px as the settings say, or the images of the first trial that has any show; 0 where neither is there.

    Raises:
        KinemarkError: the settings say the sizes of some cameras, and not of these.
    """
    stated = settings.cameras.size_px
    if isinstance(stated, dict):
        if missing := [name for name in names if name not in stated]:
            raise KinemarkError(f"size_px of [cameras] lacks {', '.join(missing)}. Add width and height of each.")
        return np.array([stated[name] for name in names], np.int64)
    if stated is not None:
        return np.tile(np.array(stated, np.int64), (len(names), 1))
    pattern = next((trial.images for trial in settings.trials if trial.images), None)
    if pattern is None:
        return np.zeros((len(names), 2), np.int64)
    return np.array([source.size for source in open_cameras(root, settings, pattern, names).values()])


def files_of(root: Path, settings: Settings, seen: TargetRecording | str | None, names: Sequence[str]) -> list[Path]:
    """The files that a recording consists of."""
    if seen is None:
        return []
    if isinstance(seen, TargetRecording) and seen.detections is not None:
        return [root / seen.detections]
    pattern = seen if isinstance(seen, str) else str(seen.images)
    return [path for source in open_cameras(root, settings, pattern, names).values() for path in source.paths]


def _read(path: Path) -> Detections:
    """Detections of a CSV or HDF5 file."""
    if path.suffix.lower() == ".csv":
        return detections_of_csv(path, rate=1.0)
    record = load(path)
    if not isinstance(record, Detections):
        raise KinemarkError(f"{path} holds {type(record).__name__}, wanted Detections. Name another file.")
    return record
