"""Which groups are noise, and which are no valid marker (KISS 2.2, 2.3.3, 2.3.4).

Noise, isolated pixels and groups one pixel wide or high, is removed before anything is computed of it: an
image may have thousands of such specks, and nobody wants them in a file. Everything else is kept, with
the reason if it does not go on to matching, so that the user sees what was left out and why.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data import Validity
from .centroids_method import Centroids
from .grouping import PixelGroups


def remove_noise(groups: PixelGroups, *, method: Centroids) -> PixelGroups:
    """Only the groups at least `min_width` wide and high."""
    least = method.limits.min_width
    wide = groups.right - groups.left + 1 >= least
    high = groups.bottom - groups.top + 1 >= least
    return groups.keep(wide & high)


def judge(groups: PixelGroups, *, height: int, width: int, method: Centroids) -> NDArray[np.uint8]:
    """(G) a `Validity` for each group of frames of this height and width."""
    w, h = groups.right - groups.left + 1, groups.bottom - groups.top + 1
    edge = (groups.left == 0) | (groups.right == width - 1)
    top = groups.frame * height
    edge |= (groups.top == top) | (groups.bottom == top + height - 1)
    limits = method.limits
    reasons = {
        Validity.NOT_ROUND: np.maximum(w, h) > limits.max_aspect * np.minimum(w, h),
        Validity.TOO_SMALL: groups.area < limits.min_area,
        Validity.AT_EDGE: edge,
        Validity.TOO_LARGE: groups.area > limits.max_area,
    }
    validity = np.full(len(w), Validity.VALID, np.uint8)
    for reason, holds in reasons.items():  # the last one counts
        validity[holds] = reason
    return validity
