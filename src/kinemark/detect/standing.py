"""Spots that never move while others do: lamps and reflections that size and brightness leave among the markers.

Of n frames spread over a recording, a place is one of a standing spot where

    a group of a marker's size lies within APART in ALWAYS of the frames and more,                        (1)

which the foot of somebody who walks does not. Where somebody stands still the markers stand as well, so that nothing
can be told: in ALWAYS of the frames more spots must move than stand (2). The mask of a spot is the rectangle round all
its groups, and GROW px more, as masks of an empty recording have it (`masks.learn_masks`) (3).
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints
from .grouping import PixelGroups

FEWEST = 6
"""Frames from which something is said; chosen: in fewer, what walks by may stand in all."""

ALWAYS = 0.8
"""Share of the frames, of (1) and (2); chosen: a lamp that somebody hides at times is one, and a foot stands for 0.6 of
a cycle."""

APART = 1.0
"""px between the middles of the rectangles of one spot, whose light flickers; chosen."""

GROW = 3.0
"""px of (3), as `learn_masks` has it by default; chosen there."""


def standing_spots(groups: PixelGroups, *, height: int, width: int, frames: int) -> tuple[Floats, ...]:
    """The masks, (4, 2) px each, of spots that stand in frames of this height and width, px, by the groups that have a
    marker's size; none where nothing moves."""
    if frames < FEWEST or not len(groups.area):
        return ()
    u, v = (groups.left + groups.right) / 2, (groups.top + groups.bottom) / 2 % height
    spot = _spots(np.stack([u, v], 1))
    number = np.bincount(np.unique(np.stack([spot, groups.frame]), axis=1)[0])  # of frames, a spot each
    stands = number >= ALWAYS * frames  # (1)
    still = stands[spot]
    standing, moving = (np.bincount(groups.frame[one], minlength=groups.frame.max() + 1) for one in (still, ~still))
    if np.count_nonzero(moving > standing) < ALWAYS * frames:  # (2)
        return ()
    return tuple(_rectangle(groups.keep(spot == k), height, width) for k in np.flatnonzero(stands))


def _spots(place: Floats) -> Ints:
    """(G) the spot of each group at place (G, 2) px: of those not yet of one, all within APART of the first."""
    from scipy.spatial import KDTree  # slow to load, and asked for by proposals alone

    spot, k, tree = np.full(len(place), -1), 0, KDTree(place)
    for g in range(len(place)):
        if spot[g] < 0:
            spot[[other for other in tree.query_ball_point(place[g], APART) if spot[other] < 0]] = k
            k += 1
    return spot


def _rectangle(groups: PixelGroups, height: int, width: int) -> Floats:
    """(4, 2) px of (3), within the image."""
    left, right = groups.left.min() - GROW - 0.5, groups.right.max() + GROW + 0.5
    top, bottom = (groups.top % height).min() - GROW - 0.5, (groups.bottom % height).max() + GROW + 0.5
    x = np.clip([left, right], -0.5, width - 0.5)
    y = np.clip([top, bottom], -0.5, height - 0.5)
    return np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
