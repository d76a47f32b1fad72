"""Stacks of frames, from grey levels to detections, by whichever method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .blobs import Blobs, joined
from .centroids import detect_centroids
from .centroids_method import Centroids, check_images
from .kiss import KissNearest, KissScanning, detect_nearest, detect_scanning
from .levels import levelled

PIXELS = 20 << 20  # looked at in one go: enough to share what NumPy costs a call, little enough for the cache

DETECTORS: dict[type, Callable[[NDArray[np.uint8 | np.uint16], int, Any], Blobs]] = {
    Centroids: detect_centroids,
    KissScanning: detect_scanning,
    KissNearest: detect_nearest,
}
"""What does each method: called with frames (n, H, W), the number of the first, and the method."""


def detect_frames(
    images: NDArray[np.uint8 | np.uint16], *, method: Centroids | KissScanning | KissNearest | None = None
) -> Blobs:
    """Markers in frames (n, H, W) of grey levels; each frame is judged by itself.

    Raises:
        ValueError: `images` is no such stack.
        KinemarkError: a frame has thousands of white specks, so the threshold lies in its noise.
    """
    check_images(images)
    method = levelled(method or Centroids(), images)
    if method is None:
        return detect_frames(np.zeros((len(images), 1, 1), np.uint8))
    step = max(1, PIXELS // images[0].size) if len(images) else 1
    starts = range(0, max(len(images), 1), step)
    return joined([DETECTORS[type(method)](np.ascontiguousarray(images[k : k + step]), k, method) for k in starts])
