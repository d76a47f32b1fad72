"""Sums over the pixels of each group and over those around it.

Within a line a widened group is one stretch of pixels L … R (gaps inside are filled), and the sums of
1, x and x² over a stretch are polynomials of L and R (5); only Σ I, Σ I x and Σ I x² need the pixels themselves.
Widening by one pixel takes the least L and greatest R of a line and its two neighbours, and one more (6).
(The numbers go on from those of `detect.moments`.)

All are sums of whole numbers, so that the compiled function and NumPy give the same to the last bit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Bools, Floats, GreyLevels, Ints
from .array_checks import GREY, INT, Arrays
from .compiled_library import library
from .run_groups import MOST_WIDE

MARGIN = 2
"""Lines: one for the rim, one for the background; by definition."""

SUMS = 16
"""Rows of what `sum_pixels` returns; by definition."""

EMPTY = 1 << 40
"""Beyond every column; by definition."""

_GROUPS = Arrays(images=(GREY, "n", "H", "W"), start=(INT, "S"), y=(INT, "R"), first=(INT, "R"), last=(INT, "R"))


def sum_pixels(images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints) -> Floats:
    """Sums over the pixels of G groups of runs.

    Args:
        images: (n, H, W) frames.
        start: (G+1) where each group starts among the runs.
        y: (R) scan line of each run in the tall image of all frames; in scan order within a group.
        first: (R) first column.
        last: (R) last column.

    Returns:
        (16, G): of each group, widened by a pixel, the sums of 1, x, y, x², xy, y², with x from the group's left and y
        from its top, px; the same weighed by the grey level; the greatest level; and of the pixels around it the number
        and the sums of the grey level and of its square.

    Raises:
        ValueError: an array has another shape or dtype, images are too wide, or a group is not in one of the frames.
    """
    images, start, y, first, last = _GROUPS(images, start, y, first, last)
    n, height, width = images.shape
    g = len(start) - 1
    if g < 0 or width > MOST_WIDE:
        raise ValueError(
            f"found {len(start)} starts and images {width} px wide, wanted 1 or more and {MOST_WIDE} or less"
        )
    if compiled := library():
        space, out = np.empty((2, height + 4 * MARGIN), np.int64), np.empty((SUMS, g))
        function = compiled.sum_pixels_8 if images.dtype == np.uint8 else compiled.sum_pixels_16
        good = function(images, n * height, height, width, g, len(y), start, y, first, last, space, out)
    elif (good := number_good(images.shape, start, y, first, last)) == g:
        out = _numpy_sums(images, start, y, first, last)
    if good < g or (g == 0 and len(y)):
        raise ValueError(f"group {good} of {g} does not lie in one of the {n} frames of {width} × {height} px")
    return out


def number_good(shape: tuple[int, ...], start: Ints, y: Ints, first: Ints, last: Ints) -> int:
    """How many groups, from the first on, are runs in scan order in one of the frames of this shape (n, H, W)."""
    n, height, width = shape
    size = np.diff(start)
    if len(size) == 0 or height == 0:
        return 0
    if start[0] != 0 or start[-1] != len(y) or (size <= 0).any() or (start > len(y)).any():
        return 0
    of = np.repeat(np.arange(len(size)), size)
    frame = y // height
    wrong = (y < 0) | (y >= n * height) | (frame != frame[start[of]]) | (first < 0) | (last < first) | (last >= width)
    before = (y[1:] < y[:-1]) | ((y[1:] == y[:-1]) & (first[1:] <= last[:-1]))
    wrong[1:] |= before & (of[1:] == of[:-1])
    return int(of[wrong.argmax()]) if wrong.any() else len(size)


class _Groups(NamedTuple):
    """G groups: where each starts (G+1) in the runs (3, R); frame, left, top, bottom (G)."""

    start: Ints
    runs: tuple[Ints, Ints, Ints]
    frame: Ints
    left: Ints
    top: Ints
    bottom: Ints


class _Stretches(NamedTuple):
    """Pixels left … right of `line` of the tall image, of group `of` (index); right < left where empty."""

    of: Ints
    line: Ints
    left: Ints
    right: Ints


def _numpy_sums(images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints) -> Floats:
    if len(y) == 0:
        return np.zeros((SUMS, 0))
    head, n, height = start[:-1], len(start) - 1, images.shape[1]
    left = np.minimum.reduceat(first, head)
    groups = _Groups(start, (y, first, last), y[head] // height, left, y[head], y[start[1:] - 1])
    rim, around = _widened(groups, *images.shape[1:])
    return np.vstack([_geometry(rim, groups), *_grey(images, rim, groups), *_ring(images, around, n)])


def _widened(groups: _Groups, height: int, width: int) -> tuple[_Stretches, _Stretches]:
    """The stretches of each group with its rim, and the background's left and right of it, within the image."""
    lines = groups.bottom - groups.top + 1 + 2 * MARGIN
    begin = np.cumsum(lines) - lines
    of = np.repeat(np.arange(len(lines)), lines)
    line = np.arange(len(of)) + np.repeat(groups.top - MARGIN - begin, lines)
    left, right = np.full(len(of), EMPTY), np.full(len(of), -EMPTY)
    y, first, last = groups.runs
    row = y + np.repeat(begin + MARGIN - groups.top, np.diff(groups.start))
    fresh = np.concatenate([[True], row[1:] != row[:-1]])
    left[row[fresh]] = first[fresh]
    right[row] = last  # of several runs in one line the last stays
    inside = line // height == groups.frame[of]
    rim_left, rim_right = _wider(left, right)
    out_left, out_right = _wider(rim_left, rim_right)
    dark = rim_right < rim_left  # lines above and below the rim are background all along
    rim = _clipped(of, line, rim_left, rim_right, width, inside)
    before = _clipped(of, line, out_left, np.where(dark, out_right, rim_left - 1), width, inside)
    after = _clipped(of, line, np.where(dark, EMPTY, rim_right + 1), out_right, width, inside)
    return rim, _Stretches(*(np.concatenate(pair) for pair in zip(before, after, strict=True)))


