"""When the cameras of a recording were started, from files of detections and cameras."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..data import Detections, KinemarkError, Rig
from ..io.detections_csv import NamedDetections
from ..io.formats import ReadOptions, read_file
from ..match import start_offsets


def starts_of_files(detections: Path, cameras: Path, *, most_s: float, rate_hz: float | None = None) -> dict[str, Any]:
    """By how many images, and by how many ms, each camera was started later than the first; what to write down.

    Args:
        detections: a file of detections, the images of each camera numbered from its own start.
        cameras: a file of calibrated cameras.
        most_s: seconds that two cameras may be apart.
        rate_hz: of a file that does not say it.

    Raises:
        KinemarkError: a file holds something else, or the markers do not tell.
    """
    found = read_file(detections, ReadOptions(rate_hz, None, False, "detections"))
    points = found.detections if isinstance(found, NamedDetections) else found
    rig = read_file(cameras, ReadOptions(None, None, False, "rig"))
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
