"""A threshold relative to a camera's own levels.

The background b is the median of all pixels, and its noise σ the distance from there down to the quantile that a normal
distribution has at one standard deviation; markers are too few to move either. What stands out is brighter than
b + max(6 σ, 3 levels) (1). The bright level p is found by turns (Ridler and Calvard 1978, with a median for the mean):

    p ← median of the pixels brighter than (b + p) / 2                    (2)

from the mean of what stands out, so that the rims of markers do not darken it, and strobes and lamps do not brighten it
as long as they have fewer pixels than the markers. The threshold is b + r (p − b) (3), where r is
`relative_threshold`. Images of dark markers on bright ground are turned to their negative first.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..data.method import Method
from ..numerics.evenly import evenly
from .centroids_method import grey_scale

AnyMethod = TypeVar("AnyMethod", bound=Method)

FRAMES = 16  # of a batch that levels are measured in; chosen for speed
LEAST = 4  # pixels a frame that must stand out; chosen
TURNS = 20  # of the search for two classes at most; chosen: fewer settle it


def levelled(method: AnyMethod, images: NDArray[np.uint8 | np.uint16]) -> AnyMethod | None:
    """The method with the absolute threshold that its relative one means for these frames (n, H, W).

    None where nothing stands out from the background in them. A method without `relative_threshold` is
    returned as it is.
    """
    if getattr(method, "relative_threshold", None) is None:
        return method
    chosen = images[evenly(len(images), FRAMES)]
    return _absolute(method, sum(map(_counts, chosen), _counts(images[:0])), len(chosen), images.dtype)


def levelled_by_first(
    method: AnyMethod, batches: Iterable[NDArray[np.uint8 | np.uint16]]
) -> tuple[AnyMethod | None, int]:
    """`levelled` by the first `FRAMES` frames in a row that show something, and the first of these.

    They are counted from 0, `FRAMES` at a time, however many come in a batch (n, H, W): the size of images decides on
    that. Where nothing ever shows, there is no method, and the number of all frames.
    """
    first = frames = 0
    counts: NDArray[np.int64] | None = None
    dtype: np.dtype[Any] = np.dtype(np.uint8)
    for images in batches:
        dtype = images.dtype
        for image in images:
            counts, frames = _counts(image) if counts is None else counts + _counts(image), frames + 1
            if frames == FRAMES:
                if found := _absolute(method, counts, frames, dtype):
                    return found, first
                first, frames, counts = first + frames, 0, None
    found = None if counts is None else _absolute(method, counts, frames, dtype)
    return (found, first) if found else (None, first + frames)


def _counts(images: NDArray[np.uint8 | np.uint16]) -> NDArray[np.int64]:
    """(L) pixels of each grey level."""
    return np.bincount(images.reshape(-1), minlength=int(np.iinfo(images.dtype).max) + 1)


def _absolute(method: AnyMethod, counts: NDArray[np.int64], frames: int, dtype: np.dtype[Any]) -> AnyMethod | None:
    """The method with the threshold (3) for images with so many pixels (L) of each grey level."""
    asked: Any = method
    white = len(counts) - 1
    found = levels(counts[::-1] if asked.inverted else counts, frames=frames)
    if found is None:
        return None
    level = found[0] + asked.relative_threshold * (found[1] - found[0])  # (3)
    threshold = (white - level if asked.inverted else level) / grey_scale(dtype)
    absolute: Any = {"threshold": float(np.clip(threshold, 0, 254.99)), "relative_threshold": None}
    return replace(method, **absolute)


def levels(counts: NDArray[np.int64], *, frames: int) -> tuple[float, float] | None:
    """Background and bright level of images with `counts` (L) pixels of each grey level; None if nothing is bright."""
    total = np.cumsum(counts)
    if frames == 0:
        return None
    b, below = (float(np.searchsorted(total, share * total[-1])) for share in (0.5, 0.1587))
    floor = int(b + max(6 * (b - below), 3.0))  # (1)
    grey = np.arange(len(counts))
    out = counts * (grey > floor)
    if out.sum() < LEAST * frames:
        return None
    p = float((out * grey).sum() / out.sum())
    for _ in range(TURNS):
        above = np.cumsum(out * (grey > (b + p) / 2))
        after = float(np.searchsorted(above, 0.5 * above[-1]))  # (2)
        if after == p:
            break
        p = after
    return b, p
