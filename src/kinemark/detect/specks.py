"""Which small groups of white pixels are images of something, and which are single pixels of the sensor.

A lens blurs even the smallest marker over its neighbours, and a hot pixel or one of noise stands alone. So a group that
is one pixel wide or high counts only if the light S of the group and its rim, above the mean of the pixels around, is
that of at least `SPECK` pixels as bright as its brightest one: S / (peak − b) (5) of `moments`, 1 for a lone pixel.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, GreyLevels
from .grouping import PixelGroups
from .sums import pixel_sums

SPECK = 1.5
"""px²; a lone pixel has 1, and a point that a lens blurs by half a pixel (standard deviation) 2.1 or more; chosen."""


def narrow(groups: PixelGroups) -> Bools:
    """(G) whether a group is one pixel wide or high."""
    return np.asarray((groups.right == groups.left) | (groups.bottom == groups.top))


def blurred(images: GreyLevels, groups: PixelGroups) -> Bools:
    """(G) whether a group of frames (n, H, W) is wider and higher than a pixel, or has light round it."""
    thin = narrow(groups)
    good = ~thin
    if thin.any():
        sums = pixel_sums(images, groups.keep(thin))
        ground = sums.ring_grey / np.maximum(sums.ring, 1)
        light = sums.grey.one - ground * sums.ones.one
        good[thin] = light >= SPECK * np.maximum(sums.peak - ground, 1.0)
    return good
