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
    share, inverted = getattr(method, "relative_threshold", None), getattr(method, "inverted", False)
    if share is None:
        return method
    white = np.iinfo(images.dtype).max
    counts = np.zeros(white + 1, np.int64)
    chosen = images[evenly(len(images), FRAMES)]
    for image in chosen:
        counts += np.bincount(image.reshape(-1), minlength=white + 1)
    found = levels(counts[::-1] if inverted else counts, frames=len(chosen))
    if found is None:
        return None
    level = found[0] + share * (found[1] - found[0])  # (3)
    threshold = (white - level if inverted else level) / grey_scale(images.dtype)
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
