"""Stacks of frames, from grey levels to detections, by whichever method."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import GreyLevels
from ..data.method import Method
from .beside import moved
from .blobs import Blobs, joined
from .centroids import found_suspects
from .centroids_method import Centroids, check_images
from .ground import Ground
from .levels import levelled
from .separate import Suspects
from .stage import DETECT

PIXELS = 20 << 20  # looked at in one go: enough to share what NumPy costs a call, little enough for the cache; chosen


def detect_frames(images: NDArray[np.uint8 | np.uint16], *, method: Method | None = None) -> Blobs:
    """Markers in frames (n, H, W) of grey levels; each frame is judged by itself.

    Args:
        images: the frames.
        method: one of `DETECT`; `Centroids()` where None.

    Raises:
        ValueError: `images` is no such stack, or the method is none of `DETECT`.
        KinemarkError: a frame has thousands of white specks, so the threshold lies in its noise.
    """
    check_images(images)
    method = levelled(method or DETECT.make(), images)
    if method is None:
        return detect_frames(np.zeros((len(images), 1, 1), np.uint8))
    detected = DETECT.function(method)
    return joined([detected(part, first, method=method) for first, part in _parts(images)])


def find_suspects(
    images: NDArray[np.uint8 | np.uint16], *, method: Centroids, first: int = 0, ground: Ground | None = None
) -> Iterator[Suspects]:
    """The same of such a method, in parts of consecutive frames, before their markers are told apart.

    Args:
        images: the frames.
        method: with nothing left open.
        first: number of the first frame.
        ground: that is taken from the images first; markers are placed by what it leaves beside them.

    Raises:
        ValueError: as `detect_frames`.
        KinemarkError: likewise.
    """
    check_images(images)
    for begin, part in _parts(images):
        if ground is None:
            yield from found_suspects(part, first + begin, method=method)
        else:
            yield from _before_ground(part, first + begin, method, ground)


def _before_ground(images: GreyLevels, first: int, method: Centroids, ground: Ground) -> Iterator[Suspects]:
    """The same before a ground that is taken away."""
    rest, done, aspect = ground.taken_from(images, first), 0, method.aspect or 1.0
    for part in found_suspects(rest, first, method=method):
        own = slice(done, done + len(part.blobs.counts))
        yield moved(part, images[own], rest[own], ground, first=first + done, aspect=aspect)
        done = own.stop


def _parts(images: NDArray[np.uint8 | np.uint16]) -> Iterator[tuple[int, NDArray[np.uint8 | np.uint16]]]:
    """The number of the first frame of each part, and its frames."""
    step = max(1, PIXELS // images[0].size) if len(images) else 1
    for first in range(0, max(len(images), 1), step):
        yield first, np.ascontiguousarray(images[first : first + step])
