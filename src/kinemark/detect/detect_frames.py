"""Stacks of frames, from grey levels to detections, by whichever method."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..data.method import Method
from .blobs import Blobs, joined
from .centroids import found_suspects
from .centroids_method import Centroids, check_images
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


def find_suspects(images: NDArray[np.uint8 | np.uint16], *, method: Centroids) -> Iterator[Suspects]:
    """The same of such a method, in parts of consecutive frames, before their markers are told apart.

    Raises:
        ValueError: as `detect_frames`.
        KinemarkError: likewise.
    """
    check_images(images)
    for first, part in _parts(images):
        yield from found_suspects(part, first, method=method)


def _parts(images: NDArray[np.uint8 | np.uint16]) -> Iterator[tuple[int, NDArray[np.uint8 | np.uint16]]]:
    """The number of the first frame of each part, and its frames."""
    step = max(1, PIXELS // images[0].size) if len(images) else 1
    for first in range(0, max(len(images), 1), step):
        yield first, np.ascontiguousarray(images[first : first + step])
