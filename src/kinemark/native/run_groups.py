"""Runs that touch, also by a corner, form a group (KISS 2.1; here exactly, by connected components).

A run first … last of line y touches the runs of line y + 1 that begin at last + 1 or before and end at
first − 1 or after. With

    a = y (W + 2) + first,    b = y (W + 2) + last                       (1)

both rising in scan order, these are consecutive: from the first run with b' ≥ a + (W + 2) − 1 to the last
with a' ≤ b + (W + 2) + 1 (2), and two binary searches find them for all runs at once. A line is left free
after each frame, so that no group reaches from one frame into the next.

The compiled function goes through the runs once and unites those that touch (union and find).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..data.array_types import Ints
from .array_checks import INT, Arrays
from .compiled_library import library

if TYPE_CHECKING:
    import scipy

MOST_WIDE = 1 << 16
"""px, of an image: sums of x² times 16-bit grey levels along wider lines leave 64 bits; chosen."""

LINES = 1 << 40
"""No film has so many scan lines; more of them leave 64 bits in (1); chosen."""

_RUNS = Arrays(y=(INT, "R"), first=(INT, "R"), last=(INT, "R"))


def group_runs(y: Ints, first: Ints, last: Ints, *, height: int, width: int) -> tuple[Ints, Ints, Ints]:
    """Groups of touching runs, in scan order of their first pixels.

    Args:
        y: (R) scan line of each run in the tall image of all frames, in scan order.
        first: (R) first column.
        last: (R) last column.
        height: of each frame, px.
        width: of each frame, px.

    Returns:
        (3, R) the runs, sorted by group; (G+1) where each group starts among them; (6, G) frame, area, left, right, top
        and bottom of each group.

    Raises:
        ValueError: the columns differ in length, frames have no pixels or too many, or a run is none of such frames or
            does not come after the run before it.
    """
    y, first, last = _RUNS(y, first, last)
    if not (1 <= height < LINES and 1 <= width <= MOST_WIDE):
        raise ValueError(f"frames are {width} × {height} px, wanted at least 1 × 1 and at most {MOST_WIDE} px wide")
    if compiled := library():
        runs, start, box = (np.empty(shape, np.int64) for shape in ((3, len(y)), len(y) + 1, (6, len(y))))
        n = compiled.group_runs(len(y), y, first, last, height, width, np.empty_like(y), runs, start, box)
        wrong = -1 - n if n < 0 else None
        found = runs, start[: n + 1].copy(), box[:, : max(n, 0)].copy()
    elif (wrong := _first_wrong(y, first, last, width)) is None:
        found = _numpy_groups(y, first, last, height, width)
    if wrong is not None:
        place = f"{y[wrong]}, {first[wrong]} … {last[wrong]}"
        raise ValueError(f"run {wrong} of {len(y)} ({place}) is out of order or not in frames {width} px wide")
    return found


def _first_wrong(y: Ints, first: Ints, last: Ints, width: int) -> int | None:
    """The first run that is none of an image of this width, or does not come after the run before it."""
    wrong = (y < 0) | (y >= LINES) | (first < 0) | (last < first) | (last >= width)
    wrong[1:] |= (y[1:] < y[:-1]) | ((y[1:] == y[:-1]) & (first[1:] <= last[:-1]))
    return int(wrong.argmax()) if wrong.any() else None


def _numpy_groups(y: Ints, first: Ints, last: Ints, height: int, width: int) -> tuple[Ints, Ints, Ints]:
    if len(y) == 0:
        return np.zeros((3, 0), np.int64), np.zeros(1, np.int64), np.zeros((6, 0), np.int64)
    import scipy  # only where there is no compiled library, and no command may wait for it

    count, label = scipy.sparse.csgraph.connected_components(_touching(y, first, last, height, width), directed=False)
    order = np.argsort(label, kind="stable")
    y, first, last = runs = np.stack([y, first, last])[:, order]
    start = np.concatenate([[0], np.cumsum(np.bincount(label, minlength=count))])
    head = start[:-1]
    box = [
        y[head] // height,
        np.add.reduceat(last - first + 1, head),
        np.minimum.reduceat(first, head),
        np.maximum.reduceat(last, head),
        y[head],
        y[start[1:] - 1],
    ]
    return runs, start, np.stack(box)


def _touching(y: Ints, first: Ints, last: Ints, height: int, width: int) -> scipy.sparse.csr_array:
    """(R, R) ones where a run touches one of the next line."""
    import scipy

    line = y + y // height
    a, b = line * (width + 2) + first, line * (width + 2) + last  # (1)
    low = np.searchsorted(b, a + width + 1)  # (2)
    count = np.maximum(np.searchsorted(a, b + width + 3, side="right") - low, 0)
    start = np.concatenate([[0], np.cumsum(count)])
    other = np.arange(start[-1]) + np.repeat(low - start[:-1], count)
    return scipy.sparse.csr_array(
        (np.ones(len(other)), other.astype(np.int32), start.astype(np.int32)), shape=(len(a), len(a))
    )
