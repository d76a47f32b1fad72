"""Recordings of white pixels alone: what KISS's on-line part keeps of each camera (KISS 1, figure 1).

A pixel brighter than the threshold is white, every other is black. The file is a video without loss, Matroska with
FFV1, so that every command reads it as it does any other recording, and a field of 752 × 291 px with fifteen markers
takes a kilobyte. What grey levels say is gone: detection gives the means of white pixels (`centroid = "white"`, or a
method of KISS), and no threshold is learned.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError
from ..detect.centroids_method import grey_scale
from ..io.files import check_new
from ..io.images import ImageSource, open_images
from ..io.video import write_video

WHITE = 255
"""Grey level of a white pixel; by definition."""


class WhitePixels(NamedTuple):
    """What was written: frames, their rate Hz, and the mean number of white pixels in one."""

    n_frames: int
    rate: float
    mean_white: float


def write_white_pixels(
    source: Path | str, target: Path, *, threshold: float, inverted: bool = False, rate_hz: float | None = None
) -> WhitePixels:
    """Write the white pixels of all frames of a camera's recording.

    Args:
        source: a video, or images as 'cam1/%04d.png'.
        target: the video, ending in .mkv.
        threshold: grey levels of 8 bits; brighter pixels are white, or darker ones where `inverted`.
        inverted: the markers are dark on bright ground.
        rate_hz: of images, which do not say it.

    Raises:
        KinemarkError: the target exists or does not end in .mkv, the rate is not known, the threshold is out of range,
            or the recording is damaged.
    """
    if target.suffix.lower() != ".mkv":
        raise KinemarkError(f"{target} does not end in .mkv, the format that loses nothing. Name it so.")
    check_new(target)
    if not 0 <= threshold < 255:
        raise KinemarkError(f"The threshold is {threshold:g} grey levels; wanted is 0 to below 255.")
    images = open_images(source)
    rate = rate_hz or images.rate
    if not rate:
        raise KinemarkError(f"{source} does not say its frame rate. Add --rate-hz.")
    counts: list[int] = []
    write_video(target, _white(images, threshold, inverted, counts), rate)
    return WhitePixels(len(counts), rate, float(np.mean(counts)))


def _white(images: ImageSource, threshold: float, inverted: bool, counts: list[int]) -> Iterator[NDArray[np.uint8]]:
    """Frames (H, W) of black and white; how many are white is added to `counts`."""
    for image in images:
        level = threshold * grey_scale(image.dtype)
        white = image < level if inverted else image > level
        counts.append(int(white.sum()))
        yield np.where(white, WHITE, 0).astype(np.uint8)
