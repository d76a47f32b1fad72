"""The images of an open trial, always by the number of a frame."""

from __future__ import annotations

from ...data import KinemarkError
from ...engine.mosaics import Mosaics
from ...engine.small_videos import small_images
from ...engine.tiles import recording_key
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
    every = next(iter(found.sources.values())).every
    return messages.Mosaic(width=layout.width, height=layout.height, tiles=tiles, every=every)


def seen(document: OpenDocument) -> Mosaics:
    """The same; raises a KinemarkError where there are no images."""
    found = mosaics_of(document)
    if found is None:
        raise KinemarkError("This trial has no images.")
    return found


def _mosaics(document: OpenDocument) -> Mosaics | None:
    if document.inputs is None or document.inputs.source.of.entry.images is None:
        return None
    try:
        sources = document.inputs.source.of.images()
    except KinemarkError:  # they were moved since the trial was run
        return None
    folder = document.inputs.folder
    return Mosaics(sources, folder / FOLDER, recording=recording_key(sources), small=small_images(sources, folder))
