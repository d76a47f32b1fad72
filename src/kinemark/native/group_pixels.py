"""The pixels of single groups: cut out with what is round them, the brightest, and sums over those at a peak.

Groups are given by their runs, as in `pixel_sums`. A pixel within the margin of a group is left out where it, or one of
the eight pixels round it, is white and not the group's own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, GreyLevels, Ints
from .array_checks import FLOAT, GREY, INT, Arrays
from .compiled_library import library
from .pixel_sums import number_good
from .run_groups import MOST_WIDE

SUMS = 5
"""Rows of what `sum_peaks` returns; by definition."""

MOST_MARGIN = 1 << 10
"""px; no marker is so large; chosen."""

_GROUPS = {
    "images": (GREY, "n", "H", "W"),
    "start": (INT, "S"),
    **{name: (INT, "R") for name in ("y", "first", "last")},
}
_CUT = Arrays(**_GROUPS)  # type: ignore[arg-type]  # a dict of them, which are two signatures' first five
_PEAKS = Arrays(**_GROUPS, peak=(FLOAT, "G"), near=(FLOAT, "G"), uv=(FLOAT, "G", 2))  # type: ignore[arg-type]


class GroupPixels(NamedTuple):
    """Q pixels of G groups, those of each in scan order.

    Attributes:
        start: (G+1) rows start[g]:start[g+1] are those of group g.
        column, line: (Q) in the group's own frame.
        grey: (Q) grey levels.
        own: (Q) whether it is one of the group's own white pixels.
    """

    start: Ints
    column: Ints
    line: Ints
    grey: Floats
    own: Bools


def cut_pixels(
    images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints, *, threshold: float, margin: int
) -> GroupPixels:
    """The pixels of G groups of runs, and those round them.

    Args:
        images: (n, H, W) frames.
        start: (G+1) where each group starts among the runs.
        y: (R) scan line of each run in the tall image of all frames; in scan order within a group.
        first: (R) first column.
        last: (R) last column.
        threshold: grey level above which a pixel is white.
        margin: how far round a group pixels are taken, px.

    Raises:
        ValueError: an array has another shape or dtype, images are too wide, a group is not in one of the frames, or
            the margin is negative or absurdly large.
    """
    images, start, y, first, last = _CUT(images, start, y, first, last)
    n, height, width = images.shape
    level = int(np.floor(np.clip(np.nan_to_num(threshold, nan=-1.0), -1.0, 65535.0)))
    if not 0 <= margin <= MOST_MARGIN:
        raise ValueError(f"margin is {margin}, wanted 0 to {MOST_MARGIN} px")
    _check(number_good(images.shape, start, y, first, last), images, start, y)
    if not (compiled := library()):
        return _numpy_cut(images, start, y, first, last, level, margin)
    g, size = len(start) - 1, _rectangles(start, y, first, last, margin + 1)
    room = int(size.sum())
    ends, (column, line), grey = np.empty(g + 1, np.int64), np.empty((2, room), np.int64), np.empty(room)
    own, most = np.empty(room, np.bool_), int(size.max(initial=0))
    function = compiled.cut_pixels_8 if images.dtype == np.uint8 else compiled.cut_pixels_16
    runs = g, len(y), start, y, first, last
    marks = np.empty(most, np.uint8)
    function(images, n * height, height, width, *runs, level, margin, most, room, marks, ends, column, line, grey, own)
    n = int(ends[-1])
    return GroupPixels(ends, column[:n], line[:n], grey[:n], own[:n])


def group_peaks(images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints) -> Floats:
    """(G) grey level of the brightest pixel of each of G groups of runs.

    Args:
        images: (n, H, W) frames.
        start: (G+1) where each group starts among the runs.
        y: (R) scan line of each run in the tall image of all frames; in scan order within a group.
        first: (R) first column.
        last: (R) last column.

    Raises:
        ValueError: an array has another shape or dtype, images are too wide, or a group is not in one of the frames.
    """
    images, start, y, first, last = _CUT(images, start, y, first, last)
    (n, height, width), g = images.shape, len(start) - 1
    if compiled := library():
        out = np.empty(max(g, 0))
        function = compiled.peaks_8 if images.dtype == np.uint8 else compiled.peaks_16
        good = function(images, n * height, height, width, g, len(y), start, y, first, last, out)
    elif (good := number_good(images.shape, start, y, first, last)) == g:
        out = _numpy_group_peaks(images, start, y, first, last)
    _check(good, images, start, y)
    return out


def sum_peaks(
    images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints, peak: Floats, near: Floats, uv: Floats
) -> Floats:
    """Sums over the white pixels of G groups of runs that have a certain level.

    Args:
        images: (n, H, W) frames.
        start: (G+1) where each group starts among the runs.
        y: (R) scan line of each run in the tall image of all frames; in scan order within a group.
        first: (R) first column.
        last: (R) last column.
        peak: (G) the level.
        near: (G) a level below it.
        uv: (G, 2) px of the group's frame, from where places count.

    Returns:
        (5, G): the number of pixels with `peak`, and of those above `near`; the sums of u², u v and v² over the first.

    Raises:
        ValueError: an array has another shape or dtype, images are too wide, or a group is not in one of the frames.
    """
    images, start, y, first, last, peak, near, uv = _PEAKS(images, start, y, first, last, peak, near, uv)
    n, height, width = images.shape
    if len(peak) != len(start) - 1:
        raise ValueError(f"peak has shape {peak.shape}, wanted ({len(start) - 1},)")
    if compiled := library():
        out, (u, v) = np.empty((SUMS, len(peak))), np.ascontiguousarray(uv.T)
        function = compiled.sum_peaks_8 if images.dtype == np.uint8 else compiled.sum_peaks_16
        runs = len(peak), len(y), start, y, first, last
        good = function(images, n * height, height, width, *runs, peak, near, u, v, out)
    elif (good := number_good(images.shape, start, y, first, last)) == len(peak):
        out = _numpy_peaks(images, start, y, first, last, peak, near, uv)
    _check(good, images, start, y)
    return out


def _check(good: int, images: GreyLevels, start: Ints, y: Ints) -> None:
    """Refuse groups of which only the first so many are in the frames."""
    g, (n, height, width) = len(start) - 1, images.shape
    if g < 0 or width > MOST_WIDE:
        raise ValueError(
            f"found {len(start)} starts and images {width} px wide, wanted 1 or more and {MOST_WIDE} or less"
        )
    if good < g or (g == 0 and len(y)):
        raise ValueError(f"group {good} of {g} does not lie in one of the {n} frames of {width} × {height} px")


def _rectangles(start: Ints, y: Ints, first: Ints, last: Ints, margin: int) -> Ints:
    """(G) pixels of the rectangle round each group, wider by the margin on each side."""
    if len(start) < 2:
        return np.zeros(0, np.int64)
    head = start[:-1]
    wide = np.maximum.reduceat(last, head) - np.minimum.reduceat(first, head) + 1 + 2 * margin
    return np.asarray(wide * (y[start[1:] - 1] - y[head] + 1 + 2 * margin))


def _numpy_cut(
    images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints, level: int, margin: int
) -> GroupPixels:
    import scipy  # only where there is no compiled library, and no command may wait for it

    (_, height, width), parts = images.shape, [np.zeros((4, 0))]
    for a, b in zip(start[:-1].tolist(), start[1:].tolist(), strict=True):
        top, left = y[a] - margin - 1, first[a:b].min() - margin - 1
        own = np.zeros((y[b - 1] - top + margin + 2, last[a:b].max() - left + margin + 2), np.bool_)
        for line, begin, end in zip(y[a:b] - top, first[a:b] - left, last[a:b] - left, strict=True):
            own[line, begin : end + 1] = True
        lines, columns = top + np.arange(own.shape[0])[:, None], left + np.arange(own.shape[1])
        inside = (columns >= 0) & (columns < width) & (lines // height == y[a] // height)
        grey = images.reshape(-1)[np.where(inside, lines * width + columns, 0)].astype(np.float64)
        others = scipy.ndimage.maximum_filter((grey > level) & inside & ~own, size=3)
        close = scipy.ndimage.maximum_filter(own, size=2 * margin + 1) & inside
        used = np.nonzero(close & (own | ~others))
        parts.append(np.stack([columns[used[1]], lines[used[0], 0] % height, grey[used], own[used]]))
    column, line, grey, own = np.concatenate(parts, 1)
    ends = np.cumsum([part.shape[1] for part in parts])
    return GroupPixels(ends, column.astype(np.int64), line.astype(np.int64), grey, own.astype(np.bool_))


def _numpy_group_peaks(images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints) -> Floats:
    if len(start) < 2:
        return np.zeros(0)
    long = last - first + 1
    x = np.arange(long.sum()) + np.repeat(first - np.cumsum(long) + long, long)
    grey = images.reshape(-1)[np.repeat(y, long) * images.shape[2] + x]
    area = np.add.reduceat(long, start[:-1])
    return np.maximum.reduceat(grey, np.cumsum(area) - area).astype(np.float64)


def _numpy_peaks(
    images: GreyLevels, start: Ints, y: Ints, first: Ints, last: Ints, peak: Floats, near: Floats, uv: Floats
) -> Floats:
    long = last - first + 1
    of = np.repeat(np.repeat(np.arange(len(peak)), np.diff(start)), long)
    x = np.arange(long.sum()) + np.repeat(first - np.cumsum(long) + long, long)
    y = np.repeat(y, long)
    grey = images.reshape(-1)[y * images.shape[2] + x].astype(np.float64)
    dx, dy = x - uv[of, 0], y % max(images.shape[1], 1) - uv[of, 1]
    at = grey == peak[of]
    weights = at, grey > near[of], *(np.where(at, a, 0.0) for a in (dx * dx, dx * dy, dy * dy))
    return np.array([np.bincount(of, weight, len(peak)) for weight in weights], np.float64).reshape(SUMS, len(peak))
