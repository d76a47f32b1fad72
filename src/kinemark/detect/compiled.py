"""The compiled part of detection, kernel.c, where it was built.

Where it is absent, `runs`, `grouping` and `sums` use NumPy, with the same results. All sizes are checked, here and in
the kernel.
"""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..compiled import at, ints, loaded, opened, plain, size
from ..data.array_types import Ints

VERSION = 1  # as in kernel.c
MARGIN = 2  # as there
SUMS = 16  # as there
FEW = 1 << 14  # runs that mostly are enough


class Library:
    """The functions of kernel.c on arrays."""

    def __init__(self, path: Path) -> None:
        """Load the library.

        Raises:
            OSError: it cannot be loaded, or was built from another version of the source.
        """
        kernel = opened(path, VERSION)
        self._runs = {np.dtype(np.uint8): kernel.runs_8, np.dtype(np.uint16): kernel.runs_16}
        self._sums = {np.dtype(np.uint8): kernel.sums_8, np.dtype(np.uint16): kernel.sums_16}
        self._groups = kernel.groups
        for function in (*self._runs.values(), *self._sums.values(), self._groups):
            function.restype = ctypes.c_int64

    def runs(self, tall: NDArray[np.uint8 | np.uint16], threshold: int, most: int) -> tuple[Ints, Ints, Ints]:
        """Line, first and last column of the runs brighter than `threshold`, the first `most` at most."""
        tall = np.ascontiguousarray(tall)
        lines, width = tall.shape
        most = min(most, lines * ((width + 1) // 2))  # no image has more
        for room in (min(FEW, most), most):  # mostly the little memory is enough, and fresh memory costs time
            columns = np.empty((3, room), np.int64)
            sizes = map(size, (lines, width, threshold, room))
            n = self._runs[tall.dtype](at(tall), *sizes, *map(at, columns))
            if n < room:
                break
        y, first, last = columns[:, :n].copy()
        return y, first, last

    def groups(self, y: Ints, first: Ints, last: Ints, height: int) -> tuple[Ints, Ints, Ints]:
        """Runs sorted by group (3, R), where each group starts (G+1), and frame, area and rectangle of each (6, G).

        Raises:
            ValueError: frames have no lines, or the columns differ in length.
        """
        if height < 1:
            raise ValueError(f"frames are {height} px high, wanted at least 1")
        columns = _columns(y, first, last)
        n = len(columns[0])
        label, runs, start, box = (np.empty(shape, np.int64) for shape in (n, (3, n), n + 1, (6, n)))
        out = map(at, (label, runs, start, box))
        g = self._groups(size(n), *map(at, columns), size(height), *out)
        return runs, start[: g + 1].copy(), box[:, :g].copy()

    def sums(
        self, images: NDArray[np.uint8 | np.uint16], start: Ints, y: Ints, first: Ints, last: Ints
    ) -> NDArray[np.float64]:
        """The rows of `sums.PixelSums` (16, G), of groups in frames (n, H, W).

        Raises:
            ValueError: a group does not lie in these frames.
        """
        images = np.ascontiguousarray(images)
        n, height, width = images.shape
        start, columns = np.ascontiguousarray(start, np.int64), _columns(y, first, last)
        g = len(start) - 1
        space, out = np.empty((2, height + 4 * MARGIN), np.int64), np.empty((SUMS, g))
        sizes = map(size, (n * height, height, width, g, len(columns[0])))
        arrays = map(at, (start, *columns, space, out))
        good = self._sums[images.dtype](at(images), *sizes, *arrays)
        if good < g:
            raise ValueError(f"group {good} of {g} does not lie in one of the {n} frames of {width} × {height} px")
        return out


def library() -> Library | None:
    """The compiled kernel; None where it was not built or `PLAIN` is set, and NumPy does the work."""
    return None if plain() else _loaded()


@cache
def _loaded() -> Library | None:
    return loaded(__file__, Library)


def _columns(y: Ints, first: Ints, last: Ints) -> list[Ints]:
    """The columns of runs, each in one piece.

    Raises:
        ValueError: they differ in length.
    """
    if not len(y) == len(first) == len(last):
        raise ValueError(f"the columns of runs have {len(y)}, {len(first)} and {len(last)} rows, wanted equal numbers")
    return ints(y, first, last)