def _wider(left: Ints, right: Ints) -> tuple[Ints, Ints]:
    """One pixel more all round; empty lines between groups keep them apart."""
    low, high = left.copy(), right.copy()
    np.minimum(low[1:], left[:-1], out=low[1:])
    np.minimum(low[:-1], left[1:], out=low[:-1])
    np.maximum(high[1:], right[:-1], out=high[1:])
    np.maximum(high[:-1], right[1:], out=high[:-1])
    return low - 1, high + 1  # (6)


def _clipped(
    of: Ints,
    line: Ints,
    left: Ints,
    right: Ints,
    width: int,
    inside: Bools,
) -> _Stretches:
    """The part of the stretches within the image, without empty ones."""
    left, right = np.maximum(left, 0), np.minimum(right, width - 1)
    kept = inside & (left <= right)
    return _Stretches(of[kept], line[kept], left[kept], right[kept])


def _pixels(stretches: _Stretches, width: int) -> tuple[Ints, Ints]:
    """Flat index (N) of every pixel, and where each stretch starts among them (stretches)."""
    n = stretches.right - stretches.left + 1
    start = np.cumsum(n) - n
    return np.arange(n.sum()) + np.repeat(stretches.line * width + stretches.left - start, n), start


def _ring(images: GreyLevels, around: _Stretches, n_groups: int) -> tuple[Floats, Floats, Floats]:
    """Of the pixels around each group (G): number, sum of grey levels, and of their squares."""
    pixel, start = _pixels(around, images.shape[2])
    if len(pixel) == 0:
        return np.zeros(n_groups), np.zeros(n_groups), np.zeros(n_groups)
    grey = images.reshape(-1)[pixel].astype(np.int64)
    columns = around.right - around.left + 1, np.add.reduceat(grey, start), np.add.reduceat(grey * grey, start)
    number, total, squares = (np.bincount(around.of, column, n_groups).astype(np.float64) for column in columns)
    return number, total, squares


def _geometry(rim: _Stretches, groups: _Groups) -> Floats:
    """The sums (6, G) of pixels that all weigh 1."""
    left, right = (side - groups.left[rim.of] for side in (rim.left, rim.right))
    n = right - left + 1
    x = n * (left + right) / 2
    xx = (right * (right + 1) * (2 * right + 1) - (left - 1) * left * (2 * left - 1)) / 6  # (5)
    return _by_group(rim, groups, n, x, xx)


def _grey(images: GreyLevels, rim: _Stretches, groups: _Groups) -> tuple[Floats, Floats]:
    """The sums (6, G) of pixels that weigh their grey level, and the greatest level (G)."""
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


def _by_group(rim: _Stretches, groups: _Groups, one: NDArray[Any], x: NDArray[Any], xx: NDArray[Any]) -> Floats:
    """The sums (6, G) from Σ, Σ x and Σ x² of every stretch."""
    y = rim.line - groups.top[rim.of]
    columns = np.stack([one, x, y * one, xx, y * x, y * y * one]).astype(np.float64)
    return np.add.reduceat(columns, _heads(rim, groups), axis=1)


def _heads(rim: _Stretches, groups: _Groups) -> Ints:
    """(G) the first stretch of each group; every group has one."""
    return np.searchsorted(rim.of, np.arange(len(groups.top)))
