"""Groups cut out of their images, with what else lies there left out, as `shape_images.Patches`.

A patch holds the group's own white pixels and all pixels within `MARGIN` of them; white pixels of other groups and
their neighbours are left out. Places count from the centre of the group's rectangle, and v is divided by the aspect of
a disc's image (its height by its width), so that discs are round there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats
from ..native.shape_images import Patches
from .grouping import PixelGroups

MARGIN = 3
"""px; holds the rim of a marker blurred by one pixel, with fewer the fits often go astray; chosen (see
studies/overlapping_markers.py)."""
SATURATED = 4  # pixels at exactly the highest level, from which on it is the sensor's white; chosen


class CutOut(NamedTuple):
    """n groups.

    Attributes:
        patches: their pixels.
        white: (n, N) whether a pixel is one of the group's own white ones.
        origin: (n, 2) px of the image at which x = y = 0.
        ground: (n) grey level round the group; peak: (n) the group's highest.
        pixel: (n) area of a pixel where discs are round, px².
    """

    patches: Patches
    white: NDArray[np.bool_]
    origin: Floats
    ground: Floats
    peak: Floats
    pixel: Floats

    def take(self, index: NDArray[np.integer] | NDArray[np.bool_]) -> CutOut:
        """Some of the groups."""
        return CutOut(
            self.patches.take(index),
            self.white[index],
            self.origin[index],
            self.ground[index],
            self.peak[index],
            self.pixel[index],
        )


def cut_out(
    images: NDArray[np.uint8 | np.uint16],
    groups: PixelGroups,
    *,
    threshold: float,
    variance: Floats,
    shot: float,
    aspect: float,
) -> CutOut:
    """The patches of all groups of frames (n, H, W) with noise variance (n), grey levels as in the images."""
    _, height, width = images.shape
    own, line, column = _painted(groups)
    inside = (column >= 0) & (column < width) & (line // height == groups.frame[:, None, None])
    grey = images.reshape(-1)[np.where(inside, line * width + column, 0)].astype(np.float64)
    others = scipy.ndimage.maximum_filter((grey > threshold) & inside & ~own, size=(1, 3, 3))
    near = scipy.ndimage.maximum_filter(own, size=(1, 2 * MARGIN + 1, 2 * MARGIN + 1))
    used = near & inside & (own | ~others)
    order = _packed(used)
    white = np.take_along_axis(own.reshape(len(own), -1), order, 1)
    grey = np.take_along_axis(grey.reshape(len(grey), -1), order, 1)
    used = np.take_along_axis(used.reshape(len(used), -1), order, 1)
    middle = np.stack([(groups.left + groups.right) / 2, (groups.top + groups.bottom) / 2], -1)
    x, y = (
        np.take_along_axis(np.broadcast_to(at, own.shape).reshape(len(own), -1), order, 1) - m[:, None]
        for at, m in ((column, middle[:, 0]), (line, middle[:, 1]))
    )
    ground = _ground(grey, used & ~white, threshold)
    peak = np.where(white, grey, 0).max(1)
    noise = variance[groups.frame, None] + shot * np.maximum(grey - ground[:, None], 0.0)
    full = np.where((white & (grey == peak[:, None])).sum(1) >= SATURATED, _white(grey, white, peak, noise), np.inf)
    patches = Patches(x, y / aspect, grey, used / noise, full)
    middle[:, 1] -= groups.frame * height
    return CutOut(patches, white & used, middle, ground, peak, np.full(len(peak), 1 / aspect))


def _painted(groups: PixelGroups) -> tuple[NDArray[np.bool_], NDArray[np.int64], NDArray[np.int64]]:
    """(n, h, w) the groups' own pixels in rectangles of one size, with their lines (n, h, 1) and columns (n, 1, w)."""
    high = int((groups.bottom - groups.top).max()) + 1 + 2 * MARGIN
    wide = int((groups.right - groups.left).max()) + 1 + 2 * MARGIN
    top, left = groups.top - MARGIN, groups.left - MARGIN
    of = np.repeat(np.arange(len(top)), np.diff(groups.start))
    edges = np.zeros((len(top), high, wide + 1), np.int8)
    np.add.at(edges, (of, groups.runs.y - top[of], groups.runs.first - left[of]), 1)
    np.add.at(edges, (of, groups.runs.y - top[of], groups.runs.last + 1 - left[of]), -1)
    own = np.cumsum(edges[:, :, :-1], axis=2, dtype=np.int8) > 0
    return own, top[:, None, None] + np.arange(high)[:, None], left[:, None, None] + np.arange(wide)


def _packed(used: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(n, N) flat places of the used pixels of each patch, then unused ones up to the same number."""
    flat = used.reshape(len(used), -1)
    most = max(int(flat.sum(1).max(initial=1)), 1)
    return np.argsort(~flat, axis=1, kind="stable")[:, :most]


def _ground(grey: Floats, dark: NDArray[np.bool_], threshold: float) -> Floats:
    """(n) lower quartile of the dark pixels round each group, as the rim is among them; never above the threshold."""
    some = np.sort(np.where(dark, grey, np.inf), axis=1)
    quartile = some[np.arange(len(some)), np.maximum(dark.sum(1) - 1, 0) // 4]
    return np.asarray(np.minimum(np.where(dark.any(1), quartile, 0.0), threshold))


def _white(grey: Floats, white: NDArray[np.bool_], peak: Floats, noise: Floats) -> Floats:
    """(n) the peak where more pixels have exactly it than noise would bring there; else inf.

    Of pixels on a plateau with noise, few share the highest level; of clipped ones most do.
    """
    at = (white & (grey == peak[:, None])).sum(1)
    reach = np.maximum(3 * np.sqrt(noise.max(1)), 1.0)
    near = (white & (grey > (peak - reach)[:, None])).sum(1)
    return np.where(at > 0.5 * near, peak, np.inf)
