"""The former method (KISS 2): white pixels within a range of neighbourhood form a group; what is too large is split.

From one white pixel on, all that are no farther than the range of neighbourhood r in x and in y from any pixel of the
group are collected. With one neighbour to the left on the same line, and the nearest to the left and to the right on
each of the r lines above, no link is lost (A): of the pixels in a window of r to one side of a pixel, every two are no
farther than r from each other.

A group of pixels has

    w = max x − min x + 1,    h = max y − min y + 1                      (1)

(with both ends counted; see `groups`). Limits for both are calculated in every field from the average of its groups,

    W = f mean w,    H = f mean h                                        (B)

with a factor f, and a group wider or higher is cut harshly into ⌈w / W⌉ × ⌈h / H⌉ equal rectangles (C). The paper does
not print f.

Source: Shafiq, Tümer and Güler 2001 (KISS), section 2, equation 1.
"""

from __future__ import annotations

import numpy as np
import scipy

from ...data.array_types import Floats, Ints
from .pixel_groups import KissGroups, Rectangles, numbered, rectangles, separated


def neighbour_groups(y: Ints, x: Ints, *, neighbourhood: int, height: int, width: int) -> KissGroups:
    """Groups of white pixels (N), (N) in scan order of frames of this height and width, px."""
    n = len(y)
    stride = width + neighbourhood
    key = (y + y // height * neighbourhood) * stride + x
    index = np.arange(n)
    near = np.diff(key) <= neighbourhood
    links = [(index[1:][near], index[:-1][near])]
    for dy in range(1, neighbourhood + 1):
        here = key - dy * stride
        right = np.searchsorted(key, here, side="right")
        left = np.maximum(right - 1, 0)
        near = np.abs(key[left] - here) <= neighbourhood
        links.append((index[near], left[near]))
        near = np.abs(key[np.minimum(right, n - 1)] - here) <= neighbourhood
        links.append((index[near], right[near]))
    a, b = (np.concatenate(side) for side in zip(*links, strict=True))  # (A)
    _, label = scipy.sparse.csgraph.connected_components(
        scipy.sparse.coo_array((np.ones(len(a), np.bool_), (a, b)), shape=(n, n)), directed=False
    )
    return numbered(y, x, x, label.astype(np.int64), height=height)


def adaptive_limits(groups: KissGroups, *, factor: float, frames: int) -> tuple[Floats, Floats]:
    """Width (frames) and height (frames) beyond which groups are split, px."""
    brect, number = rectangles(groups), np.maximum(np.bincount(groups.frame, minlength=frames), 1)
    wide, high = (np.bincount(groups.frame, side, frames) / number for side in (brect.width, brect.height))
    return factor * wide, factor * high  # (B)


def split_harshly(groups: KissGroups, *, wide: Floats, high: Floats) -> KissGroups:
    """Groups wider or higher than the limits (frames) of their frame, px, cut into equal rectangles."""
    brect = rectangles(groups)
    columns = np.ceil(brect.width / wide[groups.frame]).astype(np.int64)  # (C)
    rows = np.ceil(brect.height / high[groups.frame]).astype(np.int64)
    large = np.flatnonzero(columns * rows > 1)
    cells = (columns * rows)[large]
    parent = np.repeat(large, cells)
    cell = np.arange(cells.sum()) - np.repeat(np.cumsum(cells) - cells, cells)
    left, right = _band(brect.left[parent], brect.width[parent], cell % columns[parent], columns[parent])
    top, bottom = _band(brect.top[parent], brect.height[parent], cell // columns[parent], rows[parent])
    return separated(groups, parent, Rectangles(left, right, top, bottom))


def _band(start: Ints, length: Ints, k: Ints, n: Ints) -> tuple[Ints, Ints]:
    """First and last pixel of the kth of n equal parts of `length` pixels from `start` on."""
    return start + k * length // n, start + (k + 1) * length // n - 1
