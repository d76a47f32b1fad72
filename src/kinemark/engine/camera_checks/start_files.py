"""When the cameras of a recording were started: from detections and cameras, or from a flash in the images."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...data import Detections, KinemarkError, Rig
from ...detect.flash import Flash, find_flash, flash_offsets
from ...io.detections_csv import NamedDetections
from ...io.formats import ReadOptions, read_file
from ...match import start_offsets
from ..recordings import open_cameras
from ..session import Session


def starts_of_files(
    detections: Path, cameras: Path, *, most_s: float, rate_hz: float | None = None, length_unit: str | None = None
) -> dict[str, Any]:
    """By how many images, and by how many ms, each camera was started later than the first; what to write down.

    Args:
        detections: a file of detections, the images of each camera numbered from its own start.
        cameras: a file of calibrated cameras.
        most_s: seconds that two cameras may be apart.
        rate_hz: of a file that does not say it.
        length_unit: "mm", "cm", "m" or "in", of a file of cameras that does not say it.

    Raises:
        KinemarkError: a file holds something else, or the markers do not tell.
    """
    found = read_file(detections, ReadOptions(rate_hz, None, False, "detections"))
    points = found.detections if isinstance(found, NamedDetections) else found
    rig = read_file(cameras, ReadOptions(None, length_unit, False, "rig"))
    if not isinstance(points, Detections):
        raise KinemarkError(f"{detections} holds no detections. Give a file of them, CSV or HDF5.")
    if not isinstance(rig, Rig):
        raise KinemarkError(f"{cameras} holds no cameras. Give a rig file, TOML.")
    offsets = start_offsets(points, rig, most=max(round(most_s * points.rate), 1))
    late = {name: int(n) for name, n in zip(rig.names, offsets.images, strict=True)}
    return {
        "images": late,
        "delays_ms": {name: 1000 * n / points.rate for name, n in late.items()},
        "clearness": {name: float(q) for name, q in zip(rig.names[1:], offsets.clearness[1:], strict=True)},
        "disagreeing": [list(pair) for pair in offsets.disagreeing],
    }


def starts_by_flash(session: Path, trial: str | None = None, *, rate_hz: float | None = None) -> dict[str, Any]:
    """The same as `starts_of_files` by the image of each camera that a flash lights as a whole; to the image.

    Args:
        session: folder of a session, or its file. trial: its name; the first with images where None.
        rate_hz: of cameras whose rate neither the session nor a video says.

    Raises:
        KinemarkError: there is no such session or trial, a camera saw no flash or several, or its rate is not known.
    """
    opened = Session.open(session)
    entry = next((one for one in opened.settings.trials if one.images and trial in (None, one.name)), None)
    if entry is None or entry.images is None:
        raise KinemarkError(f"{session} has no trial {trial or ''} with images, in which a flash could be looked for.")
    names = opened.camera_names
    sources = open_cameras(opened.root, opened.settings, entry.images, names)
    rates = {
        name: opened.settings.cameras.rates_hz.get(name) or opened.settings.rate_hz or source.rate or rate_hz
        for name, source in sources.items()
    }
    if unknown := [name for name, rate in rates.items() if not rate]:
        raise KinemarkError(f"The rate of {unknown[0]} is not known. Give rate_hz in the session, or --rate-hz.")
    flashes = {name: _flash(name, source) for name, source in sources.items()}
    times = {name: one.frame / (rates[name] or 1.0) for name, one in flashes.items()}
    first = times[names[0]]
    return {
        "images": dict(zip(flashes, flash_offsets(list(flashes.values())).tolist(), strict=True)),
        "delays_ms": {name: round(1000 * (first - time), 3) for name, time in times.items()},
        "flash": {name: one.frame + 1 for name, one in flashes.items()},
        "rise": {name: round(one.rise, 2) for name, one in flashes.items()},
    }


def _flash(camera: str, source: Any) -> Flash:
    try:
        return find_flash(source)
    except KinemarkError as error:
        raise KinemarkError(
            f"{camera}: {error}. One flash must light what every camera sees, while all of them record; else put them "
            "together by their markers: kinemark starts DETECTIONS CAMERAS."
        ) from error
