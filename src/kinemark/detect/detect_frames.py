"""Stacks of frames, from grey levels to detections, by whichever method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data.method import Method
from .blobs import Blobs, joined
from .centroids_method import check_images
from .levels import levelled
from .stage import DETECT

PIXELS = 20 << 20  # looked at in one go: enough to share what NumPy costs a call, little enough for the cache


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
    step = max(1, PIXELS // images[0].size) if len(images) else 1
    starts = range(0, max(len(images), 1), step)
    detected = DETECT.function(method)
    return joined([detected(np.ascontiguousarray(images[k : k + step]), k, method=method) for k in starts])
