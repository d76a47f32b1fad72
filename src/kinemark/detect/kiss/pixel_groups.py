"""Groups of white pixels between the steps: runs with the number of the group that each belongs to.

The bounding rectangle (brect) of a group, its width w and height h, and

    TotalPixels = w h                                                    (4)
    WhitePixels = Σ (x₂ⁱ − x₁ⁱ + 1), over its runs i                     (5)

are what all tests of KISS 2.3 look at (Shafiq, Tümer and Güler 2001). With w = max x − min x, as (1) of the paper has
it, an isolated pixel would be 0 wide and a full rectangle would hold more white pixels than pixels; so here w and h
count the pixels at both ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Ints
from ...numerics.runs import begins


class KissGroups(NamedTuple):
    """G groups of R runs, sorted by frame; lines count in the tall image of all frames.

    Attributes:
        y, first, last: (R) white pixels first … last of line y; sorted by group, then line, then column.
        of: (R) the group of each run, rising; every group has runs.
        frame: (G) frame within the batch.
        separated: (G) whether the group was cut out of a larger one.
    """

    y: Ints
    first: Ints
    last: Ints
    of: Ints
    frame: Ints
    separated: NDArray[np.bool_]

    @property
    def start(self) -> Ints:
        """(G+1) runs start[g]:start[g+1] are group g."""
        return np.searchsorted(self.of, np.arange(len(self.frame) + 1))

    def keep(self, mask: NDArray[np.bool_]) -> KissGroups:
        """The groups where `mask` (G) is true."""
        if mask.all():
            return self
        runs = mask[self.of]
        number = np.cumsum(mask) - 1
        return KissGroups(
            self.y[runs],
            self.first[runs],
            self.last[runs],
            number[self.of[runs]],
            self.frame[mask],
            self.separated[mask],
        )


class Rectangles(NamedTuple):
    """The bounding rectangle of each group (G), its pixels included, px."""

    left: Ints
    right: Ints
    top: Ints
    bottom: Ints

    @property
    def width(self) -> Ints:
        """(G) px."""
        return self.right - self.left + 1

    @property
    def height(self) -> Ints:
        """(G) px."""
        return self.bottom - self.top + 1

    @property
    def total_pixels(self) -> Ints:
        """(G) pixels of the rectangle."""
        return self.width * self.height  # (4)


def numbered(y: Ints, first: Ints, last: Ints, label: Ints, *, height: int) -> KissGroups:
    """Groups from runs in scan order and any label a run; groups are in the order of their first runs."""
    _, head, label = np.unique(label, return_index=True, return_inverse=True)
    place = np.empty(len(head), np.int64)
    place[np.argsort(head)] = np.arange(len(head))
    of = place[label]
    order = np.argsort(of, kind="stable")
    frame = y[np.sort(head)] // height
    return KissGroups(y[order], first[order], last[order], of[order], frame, np.zeros(len(head), np.bool_))


def rectangles(groups: KissGroups) -> Rectangles:
    """The bounding rectangle (brect) of each group."""
    if len(groups.frame) == 0:
        none = np.zeros(0, np.int64)
        return Rectangles(none, none, none, none)
    start = groups.start
    head = start[:-1]
    return Rectangles(
        np.minimum.reduceat(groups.first, head),
        np.maximum.reduceat(groups.last, head),
        groups.y[head],
        groups.y[start[1:] - 1],
    )


def white_pixels(groups: KissGroups) -> Ints:
    """(G) white pixels of each group."""
    lengths = groups.last - groups.first + 1
    return np.bincount(groups.of, lengths, len(groups.frame)).astype(np.int64)  # (5)


def separated(groups: KissGroups, parent: Ints, parts: Rectangles) -> KissGroups:
    """The groups, but in the place of each `parent` (K, rising) its white pixels in each of the rectangles (K).

    A pixel in several rectangles is in each of the new groups, as markers that lie on each other share pixels. A
    rectangle without white pixels makes no group.
    """
    if len(parent) == 0:
        return groups
    start = groups.start
    count = np.diff(start)[parent]
    part = np.repeat(np.arange(len(parent)), count)
    run = np.arange(count.sum()) + np.repeat(start[parent] - np.cumsum(count) + count, count)
    y = groups.y[run]
    first, last = np.maximum(groups.first[run], parts.left[part]), np.minimum(groups.last[run], parts.right[part])
    kept = (first <= last) & (y >= parts.top[part]) & (y <= parts.bottom[part])
    whole = ~np.isin(groups.of, parent)
    place = np.concatenate([groups.of[whole], parent[part[kept]]])
    label = np.concatenate([np.full(whole.sum(), -1), part[kept]])
    order = np.lexsort((label, place))  # stable: runs stay in order of line and column
    place, label = place[order], label[order]
    new = begins(place, label)
    return KissGroups(
        np.concatenate([groups.y[whole], y[kept]])[order],
        np.concatenate([groups.first[whole], first[kept]])[order],
        np.concatenate([groups.last[whole], last[kept]])[order],
        np.cumsum(new) - 1,
        groups.frame[place[new]],
        groups.separated[place[new]] | (label[new] >= 0),
    )
