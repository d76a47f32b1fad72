"""Marker size (KISS 2.3.4): what is too large or too small stays, marked as invalid, and is not split.

Large groups are the lights of opposite cameras, small ones reflections. Only after the other tests is a group known to
have the shape of one marker, so that its size says something. The paper is silent about markers that the image's
edge cuts through; here they are invalid too, as the centroid of a part is not that of the marker.

Source: Shafiq, Tümer and Güler 2001 (KISS), 2.3.4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...data import Validity
from .pixel_groups import KissGroups, rectangles, white_pixels


def size_validity(
    groups: KissGroups, *, min_area: float, max_area: float, height: int, width: int
) -> NDArray[np.uint8]:
    """(G) a `Validity` for each group of frames of this height and width, px; the first reason that holds."""
    brect, white = rectangles(groups), white_pixels(groups)
    edge = (brect.left == 0) | (brect.right == width - 1)
    edge |= (brect.top % height == 0) | (brect.bottom % height == height - 1)
    reasons = {
        Validity.TOO_LARGE: white > max_area,
        Validity.AT_EDGE: edge,
        Validity.TOO_SMALL: white < min_area,
    }
    return np.select(list(reasons.values()), list(reasons), Validity.VALID).astype(np.uint8)
