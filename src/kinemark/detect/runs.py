"""White pixels, and the runs they form along each scan line.

A batch of n frames of H × W is read as one tall image of n H scan lines, so that what NumPy costs a
call is shared by all frames. Most blocks of `BLOCK` scan lines are dark in most columns: the maximum of
each column of each block is taken first, at nearly the speed at which memory is read, and only the cells
(block, column) brighter than the threshold are looked at pixel by pixel.

A white pixel of scan line y and column x has the number

    key = y (W + 1) + x                                                  (1)

which rises in scan order; two pixels are neighbours in one run exactly when their keys differ by 1,
as the unused column W keeps the end of one line from the beginning of the next.

The compiled kernel takes maxima along the lines instead, of 256 pixels at a time and of 32 where one is white.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import library

BLOCK = 8  # 1 << 3
SLAB = 1 << 23  # pixels folded at a time
MOST_CELLS = 1 << 18  # looked at in one go, for memory's sake


class Runs(NamedTuple):
    """White pixels first … last of scan line y of the tall image: three columns (R), in scan order."""

    y: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]


def find_runs(tall: NDArray[np.uint8 | np.uint16], threshold: float, *, most: int | None = None) -> Runs:
    """The runs of pixels brighter than `threshold` in the tall image (n H, W).

    Args:
        tall: scan lines of all frames, one below the other.
        threshold: grey level of the image.
        most: only so many runs are looked for, the first ones; None: all.
    """
    level, most = math.floor(threshold), tall.size if most is None else most
    kernel = library()
    return Runs(*kernel.runs(tall, level, most)) if kernel else _plain_runs(tall, level, most)


def _plain_runs(tall: NDArray[np.uint8 | np.uint16], level: int, most: int) -> Runs:
    cells = bright_cells(tall, level)
    if len(cells[0]) <= MOST_CELLS or len(tall) <= BLOCK:
        return Runs(*(column[:most] for column in white_runs(tall, cells, level)))
    half = (len(tall) // 2 + BLOCK - 1) // BLOCK * BLOCK
    above = _plain_runs(tall[:half], level, most)
    below = _plain_runs(tall[half:], level, most - len(above.y))
    below = below._replace(y=below.y + half)
    return Runs(*(np.concatenate(pair) for pair in zip(above, below, strict=True)))


def bright_cells(tall: NDArray[np.uint8 | np.uint16], threshold: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
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


def white_runs(
    tall: NDArray[np.uint8 | np.uint16], cells: tuple[NDArray[np.int64], NDArray[np.int64]], threshold: float
) -> Runs:
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
    return Runs(line, first - line * (w + 1), last - line * (w + 1))


def _true_places(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """`np.flatnonzero` of a long mask with few true places: eight at a time first."""
    whole = len(mask) // 8 * 8
    eights = np.flatnonzero(mask[:whole].view(np.uint64) != 0)
    within = np.flatnonzero(mask[:whole].reshape(-1, 8)[eights])
    found = eights[within >> 3] * 8 + (within & 7)
    return np.concatenate([found, whole + np.flatnonzero(mask[whole:])])
