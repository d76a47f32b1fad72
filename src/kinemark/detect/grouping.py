"""Runs that touch, also by a corner, form a group (KISS 2.1); how they are found is in `native.run_groups`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import native
from ..data.array_types import Bools, Ints
from .pixel_runs import Runs


class PixelGroups(NamedTuple):
    """G groups in scan order of their first pixels, so sorted by frame; lines count in the tall image.

    Attributes:
        start: (G+1) rows start[g]:start[g+1] of `runs` are group g.
        runs: the runs, sorted by group, then line, then column.
        frame: (G) frame within the batch.
        area: (G) white pixels.
        left, right, top, bottom: (G) bounding rectangle, its pixels included.
    """

    start: Ints
    runs: Runs
    frame: Ints
    area: Ints
    left: Ints
    right: Ints
    top: Ints
    bottom: Ints

    def keep(self, mask: Bools) -> PixelGroups:
        """The groups where `mask` (G) is true."""
        if mask.all():
            return self
        sizes = np.diff(self.start)
        runs = Runs(*(column[np.repeat(mask, sizes)] for column in self.runs))
        return PixelGroups(np.concatenate([[0], np.cumsum(sizes[mask])]), runs, *(column[mask] for column in self[2:]))


def group_runs(runs: Runs, *, height: int, width: int) -> PixelGroups:
    """PixelGroups of touching runs, which are in scan order, of frames of this height and width, px."""
    ordered, start, box = native.group_runs(*runs, height=height, width=width)
    return PixelGroups(start, Runs(*ordered), *box)
