"""The images of an open trial, always by the number of a frame."""

from __future__ import annotations

from ...data import KinemarkError
from ...engine.camera_checks.start_times import started_apart
from ...engine.keys import digest
from ...engine.pictures.mosaics import Mosaics
from ...engine.pictures.small_videos import small_images
from ...engine.pictures.tiles import recording_key
from ...engine.trial_inputs import last_tracked
from . import messages
from .desk import OpenDocument

FOLDER = "mosaics"
"""In a trial's folder of results."""


def mosaics_of(document: OpenDocument) -> Mosaics | None:
    """The mosaics of a trial; None where its images are not there."""
    with document.lock:
        if "mosaics" not in document.kept:
            document.kept["mosaics"] = _mosaics(document)
        found: Mosaics | None = document.kept["mosaics"]
        return found


def mosaic_of(document: OpenDocument) -> messages.Mosaic | None:
    """Where each camera is in them."""
    found = mosaics_of(document)
    if found is None:
        return None
    layout = found.layout
    tiles = [messages.Tile(**tile._asdict()) for tile in layout.tiles]
    return messages.Mosaic(width=layout.width, height=layout.height, tiles=tiles, images=found.recording)


def seen(document: OpenDocument) -> Mosaics:
    """The same; raises a KinemarkError where there are no images."""
    found = mosaics_of(document)
    if found is None:
        raise KinemarkError("This trial has no images.")
    return found


def _mosaics(document: OpenDocument) -> Mosaics | None:
    if document.inputs is None or document.inputs.source.of.entry.images is None:
        return None
    recording = document.inputs.source.of
    try:
        sources = recording.images()
    except KinemarkError:  # they were moved since the trial was run
        return None
    folder = document.inputs.folder
    apart = started_apart(last_tracked(document.records).diagnostics)

    def image_at(camera: str, n: int) -> int:
        return recording.image_at(camera, n - apart.get(camera, 0), sources[camera])  # started apart by whole frames

    cameras = recording.settings.cameras
    times = [apart, cameras.delays_ms, cameras.rates_hz, recording.settings.rate_hz]
    key = digest(recording_key(sources), times)
    return Mosaics(sources, folder / FOLDER, recording=key, small=small_images(sources, folder), image_at=image_at)
