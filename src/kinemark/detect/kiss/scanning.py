"""Preliminary grouping (KISS 2.1): each run of white pixels joins a group by its mid-point, while the image is scanned.

The boundary pixels P₁, P₂ of a run have the mid-point

    x_m = (x₁ + x₂) / 2,    y_m = (y₁ + y₂) / 2 = y                      (3)

A run joins the first group, in the order of their numbers, that already holds a mid-point no farther than `near_x` and
`near_y`; if there is none, it begins a new group with the next number. Groups that turn out to touch are not joined:
where two markers lie side by side, the runs above their notch, and the common runs below it, have mid-points far
from each other and become different groups, which sub-marker detection or the overlap test mend.

The rule reads as if runs had to be taken one by one, but a run i with earlier mid-points N(i) near it has

    number(i) = min over j in N(i) of number(j),   or a new one where N(i) is empty         (A)

so that number(i) is the least of all runs without neighbours from which a chain of near mid-points leads to i. Taking
least numbers over all pairs at once, and after each step the number of one's number, ends in the same groups after a
few steps (B). The pairs are found with binary searches: with line numbers that leave `near_y` lines free between
frames, the keys line S + 2 x_m rise in scan order, as runs of a line do not overlap (C).

Source: Shafiq, Tümer and Güler 2001, Mechatronics 11 (KISS), 2.1, equation 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Ints
from ...numerics.runs import equal_runs
from ..pixel_runs import Runs
from .pixel_groups import KissGroups, numbered


def preliminary_groups(runs: Runs, *, near_x: float, near_y: int, height: int, width: int) -> KissGroups:
    """Groups of runs of frames of this height and width, px, by the closeness of their mid-points."""
    earlier, later = _near_pairs(runs, near_x, near_y, height, width)
    return numbered(*runs, _least_number(earlier, later, len(runs.y)), height=height)


def _near_pairs(runs: Runs, near_x: float, near_y: int, height: int, width: int) -> tuple[Ints, Ints]:
    """Pairs (N), (N) of runs whose mid-points are near each other, sorted by the later one."""
    twice = runs.first + runs.last  # 2 x_m of (3)
    reach = int(2 * min(near_x, width))
    stride = 2 * (width + reach) + 1
    line = runs.y + runs.y // height * near_y
    key = line * stride + twice  # (C)
    index = np.arange(len(key))
    lows, counts = [], []
    for dy in range(near_y + 1):
        low = np.searchsorted(key, key - dy * stride - reach)
        high = np.searchsorted(key, key - dy * stride + reach, side="right") if dy else index
        lows.append(low)
        counts.append(np.maximum(high - low, 0))
    low, count = np.stack(lows, 1).reshape(-1), np.stack(counts, 1).reshape(-1)
    start = np.cumsum(count) - count
    earlier = np.arange(count.sum()) + np.repeat(low - start, count)
    return earlier, np.repeat(np.repeat(index, near_y + 1), count)


def _least_number(earlier: Ints, later: Ints, n: int) -> NDArray[np.int64]:
    """(n) the number of the group that each run joins."""
    number = np.arange(n)
    if len(later) == 0:
        return number
    head = equal_runs(later)[:-1]
    joined = later[head]
    while True:
        new = number.copy()
        new[joined] = np.minimum.reduceat(number[earlier], head)  # (A)
        new = new[new]  # (B)
        if np.array_equal(new, number):
            return number
        number = new
