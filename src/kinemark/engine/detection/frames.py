"""What is detected in the images of all cameras at some frames of a trial, as `session.toml` says it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError
from ...data.array_types import GreyLevels
from ...detect import Blobs
from ..session import Session
from .open_detection import Draft, OpenDetection

SPREAD = 5
"""Frames of a trial where none are named; as the figure of the first paper has."""


class DetectedImage(NamedTuple):
    """An image of a camera: (H, W) in 8 bits, its detections in its px, and how many lines of a frame each line is."""

    camera: str
    image: GreyLevels
    blobs: Blobs
    tall: int


class DetectedFrames(NamedTuple):
    """Of a trial, frame by frame, the image of every camera and what is detected in it."""

    session: str
    trial: str
    frames: list[tuple[int, list[DetectedImage]]]


def detected_frames(source: Path, trial: str | None = None, frames: Sequence[int] = ()) -> DetectedFrames:
    """Detect in all cameras at some frames.

    Args:
        source: folder of a session, or its file.
        trial: its name; the first with images where None.
        frames: numbers of frames in the recording; `SPREAD` evenly where there are none.

    Raises:
        KinemarkError: there is no such session, trial or frame, or nothing can be read.
    """
    session = Session.open(source)
    name = trial or next((one.name for one in session.settings.trials if one.images), None)
    if name is None:
        raise KinemarkError(f"{source} has no trial with images.")
    opened = OpenDetection(session.root, name)
    last = opened.first + opened.n_frames - 1
    if wrong := [f for f in frames if not opened.first <= f <= last]:
        raise KinemarkError(f"{name} has frames {opened.first} to {last}, and {wrong[0]} was asked for.")
    wanted = list(frames) or sorted(set(np.linspace(opened.first, last, SPREAD).round().astype(int).tolist()))
    found = [(f, [_image(opened, camera, f) for camera in opened.sources]) for f in wanted]
    return DetectedFrames(session.settings.name, name, found)


def _image(opened: OpenDetection, camera: str, frame: int) -> DetectedImage:
    found = opened.detected(camera, frame, Draft())
    source, shift = opened.sources[camera], OpenDetection.shift(found.image)
    image = found.image if found.image.dtype == np.uint8 else (found.image >> shift).clip(0, 255).astype(np.uint8)
    blobs = found.blobs._replace(uv=found.blobs.uv - [0.0, source.v_offset(frame - 1)])
    return DetectedImage(camera, image, blobs, 2 if source.interlaced else 1)
