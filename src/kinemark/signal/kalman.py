"""The three-state Kalman predictor (Swamidas 1997, 2.4.5 and 3.3, after Bozic 1979).

A marker moves with a constant acceleration that jumps by a T from frame to frame (3.13 to 3.15). Position, velocity
and acceleration of its three coordinates are the rows and columns of one matrix X (3.16). Velocities here are per frame
and accelerations per frame squared, so T is 1 and drops out:

    X(k+1) = F X(k) + W(k),    F = [1 1 ½; 0 1 1; 0 0 1]                 (1)    (3.13 to 3.16)
    Q = E[W Wᵀ] = diag(0, 0, U²),    U = jerk · T³                       (2)    (3.25)

Positions are seen; velocity and acceleration are calculated from the last three of them, and all three count as
measured (3.17, 3.26):

    Y(k) = D [y(k); y(k−1); y(k−2)],    D = [1 0 0; 3/2 −2 1/2; 1 −2 1]  (3)
    Y(k) = C X(k) + V(k),    C = 1                                       (4)
    R = E[V Vᵀ] ≈ σ² diag(D Dᵀ) = σ² diag(1, 6.5, 6)                     (5)    (3.27, 3.28)

with σ² the variance of a position. (3) is the one choice of differences of three points that is exact for constant
acceleration. (5) leaves out, as the document does, that the three share their errors. The document sums Q, R and P over
the three coordinates; the factor 3 does not change the gain, and is left out here. The predictor is (2.13, 3.18 ff.)

    G = F P Cᵀ (C P Cᵀ + R)⁻¹                                            (6)
    X(k+1|k) = F X(k|k−1) + G [Y(k) − C X(k|k−1)]                        (7)
    P(k+1|k) = (F − G C) P Fᵀ + Q                                        (8)

It begins with the first three measurements (3.29 to 3.32): X = Y(3), whose error is D times that of the positions, so

    P = σ² D Dᵀ                                                          (9)

and one step by F. Where nothing is seen, G is 0: (7) goes on with constant acceleration and (8) grows. After a gap the
positions before are not known, and until three are, only the position counts as measured: C = [1 0 0], R = σ².

Signs and letters of several of these equations are lost in the copy at hand; (3), (5) and (9) are derived.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats

F = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
"""Transition matrix of (1), a sample on; by definition."""

D = np.array([[1.0, 0.0, 0.0], [1.5, -2.0, 0.5], [1.0, -2.0, 1.0]])
"""Of (3); its columns are the last position, the one before, and the one before that; by definition."""

DIFFERENCES_COV = D @ D.T
"""Of (9), for σ = 1; its diagonal is that of (5)."""


class KalmanState(NamedTuple):
    """What n markers are expected to do.

    x (n, 3, 3): rows position mm, velocity mm/frame, acceleration mm/frame²; columns x, y, z.
    P (n, 3, 3): covariance of the rows, the same for each column.
    """

    x: Floats
    P: Floats


def initial_state(past: Floats, sd: float, process_sd: float) -> KalmanState:
    """The state one frame after the first three positions.

    Args:
        past: (n, 3, 3) mm; the last position first, then the one before, then the first.
        sd: standard deviation of a position, σ of (5), mm.
        process_sd: U of (2): the standard deviation of the acceleration's change in a frame, mm/frame².
    """
    P = F @ (sd**2 * DIFFERENCES_COV) @ F.T + _process(process_sd)  # (9), (8) with G = 0
    return KalmanState(F @ D @ past, np.broadcast_to(P, past.shape).copy())


def predict(state: KalmanState, process_sd: float) -> KalmanState:
    """One frame on without measurement."""
    return KalmanState(F @ state.x, _symmetric(F @ state.P @ F.T + _process(process_sd)))


def update(state: KalmanState, past: Floats, consecutive: Bools, sd: float, process_sd: float) -> KalmanState:
    """One frame on with the positions seen.

    Args:
        state: expected in the frame of the newest positions.
        past: (n, 3, 3) mm, the last position first.
        consecutive: (n) whether all three are of successive frames; otherwise only the last counts.
        sd, process_sd: as in `initial_state`.
    """
    x, P = F @ state.x, np.empty_like(state.P)
    for own, n_rows in ((consecutive, 3), (~consecutive, 1)):
        if own.any():
            C, R = np.eye(3)[:n_rows], sd**2 * np.diag(DIFFERENCES_COV.diagonal()[:n_rows])  # (4), (5)
            prior = state.P[own]
            G = F @ prior @ C.T @ np.linalg.inv(C @ prior @ C.T + R)  # (6)
            x[own] += G @ (C @ (D @ past[own] - state.x[own]))  # (7)
            P[own] = (F - G @ C) @ prior @ F.T + _process(process_sd)  # (8)
    return KalmanState(x, _symmetric(P))


def update_position(state: KalmanState, xyz: Floats, variance: Floats, process_sd: float) -> tuple[Floats, KalmanState]:
    """With positions alone, of known variances: where the markers are, (n, 3) mm, and the state one frame on.

    Args:
        state: expected in the frame of the positions.
        xyz: (n, 3) mm.
        variance: (n) mm², of each coordinate.
        process_sd: as in `initial_state`.
    """
    found = correct(state, xyz, variance)
    return found.x[:, 0], predict(found, process_sd)


def correct(state: KalmanState, xyz: Floats, variance: Floats) -> KalmanState:
    """The state in the same frame once positions (n, 3) mm of variances (n) mm² count as measured."""
    K = state.P[:, :, 0] / (state.P[:, 0, 0] + variance)[:, None]
    x = state.x + K[:, :, None] * (xyz - state.x[:, 0])[:, None]
    return KalmanState(x, state.P - K[:, :, None] * state.P[:, None, 0])


def correct_with_differences(state: KalmanState, past: Floats, sd: float) -> KalmanState:
    """The same with velocity and acceleration by (3) of positions `past` (n, 3, 3) mm, the newest first, of σ `sd`
    mm."""
    G = state.P @ np.linalg.inv(state.P + sd**2 * np.diag(DIFFERENCES_COV.diagonal()))  # (5)
    return KalmanState(state.x + G @ (D @ past - state.x), _symmetric(state.P - G @ state.P))


def follow(path: Floats, sd: float, process_sd: float) -> KalmanState | None:
    """The state of one marker one frame after the last of its positions (H, 3) mm, NaN where it was not seen.

    Args:
        path: positions, the last of them seen or not.
        sd, process_sd: as in `initial_state`.

    Returns:
        None where it was nowhere seen in three frames in a row.
    """
    state: KalmanState | None = None
    for k in range(2, len(path)):
        past = path[None, k - 2 : k + 1][:, ::-1]
        consecutive = not np.isnan(past).any()
        if state is None:
            state = initial_state(past, sd, process_sd) if consecutive else None
        elif np.isnan(past[0, 0]).any():
            state = predict(state, process_sd)
        else:
            state = update(state, np.nan_to_num(past), np.array([consecutive]), sd, process_sd)
    return state


def _process(process_sd: float) -> Floats:
    """Q of (2)."""
    return np.diag([0.0, 0.0, process_sd**2])


def _symmetric(P: Floats) -> Floats:
    """The symmetric part, without what rounding has added."""
    return (P + P.transpose(0, 2, 1)) / 2
