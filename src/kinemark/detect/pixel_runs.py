"""White pixels, and the runs they form along each scan line; how they are found is in `native.pixel_runs`."""

from __future__ import annotations

from typing import NamedTuple

from .. import native
from ..data.array_types import GreyLevels, Ints


class Runs(NamedTuple):
    """White pixels first … last of scan line y of the tall image: three columns (R), in scan order."""

    y: Ints
    first: Ints
    last: Ints


def find_runs(tall: GreyLevels, threshold: float, *, most: int | None = None) -> Runs:
    """The runs of pixels brighter than `threshold` in the tall image (n H, W).

    Args:
        tall: scan lines of all frames, one below the other.
        threshold: grey level of the image.
        most: only so many runs are looked for, the first ones; None: all.
    """
    return Runs(*native.find_runs(tall, threshold, most=most))
