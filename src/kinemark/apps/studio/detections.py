"""Detections as the page draws them."""

from __future__ import annotations

import numpy as np

from ...data import KinemarkError, Trajectories
from ...data.array_types import Ints
from .desk import OpenDocument
from .messages import DetectionsHeader

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
