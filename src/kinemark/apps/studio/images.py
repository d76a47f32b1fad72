"""The images of an open trial and its detections, always by the number of a frame."""

from __future__ import annotations

import numpy as np

from ...data import KinemarkError, Trajectories
from ...data.array_types import Ints
from ...engine.camera_checks.start_times import MOVED, images_late
from ...engine.keys import digest
from ...engine.pictures.mosaics import Mosaics
from ...engine.pictures.small_videos import small_images
from ...engine.pictures.tiles import recording_key
from ...engine.trial_inputs import last_tracked
from . import messages
from .desk import OpenDocument
from .messages import DetectionsHeader

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
    found = [one for one in last_tracked(document.records).diagnostics if one.kind in MOVED]
    before = recording.first_frame - 1

    def image_at(camera: str, n: int) -> int:
        late = images_late(found, camera, n - before)  # by whole frames
        return recording.image_at(camera, n - late, sources[camera])

    cameras = recording.settings.cameras
    times = [[one.as_dict() for one in found], cameras.delays_ms, cameras.rates_hz, recording.settings.rate_hz]
    key = digest(recording_key(sources), times)
    return Mosaics(sources, folder / FOLDER, recording=key, small=small_images(sources, folder), image_at=image_at)


MOST_FRAMES = 2000
"""That are sent at a time; chosen: 16 MB of 60 markers in 8 cameras."""


def seen_between(document: OpenDocument, first: int, last: int) -> tuple[DetectionsHeader, bytes]:
    """The columns of frames first … last, numbers in the recording.

    Raises:
        KinemarkError: there are no detections, or not these frames.
    """
    detections, now = document.editing.detections, document.now.trajectories
    if detections is None:
        raise KinemarkError("This trial has no detections: it is a file of trajectories.")
    a, stop = first - now.first_frame, last - now.first_frame + 1
    if not 0 <= a < stop <= detections.n_frames:
        raise KinemarkError(f"There are frames {now.first_frame} to {now.first_frame + detections.n_frames - 1}.")
    rows = np.concatenate([np.arange(start[a], start[stop]) for start in detections.start])
    about = DetectionsHeader(
        cameras=list(detections.cameras), first=first, last=last, detections=len(rows), head=document.head
    )
    counts = np.diff(detections.start[:, a : stop + 1], axis=1)
    track = _tracks_of(rows, now, a, stop)
    columns = (
        counts.astype("<u4"), detections.uv[rows].astype("<f4"), track.astype("<i4"), detections.validity[rows]
    )  # fmt: skip
    return about, b"".join(column.tobytes() for column in columns)


def _tracks_of(rows: Ints, now: Trajectories, a: int, stop: int) -> Ints:
    """The trajectory that each row belongs to, −1 for none; `rows` rise."""
    of = np.full(len(rows), -1, np.int64)
    for k, path in enumerate(now):
        own = path.detection[a:stop]
        own = own[own >= 0]
        at = np.searchsorted(rows, own)
        hit = (at < len(rows)) & (rows[at.clip(0, len(rows) - 1)] == own) if len(rows) else np.zeros(len(own), bool)
        of[at[hit]] = k
    return of
