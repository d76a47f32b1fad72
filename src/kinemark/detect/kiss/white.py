"""White pixels of a batch of frames, as runs and as pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..pixel_runs import Runs, find_runs


def runs_of(images: NDArray[np.uint8 | np.uint16], threshold: float) -> Runs:
    """Runs of pixels brighter than `threshold` in frames (n, H, W), in scan order of the tall image (n H, W)."""
    n, height, width = images.shape
    found = find_runs(images.reshape(n * height, width), threshold)
    return Runs(*(column.astype(np.int64, copy=False) for column in found))


def pixels_of(
    y: NDArray[np.int64], first: NDArray[np.int64], last: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Line (N) and column (N) of every pixel of runs, in their order."""
    n = last - first + 1
    start = np.cumsum(n) - n
    return np.repeat(y, n), np.arange(n.sum()) + np.repeat(first - start, n)
