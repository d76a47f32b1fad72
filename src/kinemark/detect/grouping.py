"""Runs that touch, also by a corner, form a group (KISS 2.1; here exactly, by connected components).

A run first … last of line y touches the runs of line y + 1 that begin at last + 1 or before and end at
first − 1 or after. With

    a = y (W + 2) + first,    b = y (W + 2) + last                       (1)

both rising in scan order, these are consecutive: from the first run with b' ≥ a + (W + 2) − 1 to the last
with a' ≤ b + (W + 2) + 1 (2), and two binary searches find them for all runs at once. A line is left free
after each frame, so that no group reaches from one frame into the next.

The compiled kernel goes through the runs once and unites those that touch (union and find).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from .compiled import library
from .runs import Runs


class PixelGroups(NamedTuple):
    """G groups in scan order of their first pixels, so sorted by frame; lines count in the tall image.

    Attributes:
        start: (G+1) rows start[g]:start[g+1] of `runs` are group g.
        runs: the runs, sorted by group, then line, then column.
        frame: (G) frame within the batch.
        area: (G) white pixels.
        left, right, top, bottom: (G) bounding rectangle, its pixels included.
    """

    start: NDArray[np.int64]
    runs: Runs
    frame: NDArray[np.int64]
    area: NDArray[np.int64]
    left: NDArray[np.int64]
    right: NDArray[np.int64]
    top: NDArray[np.int64]
    bottom: NDArray[np.int64]

    def keep(self, mask: NDArray[np.bool_]) -> PixelGroups:
        """The groups where `mask` (G) is true."""
        if mask.all():
            return self
        sizes = np.diff(self.start)
        runs = Runs(*(column[np.repeat(mask, sizes)] for column in self.runs))
        return PixelGroups(np.concatenate([[0], np.cumsum(sizes[mask])]), runs, *(column[mask] for column in self[2:]))


def group_runs(runs: Runs, *, height: int, width: int) -> PixelGroups:
    """Groups of touching runs, which are in scan order, of frames of this height and width, px."""
    if kernel := library():
        sorted_runs, start, box = kernel.groups(*runs, height)
        return PixelGroups(start, Runs(*sorted_runs), *box)
    return _plain_groups(runs, height, width)


def _plain_groups(runs: Runs, height: int, width: int) -> PixelGroups:
    n = len(runs.y)
    if n == 0:
        none = np.zeros(0, np.int64)
        return PixelGroups(np.zeros(1, np.int64), runs, none, none, none, none, none, none)
    count, label = connected_components(_touching(runs, height, width), directed=False)
    order = np.argsort(label, kind="stable")
    runs = Runs(*(column[order] for column in runs))
    start = np.concatenate([[0], np.cumsum(np.bincount(label, minlength=count))])
    head = start[:-1]
    return PixelGroups(
        start=start,
        runs=runs,
        frame=runs.y[head] // height,
        area=np.add.reduceat(runs.last - runs.first + 1, head),
        left=np.minimum.reduceat(runs.first, head),
        right=np.maximum.reduceat(runs.last, head),
        top=runs.y[head],
        bottom=runs.y[start[1:] - 1],
    )


def _touching(runs: Runs, height: int, width: int) -> csr_array:
    """(R, R) ones where a run touches one of the next line."""
    line = runs.y + runs.y // height
    a, b = line * (width + 2) + runs.first, line * (width + 2) + runs.last  # (1)
    low = np.searchsorted(b, a + width + 1)  # (2)
    count = np.maximum(np.searchsorted(a, b + width + 3, side="right") - low, 0)
    start = np.concatenate([[0], np.cumsum(count)])
    other = np.arange(start[-1]) + np.repeat(low - start[:-1], count)
    return csr_array((np.ones(len(other)), other.astype(np.int32), start.astype(np.int32)), shape=(len(a), len(a)))
