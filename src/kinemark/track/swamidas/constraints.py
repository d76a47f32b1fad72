"""Which track takes which point: four constraints, one after the other (Swamidas 1997, 3.4 and figure 3.12).

**Region of acceptance.** About the position x̂ that a track predicts is a box, in its n-th frame without a point of half
size

    h = n (e + p |v|)                                                    (1)

along each coordinate: the measurement's error e and the share p of the way that the last velocity v makes in a frame
are added for every step of prediction. Tracks in the order in which they began take the one free point in their
box. A box with several is put aside "until all the other markers are matched". A box that has grown over the
neighbour's marker while its own is hidden takes that: this is the document's failure, and so it is here.

**Distance.** A point and a track that are nearest to each other, of all that are left, belong together; however far.

**Velocity.** The same with the difference of velocities instead,

    |(y − y_last) / n − v̂|                                               (2)

between the mean velocity that would have brought the track to the point and the one predicted. (The document matches
"the velocity profile of an observed marker", of which the frame in which it comes back has one point only.)

**Elimination.** If one track is left, it takes the nearest point left. All others are discarded.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints


class Constraint(IntEnum):
    """What decided about a point."""

    NONE = 0
    REGION = 1
    DISTANCE = 2
    VELOCITY = 3
    ELIMINATION = 4
    BEGIN = 5
    MODEL = 6
    MEETING = 7


class PredictedPoints(NamedTuple):
    """What T tracks expect in a frame.

    xyz (T, 3) mm, half (T, 3) mm the box about it, NaN where there is none; velocity (T, 3) mm/frame; last (T, 3) mm
    the last point taken, and steps (T) the frames since.
    """

    xyz: Floats
    half: Floats
    velocity: Floats
    last: Floats
    steps: Ints

    def keep(self, mask: Bools) -> PredictedPoints:
        """Those where `mask` (T) is true."""
        xyz, half, velocity, last, steps = self
        return PredictedPoints(xyz[mask], half[mask], velocity[mask], last[mask], steps[mask])


def half_size(steps: Ints, error: Floats, velocity: Floats, share: float) -> Floats:
    """(T, 3) mm of (1), for errors (3) mm and last velocities (T, 3) mm/frame."""
    return steps[:, None] * (error + share * np.abs(velocity))


def in_region(expected: PredictedPoints, points: Floats) -> Bools:
    """(T, N) whether points (N, 3) mm lie in the boxes."""
    return np.asarray((np.abs(points - expected.xyz[:, None]) <= expected.half[:, None]).all(-1))


def match_points(expected: PredictedPoints, points: Floats, allowed: Bools) -> tuple[Ints, Ints]:
    """The point (T) of each track, −1 for none, and the `Constraint` (T) by which.

    Args:
        expected: T tracks in the order in which they began.
        points: (N, 3) mm.
        allowed: (T, N) pairs that may be.
    """
    taken, by = np.full(len(expected.xyz), -1), np.full(len(expected.xyz), int(Constraint.NONE))
    off = points - expected.xyz[:, None]
    _by_region(in_region(expected, points) & allowed, taken, by)
    distance = np.where(allowed, (off**2).sum(-1), np.inf)
    _by_nearest(distance, taken, by, Constraint.DISTANCE)
    if (taken < 0).any() and (taken >= 0).sum() < len(points):
        way = (points - expected.last[:, None]) / expected.steps[:, None, None]
        change = ((way - expected.velocity[:, None]) ** 2).sum(-1)  # (2)
        _by_nearest(np.where(allowed, change, np.inf), taken, by, Constraint.VELOCITY)
        if (taken < 0).sum() == 1:
            _by_nearest(distance, taken, by, Constraint.ELIMINATION)
    return taken, by


def _by_region(inside: Bools, taken: Ints, by: Ints) -> None:
    """Tracks with one free point in their box (T, N) take it, in their order."""
    free = np.ones(inside.shape[1], bool)
    for t in np.flatnonzero(inside.any(1)):
        own = np.flatnonzero(inside[t] & free)
        if len(own) == 1:
            taken[t], by[t] = own[0], Constraint.REGION
            free[own] = False


def _by_nearest(cost: Floats, taken: Ints, by: Ints, constraint: Constraint) -> None:
    """Tracks and points that are left, and cheapest to each other by cost (T, N), belong together."""
    tracks = np.flatnonzero(taken < 0)
    if not len(tracks) or len(tracks) + cost.shape[1] == len(taken):  # all tracks or all points are taken
        return
    free = np.ones(cost.shape[1], bool)
    free[taken[taken >= 0]] = False
    points = np.flatnonzero(free)
    left = cost[np.ix_(tracks, points)]
    best = left.argmin(1)
    n = np.arange(len(tracks))
    agree = (left.argmin(0)[best] == n) & np.isfinite(left[n, best])
    taken[tracks[agree]] = points[best[agree]]
    by[tracks[agree]] = constraint
