"""Tracks that go on, from frame to frame (Swamidas 1997, figure 3.9).

Before the predictor has its first three measurements, one point stays where it is and two go on in a line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...signal.kalman import KalmanState, initial_state, predict, update
from .constraints import PredictedPoints, half_size


@dataclass(frozen=True, slots=True)
class ActiveSwamidasTracks:
    """Tracks that go on; all by T.

    Attributes:
        id: identity, in the order of beginning.
        seen: points in a row up to the last one, at most 3; missed: frames since.
        going: whether the predictor has begun.
        past: (T, 3, 3) the last three points, newest first, mm.
        velocity: (T, 3) at the last point, mm/frame.
        state: expected in the frame that comes.
    """

    id: Ints
    seen: Ints
    missed: Ints
    going: Bools
    past: Floats
    velocity: Floats
    state: KalmanState

    def keep(self, mask: Bools) -> ActiveSwamidasTracks:
        """Those where `mask` (T) is true."""
        if mask.all():
            return self
        return ActiveSwamidasTracks(
            self.id[mask],
            self.seen[mask],
            self.missed[mask],
            self.going[mask],
            self.past[mask],
            self.velocity[mask],
            KalmanState(self.state.x[mask], self.state.P[mask]),
        )


def no_tracks() -> ActiveSwamidasTracks:
    """No tracks."""
    zero, cube = np.zeros(0, np.int64), np.zeros((0, 3, 3))
    return ActiveSwamidasTracks(zero, zero, zero, np.zeros(0, bool), cube, np.zeros((0, 3)), KalmanState(cube, cube))


def predict_points(active: ActiveSwamidasTracks, error: Floats, share: float) -> PredictedPoints:
    """What the tracks expect in the frame that comes."""
    line = np.where(active.seen[:, None] >= 2, active.past[:, 0] - active.past[:, 1], 0.0)
    steps, going = active.missed + 1, active.going[:, None]
    xyz = np.where(going, active.state.x[:, 0], active.past[:, 0] + line * (active.missed == 0)[:, None])
    half = np.where(going, half_size(steps, error, active.velocity, share), np.nan)
    return PredictedPoints(xyz, half, np.where(going, active.state.x[:, 1], line), active.past[:, 0], steps)


def advance(
    active: ActiveSwamidasTracks, taken: Ints, points: Floats, *, sd: float, process_sd: float
) -> ActiveSwamidasTracks:
    """The tracks one frame on, with the points (T) taken or, where that is −1, with their predictions.

    `sd` and `process_sd` are those of the predictor.
    """
    hit = taken >= 0
    past, seen = active.past.copy(), active.seen.copy()
    past[hit] = np.concatenate([points[taken[hit], None], past[hit, :2]], 1)
    seen[hit] = np.minimum(np.where(active.missed[hit] == 0, seen[hit], 0) + 1, 3)
    first, on = hit & ~active.going & (seen == 3), hit & active.going
    state = _next_state(active.state, past, seen, first, on, sd, process_sd)
    velocity = active.velocity.copy()
    velocity[first | on] = state.x[first | on, 1] - state.x[first | on, 2]  # in this frame, not in the next
    return ActiveSwamidasTracks(
        active.id, seen, np.where(hit, 0, active.missed + 1), active.going | first, past, velocity, state
    )


def _next_state(
    state: KalmanState, past: Floats, seen: Ints, first: Bools, on: Bools, sd: float, process_sd: float
) -> KalmanState:
    """Predicted for all; begun for those with `first` three points, and corrected for those that go `on` with one."""
    new = predict(state, process_sd) if not on.all() else KalmanState(np.empty_like(state.x), np.empty_like(state.P))
    if first.any():
        new.x[first], new.P[first] = initial_state(past[first], sd, process_sd)
    if on.any():
        new.x[on], new.P[on] = update(KalmanState(state.x[on], state.P[on]), past[on], seen[on] == 3, sd, process_sd)
    return new


def initiate(active: ActiveSwamidasTracks, identity: Ints, points: Floats) -> ActiveSwamidasTracks:
    """The active tracks and new ones of a single point each."""
    n = len(points)
    cube = np.zeros((n, 3, 3))
    return ActiveSwamidasTracks(
        np.concatenate([active.id, identity]),
        np.concatenate([active.seen, np.ones(n, np.int64)]),
        np.concatenate([active.missed, np.zeros(n, np.int64)]),
        np.concatenate([active.going, np.zeros(n, bool)]),
        np.concatenate([active.past, np.repeat(points[:, None], 3, 1)]),
        np.concatenate([active.velocity, np.zeros((n, 3))]),
        KalmanState(np.concatenate([active.state.x, cube]), np.concatenate([active.state.P, cube])),
    )
