"""White pixels, and the runs they form along each scan line.

A batch of n frames of H × W is read as one tall image of n H scan lines, so that what NumPy costs a
call is shared by all frames. Most blocks of `BLOCK` scan lines are dark in most columns: the maximum of
each column of each block is taken first, at nearly the speed at which memory is read, and only the cells
(block, column) brighter than the threshold are looked at pixel by pixel.

A white pixel of scan line y and column x has the number

    key = y (W + 1) + x                                                  (1)

which rises in scan order; two pixels are neighbours in one run exactly when their keys differ by 1,
as the unused column W keeps the end of one line from the beginning of the next.

The compiled function takes maxima along the lines instead, of 256 pixels at a time and of 32 where one is white.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..data.array_types import Bools, GreyLevels, Ints
from .array_checks import GREY, Arrays
from .compiled_library import library

FEW = 1 << 14
"""Runs for which room is made first: fresh memory costs time, and mostly there are fewer."""

BLOCK = 8  # 1 << 3
SLAB = 1 << 23
"""Pixels folded at a time."""

MOST_CELLS = 1 << 18
"""Cells looked at in one go, which bounds the memory."""

Columns = tuple[Ints, Ints, Ints]
"""Line, first and last column of runs, (R) each."""

_TALL = Arrays(tall=(GREY, "H", "W"))


def find_runs(tall: GreyLevels, threshold: float, *, most: int | None = None) -> Columns:
    """Line, first and last column of the runs of pixels brighter than `threshold`, in scan order.

    Args:
        tall: (n H, W) scan lines of all frames, one below the other.
        threshold: grey level of the image.
        most: only the first so many runs are looked for; None: all.

    Raises:
        ValueError: the image has another shape or dtype, the threshold is NaN, or `most` is negative.
    """
    (tall,) = _TALL(tall)
    if math.isnan(threshold):
        raise ValueError("threshold is NaN, wanted a grey level")
    lines, width = tall.shape
    room = lines * ((width + 1) // 2)  # no image has more
    most = room if most is None else min(int(most), room)
    if most < 0:
        raise ValueError(f"most is {most}, wanted 0 or more runs")
    level = math.floor(min(max(threshold, -1.0), 65535.0))
    if most == 0:
        y, first, last = np.zeros((3, 0), np.int64)
        return y, first, last
    compiled = library()
    return _compiled_runs(compiled, tall, level, most) if compiled else _numpy_runs(tall, level, most)


def _compiled_runs(compiled: Any, tall: GreyLevels, level: int, most: int) -> Columns:
    lines, width = tall.shape
    function = compiled.find_runs_8 if tall.dtype == np.uint8 else compiled.find_runs_16
    for room in (min(FEW, most), most):
        columns = np.empty((3, room), np.int64)
        n = function(tall, lines, width, level, room, *columns)
        if n < room:
            break
    y, first, last = columns[:, :n].copy()
    return y, first, last


def _numpy_runs(tall: GreyLevels, level: int, most: int) -> Columns:
    cells = bright_cells(tall, level)
    if len(cells[0]) <= MOST_CELLS or len(tall) <= BLOCK:
        y, first, last = white_runs(tall, cells, level)
        return y[:most], first[:most], last[:most]
    half = (len(tall) // 2 + BLOCK - 1) // BLOCK * BLOCK
    above = _numpy_runs(tall[:half], level, most)
    y, first, last = _numpy_runs(tall[half:], level, most - len(above[0]))
    below = y + half, first, last
    y, first, last = (np.concatenate(pair) for pair in zip(above, below, strict=True))
    return y, first, last


def bright_cells(tall: GreyLevels, threshold: float) -> tuple[Ints, Ints]:
    """First scan line (N) and column (N) of every cell of `BLOCK` lines, or what is left, with a white pixel."""
    h, w = tall.shape
    lines = max(1, SLAB // w // BLOCK) * BLOCK
    peaks = np.empty((lines // BLOCK, w), tall.dtype)  # one buffer for all slabs stays in the cache
    white = np.empty(peaks.shape, np.bool_)
    found = [np.zeros(0, np.int64)]
    for top in range(0, h, lines):
        slab = tall[top : top + lines]
        n = len(slab) // BLOCK
        np.maximum.reduce(slab[: n * BLOCK].reshape(n, BLOCK, w), axis=1, out=peaks[:n])
        if n * BLOCK < len(slab):
            np.maximum.reduce(slab[n * BLOCK :], axis=0, out=peaks[n])
            n += 1
        np.greater(peaks[:n], math.floor(threshold), out=white[:n])
        found.append(_true_places(white[:n].reshape(-1)) + top // BLOCK * w)
    cell = np.concatenate(found)
    block = cell // w
    return block * BLOCK, cell - block * w


def white_runs(tall: GreyLevels, cells: tuple[Ints, Ints], threshold: float) -> Columns:
    """The runs of pixels brighter than `threshold` among these cells of the tall image (n H, W)."""
    h, w = tall.shape
    top, column = cells
    pixel = (top * w + column)[:, None] + np.arange(BLOCK) * w
    if h % BLOCK:
        pixel = np.minimum(pixel, (h - 1) * w + column[:, None])  # the last block may reach beyond the image
    white = np.flatnonzero(tall.reshape(-1)[pixel] > math.floor(threshold))
    cell = white >> 3
    y = top[cell] + (white & 7)
    key = y * (w + 1) + column[cell]  # (1)
    key = key[y < h] if h % BLOCK else key
    key.sort()
    end = np.flatnonzero(np.diff(key) != 1)
    first = key[np.concatenate([[0], end + 1])] if len(key) else key
    last = key[np.concatenate([end, [len(key) - 1]])] if len(key) else key
    line = first // (w + 1)
    return line, first - line * (w + 1), last - line * (w + 1)


def _true_places(mask: Bools) -> Ints:
    """`np.flatnonzero` of a long mask with few true places: eight at a time first."""
    whole = len(mask) // 8 * 8
    eights = np.flatnonzero(mask[:whole].view(np.uint64) != 0)
    within = np.flatnonzero(mask[:whole].reshape(-1, 8)[eights])
    found = eights[within >> 3] * 8 + (within & 7)
    return np.concatenate([found, whole + np.flatnonzero(mask[whole:])])
