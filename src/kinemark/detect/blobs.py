"""What every method of detection gives: the detections of some frames of one camera."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Blobs(NamedTuple):
    """Detections of n frames, sorted by frame; the columns are those of `data.Detections`.

    Attributes:
        counts: (n) detections a frame.
        uv: (D, 2) px; cov: (D, 2, 2) px², NaN for TOO_LARGE ones.
        area: (D) px², rim pixels counted by their brightness, white pixels for TOO_LARGE ones; width, height: (D) px,
            of the white pixels; peak: (D) grey level of the image, NaN for TOO_LARGE ones.
        validity: (D) a `Validity` each.
        merged: (D) whether markers lie on each other in this image.
    """

    counts: NDArray[np.int64]
    uv: NDArray[np.float64]
    cov: NDArray[np.float64]
    area: NDArray[np.float64]
    width: NDArray[np.float64]
    height: NDArray[np.float64]
    peak: NDArray[np.float64]
    validity: NDArray[np.uint8]
    merged: NDArray[np.bool_]


def joined(parts: list[Blobs]) -> Blobs:
    """The detections of consecutive batches as one."""
    return parts[0] if len(parts) == 1 else Blobs(*(np.concatenate(column) for column in zip(*parts, strict=True)))
