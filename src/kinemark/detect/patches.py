"""Groups cut out of their images, with what else lies there left out, as `shape_images.Patches`.

A patch holds the group's own white pixels and all pixels within `MARGIN` of them; white pixels of other groups and
their neighbours are left out (`native.group_pixels`). Places count from the centre of the group's rectangle, and v is
divided by the aspect of a disc's image (its height by its width), so that discs are round there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import native
from ..data.array_types import Bools, Floats, GreyLevels, Ints
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


class Uncut(NamedTuple):
    """What `cut_out` makes patches of: n groups of frames that need not be at hand any longer.

    Attributes:
        start: (n+1) where each group's pixels start among all: column, line in its frame, grey level, own and white.
        middle: (n, 2) px, the centre of its rectangle. variance: (n) of the noise in its frame, grey levels squared.
    """

    start: Ints
    column: Ints
    line: Ints
    grey: Floats
    own: Bools
    middle: Floats
    variance: Floats

    @property
    def number(self) -> Ints:
        """(n) pixels of each."""
        return np.diff(self.start)


def pixels_of(images: GreyLevels, groups: PixelGroups, *, threshold: float, variance: Floats) -> Uncut:
    """The pixels of groups of frames (n, H, W) with noise variance (n)."""
    found = native.cut_pixels(images, groups.start, *groups.runs, threshold=threshold, margin=MARGIN)
    top = groups.frame * images.shape[1]
    middle = np.stack([(groups.left + groups.right) / 2, (groups.top + groups.bottom) / 2 - top], -1)
    return Uncut(*found, middle, variance[groups.frame])


def together(parts: Sequence[Uncut]) -> Uncut:
    """Groups of several batches as one."""
    start = np.concatenate([[0], np.cumsum(np.concatenate([part.number for part in parts]))])
    return Uncut(start, *(np.concatenate(column) for column in list(zip(*parts, strict=True))[1:]))


def cut_out(groups: Uncut, index: Ints, *, threshold: float, shot: float, aspect: float) -> CutOut:
    """The patches of some groups; each is filled up with copies of its first pixel, of weight 0."""
    number = groups.number[index]
    place = np.arange(number.max(initial=1))
    used = place < number[:, None]
    pixel = groups.start[index, None] + np.where(used, place, 0)
    white, grey, middle = groups.own[pixel] & used, groups.grey[pixel], groups.middle[index]
    x, y = (at[pixel] - m[:, None] for at, m in zip((groups.column, groups.line), middle.T, strict=True))
    ground = _ground(grey, used & ~white, threshold)
    peak = np.where(white, grey, 0).max(1)
    noise = groups.variance[index, None] + shot * np.maximum(grey - ground[:, None], 0.0)
    full = np.where((white & (grey == peak[:, None])).sum(1) >= SATURATED, _white(grey, white, peak, noise), np.inf)
    patches = Patches(x, y / aspect, grey, used / noise, full)
    return CutOut(patches, white, middle, ground, peak, np.full(len(peak), 1 / aspect))


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
