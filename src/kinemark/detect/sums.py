"""Sums over the pixels of each group and over those around it.

Within a line a widened group is one stretch of pixels L … R (gaps inside are filled), and the sums of
1, x and x² over a stretch are polynomials of L and R (5); only Σ I, Σ I x and Σ I x² need the pixels themselves.
Widening by one pixel takes the least L and greatest R of a line and its two neighbours, and one more (6).
(The numbers go on from those of `moments`.)

All are sums of whole numbers, so that the compiled kernel and NumPy give the same to the last bit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.runs import begins
from .compiled import library
from .grouping import PixelGroups

MARGIN = 2  # one line for the rim, one for the background
EMPTY = 1 << 40


class Stretches(NamedTuple):
    """Pixels left … right of `line` of the tall image, of group `of` (index); right < left where empty."""

    of: NDArray[np.int64]
    line: NDArray[np.int64]
    left: NDArray[np.int64]
    right: NDArray[np.int64]


class Sums(NamedTuple):
    """Per group (G): sums of 1, x, y, x², xy, y² over its pixels, times a weight; x from `left`, y from `top`."""

    one: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    xx: NDArray[np.float64]
    xy: NDArray[np.float64]
    yy: NDArray[np.float64]

    def about(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
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
    peak: NDArray[np.float64]
    ring: NDArray[np.float64]
    ring_grey: NDArray[np.float64]
    ring_squares: NDArray[np.float64]


def pixel_sums(images: NDArray[np.uint8 | np.uint16], groups: PixelGroups) -> PixelSums:
    """The sums of groups in frames (n, H, W) of grey levels."""
    if kernel := library():
        rows = kernel.sums(images, groups.start, *groups.runs)
        return PixelSums(Sums(*rows[:6]), Sums(*rows[6:12]), *rows[12:])
    return _plain_sums(images, groups)


def _plain_sums(images: NDArray[np.uint8 | np.uint16], groups: PixelGroups) -> PixelSums:
    if len(groups.area) == 0:
        rows = np.zeros((16, 0))
        return PixelSums(Sums(*rows[:6]), Sums(*rows[6:12]), *rows[12:])
    rim, around = _widened(groups, *images.shape[1:])
    grey, peak = _grey(images, rim, groups)
    return PixelSums(_geometry(rim, groups), grey, peak, *_ring(images, around, len(groups.area)))


def _widened(groups: PixelGroups, height: int, width: int) -> tuple[Stretches, Stretches]:
    """The stretches of each group with its rim, and the background's left and right of it, within the image."""
    lines = groups.bottom - groups.top + 1 + 2 * MARGIN
    begin = np.cumsum(lines) - lines
    of = np.repeat(np.arange(len(lines)), lines)
    line = np.arange(len(of)) + np.repeat(groups.top - MARGIN - begin, lines)
    left, right = np.full(len(of), EMPTY), np.full(len(of), -EMPTY)
    y, first, last = groups.runs
    row = y + np.repeat(begin + MARGIN - groups.top, np.diff(groups.start))
    fresh = begins(row)
    left[row[fresh]] = first[fresh]
    right[row] = last  # of several runs in one line the last stays
    inside = line // height == groups.frame[of]
    rim_left, rim_right = _wider(left, right)
    out_left, out_right = _wider(rim_left, rim_right)
    dark = rim_right < rim_left  # lines above and below the rim are background all along
    rim = _clipped(of, line, rim_left, rim_right, width, inside)
    before = _clipped(of, line, out_left, np.where(dark, out_right, rim_left - 1), width, inside)
    after = _clipped(of, line, np.where(dark, EMPTY, rim_right + 1), out_right, width, inside)
    return rim, Stretches(*(np.concatenate(pair) for pair in zip(before, after, strict=True)))


def _wider(left: NDArray[np.int64], right: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """One pixel more all round; empty lines between groups keep them apart."""
    low, high = left.copy(), right.copy()
    np.minimum(low[1:], left[:-1], out=low[1:])
    np.minimum(low[:-1], left[1:], out=low[:-1])
    np.maximum(high[1:], right[:-1], out=high[1:])
    np.maximum(high[:-1], right[1:], out=high[:-1])
    return low - 1, high + 1  # (6)


def _clipped(
    of: NDArray[np.int64],
    line: NDArray[np.int64],
    left: NDArray[np.int64],
    right: NDArray[np.int64],
    width: int,
    inside: NDArray[np.bool_],
) -> Stretches:
    """The part of the stretches within the image, without empty ones."""
    left, right = np.maximum(left, 0), np.minimum(right, width - 1)
    kept = inside & (left <= right)
    return Stretches(of[kept], line[kept], left[kept], right[kept])


def _pixels(stretches: Stretches, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Flat index (N) of every pixel, and where each stretch starts among them (stretches)."""
    n = stretches.right - stretches.left + 1
    start = np.cumsum(n) - n
    return np.arange(n.sum()) + np.repeat(stretches.line * width + stretches.left - start, n), start


def _ring(
    images: NDArray[np.uint8 | np.uint16], around: Stretches, n_groups: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Of the pixels around each group (G): number, sum of grey levels, and of their squares."""
    pixel, start = _pixels(around, images.shape[2])
    if len(pixel) == 0:
        return np.zeros(n_groups), np.zeros(n_groups), np.zeros(n_groups)
    grey = images.reshape(-1)[pixel].astype(np.int64)
    columns = around.right - around.left + 1, np.add.reduceat(grey, start), np.add.reduceat(grey * grey, start)
    number, total, squares = (np.bincount(around.of, column, n_groups).astype(np.float64) for column in columns)
    return number, total, squares


def _geometry(rim: Stretches, groups: PixelGroups) -> Sums:
    """`Sums` of pixels that all weigh 1."""
    left, right = (side - groups.left[rim.of] for side in (rim.left, rim.right))
    n = right - left + 1
    x = n * (left + right) / 2
    xx = (right * (right + 1) * (2 * right + 1) - (left - 1) * left * (2 * left - 1)) / 6  # (5)
    return _by_group(rim, groups, n, x, xx)


def _grey(
    images: NDArray[np.uint8 | np.uint16], rim: Stretches, groups: PixelGroups
) -> tuple[Sums, NDArray[np.float64]]:
    """`Sums` of pixels that weigh their grey level, and the greatest level (G)."""
    pixel, start = _pixels(rim, images.shape[2])
    raw = images.reshape(-1)[pixel]
    grey = raw.astype(np.int64)
    total = np.add.reduceat(grey, start)
    zero = rim.line * images.shape[2] + groups.left[rim.of]  # pixel of x = 0
    x = np.add.reduceat(grey * pixel, start) - zero * total
    local = pixel - np.repeat(zero, rim.right - rim.left + 1)
    xx = np.add.reduceat(grey * local * local, start)
    peak = np.maximum.reduceat(raw, start[_heads(rim, groups)])
    return _by_group(rim, groups, total, x, xx), peak.astype(np.float64)


def _by_group(rim: Stretches, groups: PixelGroups, one: NDArray[Any], x: NDArray[Any], xx: NDArray[Any]) -> Sums:
    """`Sums` (G) from Σ, Σ x and Σ x² of every stretch."""
    y = rim.line - groups.top[rim.of]
    columns = np.stack([one, x, y * one, xx, y * x, y * y * one]).astype(np.float64)
    return Sums(*np.add.reduceat(columns, _heads(rim, groups), axis=1))


def _heads(rim: Stretches, groups: PixelGroups) -> NDArray[np.int64]:
    """(G) the first stretch of each group; every group has one."""
    return np.searchsorted(rim.of, np.arange(len(groups.area)))
