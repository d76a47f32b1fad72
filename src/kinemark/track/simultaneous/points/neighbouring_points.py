"""What the points of tracks say of the motion near one frame of them.

From the points of the frames before it, with which the filter of `kalman_states` is updated one after the other, a
track has a state there; from those after it, against time, another. Either alone tells where a path goes on (`stitch`).
Both together, with covariances V₋ and V₊ of the whole states x₋ and x₊, and what the images of the frame itself say
of the position, N and p, give

    K = V₋ (V₋ + V₊)⁻¹,   x = x₋ + K (x₊ − x₋),   V = K V₊                               (1)

updated with N (p − x) by (4) of `native.point_motion`: the smoothed position (Fraser & Potter 1969, "The optimum linear
smoother as a combination of two optimum linear filters", IEEE Trans. Autom. Control 14, 387–390).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data import Cloud
from ....data.array_types import Bools, Floats, Ints
from ....native import inverse
from ..following.kalman_states import KalmanStates, initial_states, predict, reversed_time, update
from ..simultaneous_method import Simultaneous

LOOK = 8
"""Frames from which the motion is known; chosen (see benchmarks/tracking.py)."""

AT_ONCE = 5_000
"""Points that are smoothed in one go; chosen: more would take memory and no less time."""

UNKNOWN_SD = 1000.0
"""mm, the standard deviation of a position of which nothing is known; chosen (see benchmarks/tracking.py)."""


class TrackPoints(NamedTuple):
    """P points of tracks: frame, id (P), xyz (P, 3) mm, cov (P, 3, 3) mm²."""

    frame: Ints
    id: Ints
    xyz: Floats
    cov: Floats

    @classmethod
    def of(cls, cloud: Cloud, id: Ints) -> TrackPoints:
        """Those of a cloud, of tracks id (P)."""
        return cls(cloud.frame, id, cloud.xyz, cloud.cov)

    def take(self, which: Bools | Ints) -> TrackPoints:
        """Only these."""
        return TrackPoints(self.frame[which], self.id[which], self.xyz[which], self.cov[which])

    def plus(self, other: TrackPoints) -> TrackPoints:
        """These and others after them."""
        return TrackPoints(*(np.concatenate(pair) for pair in zip(self, other, strict=True)))


def parts_of_frames(frame: Ints, at_once: int) -> list[Ints]:
    """Places of about so many of the frames (N) each, a frame being in one part alone."""
    order = np.argsort(frame, kind="stable")
    cuts = np.searchsorted(frame[order], frame[order][at_once::at_once], "right")
    return [part for part in np.split(order, np.unique(cuts)) if len(part)]


def rows_of(points: TrackPoints) -> NDArray[np.int32]:
    """(N, F) the row of each track in each frame, −1 for none; of many tracks of many frames it is large."""
    rows = np.full((int(points.id.max(initial=-1)) + 1, int(points.frame.max(initial=-1)) + 1), -1, np.int32)
    rows[points.id, points.frame] = np.arange(len(points.id))
    return rows


class RowsByTrack(NamedTuple):
    """Where the points of tracks are: their rows (P) by track and frame, and id F + frame (P) of each of these.

    `rows_of` says the same, but grows with the tracks times the frames.
    """

    row: NDArray[np.int32]
    place: Ints
    F: int

    @classmethod
    def of(cls, frame: Ints, id: Ints) -> RowsByTrack:
        """Those of points in frames (P) of tracks id (P)."""
        F = int(frame.max(initial=-1)) + 1
        place = id * F + frame
        order = np.argsort(place, kind="stable").astype(np.int32)
        return cls(order, place[order], F)

    def at(self, id: Ints, frame: Ints) -> Ints:
        """The row of each of tracks in frames of the same shape, the last of several, −1 for none."""
        if not len(self.row):
            return np.full(np.broadcast_shapes(id.shape, frame.shape), -1)
        wanted = id * self.F + frame
        k = np.searchsorted(self.place, wanted, "right") - 1
        there = (frame >= 0) & (frame < self.F) & (k >= 0) & (self.place[k] == wanted)
        return np.where(there, self.row[k], np.int64(-1))


def rows_near(rows: RowsByTrack, id: Ints, frame: Ints, way: int) -> Ints:
    """(LOOK, n) the rows of tracks id (n) in frame (n) and those that lie before (way −1) or after (1) it."""
    return rows.at(id, frame + way * np.arange(LOOK)[:, None])


def motion_from(
    points: TrackPoints, near: Ints, around: Floats, T: float, method: Simultaneous, share: float = 1.0
) -> KalmanStates:
    """The motion of n tracks in a frame, from their rows `near` (LOOK, n) it; somewhere about `around` (3, n) mm.

    Only a `share` of the points' covariances is noise.
    """
    n = near.shape[1]
    wide = np.broadcast_to(np.eye(3)[..., None] * UNKNOWN_SD**2, (3, 3, n))
    motion = initial_states(around, wide, speed=method.velocity_sd, acceleration=method.acceleration_sd)
    for k in range(LOOK - 1, -1, -1):
        motion = motion if k == LOOK - 1 else predict(motion, T, method.process_noise)
        there = near[k] >= 0  # of the others nothing is known
        N = np.where(there, inverse(points.cov[near[k]].transpose(1, 2, 0) * share), 0.0)
        off = np.where(there, points.xyz[near[k]].T - motion.position, 0.0)
        motion = update(motion, N, np.einsum("ijt,jt->it", N, off))
    return motion


def smoothed(
    points: TrackPoints, which: Bools, sound: Bools, T: float, method: Simultaneous, share: float = 1.0
) -> tuple[Floats, Floats]:
    """Positions (n, 3) mm and covariances (n, 3, 3) mm² of the points `which` (P) by (1), from sound ones (P) near.

    Only a `share` of the points' covariances is noise.
    """
    rows, row = RowsByTrack.of(points.frame, points.id), np.flatnonzero(which)
    parts = [row[first : first + AT_ONCE] for first in range(0, max(len(row), 1), AT_ONCE)]
    found = [_smoothed(points, rows, part, sound, T, method, share) for part in parts]
    return np.concatenate([xyz for xyz, _ in found]), np.concatenate([cov for _, cov in found])


def _smoothed(
    points: TrackPoints,
    rows: RowsByTrack,
    row: Ints,
    sound: Bools,
    T: float,
    method: Simultaneous,
    share: float,
) -> tuple[Floats, Floats]:
    """The same of some rows (n), with those of all tracks."""
    around = points.xyz[row].T
    both = _beside(points, rows, row, sound, T, method, share)
    N = inverse(points.cov[row].transpose(1, 2, 0) * share)
    both = update(both, N, np.einsum("ijt,jt->it", N, around - both.position))
    return both.position.T, both.cov.transpose(2, 0, 1)


def off_the_motion(points: TrackPoints, which: Bools, T: float, method: Simultaneous) -> Floats:
    """(n) squared distances of the points `which` (P) from where the other points of their tracks lead, in standard
    deviations; of one track there may be several in a frame."""
    row = np.flatnonzero(which)
    motion = _beside(points, RowsByTrack.of(points.frame, points.id), row, ~which, T, method)
    off = points.xyz[row] - motion.position.T
    S = motion.cov.transpose(2, 0, 1) + points.cov[row]
    return np.asarray((off * np.linalg.solve(S, off[..., None])[..., 0]).sum(1))


def _beside(
    points: TrackPoints,
    rows: RowsByTrack,
    row: Ints,
    sound: Bools,
    T: float,
    method: Simultaneous,
    share: float = 1.0,
) -> KalmanStates:
    """What sound points (P) before and after say of the motion at the points of some rows (n), by (1)."""
    id, frame, around = points.id[row], points.frame[row], points.xyz[row].T
    near = [np.where(sound[one], one, -1) for one in (rows_near(rows, id, frame, way) for way in (-1, 1))]
    for one in near:
        one[0] = -1
    before, after = (motion_from(points, one, around, T, method, share) for one in near)
    return between(before, reversed_time(after))


def between(before: KalmanStates, after: KalmanStates) -> KalmanStates:
    """What both sides say of the motion of n points, by (1)."""
    one, other = (motion.V.transpose(2, 0, 1) for motion in (before, after))
    K = np.linalg.solve(one + other, one).swapaxes(1, 2)
    x = before.x.T + (K @ (after.x - before.x).T[..., None])[..., 0]
    return KalmanStates(x.T, (K @ other).transpose(1, 2, 0))
