"""Sums over the pixels of each group and over those around it; how they are taken is in `native.pixel_sums`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import native
from ..data.array_types import Floats, GreyLevels
from .grouping import PixelGroups


class Sums(NamedTuple):
    """Per group (G): sums of 1, x, y, x², xy, y² over its pixels, times a weight; x from `left`, y from `top`."""

    one: Floats
    x: Floats
    y: Floats
    xx: Floats
    xy: Floats
    yy: Floats

    def about(self, u: Floats, v: Floats) -> Floats:
        """(3, G) the elements xx, xy and yy of Σ (x − ū)(x − ū)ᵀ with the same weights."""
        xx = self.xx - 2 * u * self.x + u * u * self.one
        xy = self.xy - u * self.y - v * self.x + u * v * self.one
        yy = self.yy - 2 * v * self.y + v * v * self.one
        return np.stack([xx, xy, yy])


class PixelSums(NamedTuple):
    """What is known of the pixels of G groups, each (G).

    Attributes:
        ones: of the widened groups, each pixel weighing 1; grey: weighing its grey level.
        peak: greatest grey level in the widened group.
        ring: number of pixels around it, 0 where none is within the image; ring_grey, ring_squares: the sums of their
            grey levels and of the squares of these.
    """

    ones: Sums
    grey: Sums
    peak: Floats
    ring: Floats
    ring_grey: Floats
    ring_squares: Floats


def pixel_sums(images: GreyLevels, groups: PixelGroups) -> PixelSums:
    """The sums of groups in frames (n, H, W) of grey levels."""
    rows = native.sum_pixels(images, groups.start, *groups.runs)
    return PixelSums(Sums(*rows[:6]), Sums(*rows[6:12]), *rows[12:])
