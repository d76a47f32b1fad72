"""Overlapped markers (KISS 2.3.2): two markers one above the other to a side, in one group.

Such a group fills little of its bounding rectangle: WhitePixels / TotalPixels (4, 5 in `groups`) is small, where a disc
has π/4. Let row 1 be the top row of the rectangle and row n its bottom row, x₁ and x₂ the left and the right boundary
pixel of a row, and xᵘ and xˡ the mid-points of rows 1 and n. Then the group is

    upper-left   if |xˡ − xᵘ| > |xᵘ − x₁¹|,  |xˡ − xᵘ| > 3,  x₂¹ < x₁ⁿ or |x₂¹ − x₁ⁿ| < w
    upper-right  if |xˡ − xᵘ| > |xᵘ − x₁¹|,  |xˡ − xᵘ| > 3,  x₁¹ > x₂ⁿ or |x₁¹ − x₂ⁿ| < w              (6)

In the text that we have, scanned and read by a machine, some indices are doubtful: 1 (the first row) and l (lower)
look alike, and the last difference of the second line is printed as that of the first, |x₂¹ − x₁ⁿ|, where the sides
must change with the kind. That w be the width of the rectangle, as it is in (4), is hardly meant: all rows lie within
the rectangle, the third condition would always be true, and nothing would tell the kinds apart. Here w is a limit of
its own, `row_overlap`: how far the two rows may reach over each other. Either line's third condition is

    x₂¹ − x₁ⁿ < w   upper-left,      x₂ⁿ − x₁¹ < w   upper-right          (6')

since a < b or |a − b| < w is a − b < w. The sign of xˡ − xᵘ says which of the two is asked. On simulated pairs of
discs the condition changes one result in a hundred or fewer, whatever w above 3 px.

The new groups have xᵘ and xˡ as the mid-points of their columns, and reach to the side of the rectangle that is theirs:
their widths are

    upper-left    2 (xᵘ − brect.x₁) + 1  and  2 (brect.x₂ − xˡ) + 1
    upper-right   2 (brect.x₂ − xᵘ) + 1  and  2 (xˡ − brect.x₁) + 1                              (7)

(+ 1 for both ends counted). The paper says nothing of their heights. We take the same rule turned by a right angle:
with yᵘ the middle of the rows in which the upper marker reaches its side of the rectangle, and yˡ that of the lower
one,

    heights       2 (yᵘ − brect.y₁) + 1  and  2 (brect.y₂ − yˡ) + 1                              (8)

so that each marker has an envelope about its own middle, and its pixels are those of the group within it. Where the
envelopes share pixels, both markers have them.

Source: Shafiq, Tümer and Güler 2001 (KISS), 2.3.2, equations 4 to 6.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Floats, Ints
from .pixel_groups import KissGroups, Rectangles, rectangles, separated, white_pixels


class WhiteRows(NamedTuple):
    """Of each group (G): the boundary pixels of the top row, 1, and of the bottom row, n."""

    x1_1: Ints
    x2_1: Ints
    x1_n: Ints
    x2_n: Ints

    @property
    def upper(self) -> Floats:
        """Mid-point of the top row, xᵘ."""
        return (self.x1_1 + self.x2_1) / 2

    @property
    def lower(self) -> Floats:
        """Mid-point of the bottom row, xˡ."""
        return (self.x1_n + self.x2_n) / 2


def separate_overlapped(groups: KissGroups, *, fill: float, shift: float, row_overlap: float) -> KissGroups:
    """The groups, each overlapped one replaced by the two markers that it is made of."""
    brect, rows = rectangles(groups), _rows(groups)
    ul, ur = kinds_of_overlap(groups, fill=fill, shift=shift, row_overlap=row_overlap)
    parent = np.repeat(np.flatnonzero(ul | ur), 2)
    upper = np.arange(len(parent)) % 2 == 0
    at_left = ul[parent] == upper
    x = np.where(upper, rows.upper[parent], rows.lower[parent])
    left, right, top, bottom = (side[parent] for side in brect)
    y = _middle_at_side(groups, brect)[np.where(at_left, 0, 1), parent]
    return separated(
        groups,
        parent,
        Rectangles(
            np.where(at_left, left, np.ceil(2 * x - right).astype(np.int64)),  # (7)
            np.where(at_left, np.floor(2 * x - left).astype(np.int64), right),
            np.where(upper, top, np.ceil(2 * y - bottom).astype(np.int64)),  # (8)
            np.where(upper, np.floor(2 * y - top).astype(np.int64), bottom),
        ),
    )


def kinds_of_overlap(
    groups: KissGroups, *, fill: float, shift: float, row_overlap: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(G) whether a group is of the kind upper-left, and (G) whether it is of the kind upper-right."""
    rows = _rows(groups)
    moved = rows.lower - rows.upper
    both = white_pixels(groups) < fill * rectangles(groups).total_pixels  # (4) (5)
    both &= (np.abs(moved) > np.abs(rows.upper - rows.x1_1)) & (np.abs(moved) > shift)  # (6)
    ul = both & (moved > 0) & (rows.x2_1 - rows.x1_n < row_overlap)  # (6')
    ur = both & (moved < 0) & (rows.x2_n - rows.x1_1 < row_overlap)
    return ul, ur


def _rows(groups: KissGroups) -> WhiteRows:
    """The top and the bottom row of each group; a row in several runs counts from the first to the last."""
    if len(groups.frame) == 0:
        return WhiteRows(*(np.zeros(0, np.int64),) * 4)
    brect, head = rectangles(groups), groups.start[:-1]
    sides = []
    for line in (brect.top, brect.bottom):
        there = groups.y == line[groups.of]
        sides.append(np.minimum.reduceat(np.where(there, groups.first, np.iinfo(np.int64).max), head))
        sides.append(np.maximum.reduceat(np.where(there, groups.last, -1), head))
    return WhiteRows(*sides)


def _middle_at_side(groups: KissGroups, brect: Rectangles) -> Floats:
    """(2, G) the middle of the lines in which a group reaches its rectangle's left side, and its right side."""
    of, n = groups.of, len(groups.frame)
    middle = np.empty((2, n))
    for k, at_side in enumerate((groups.first == brect.left[of], groups.last == brect.right[of])):
        middle[k] = np.bincount(of[at_side], groups.y[at_side], n) / np.bincount(of[at_side], minlength=n)
    return middle
