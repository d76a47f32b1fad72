"""Many points in motion at once: their Kalman filter, the arithmetic of which is in `native.point_motion`.

The points are along the last axis of every array, so that NumPy's innermost loop runs over them: with forty points of
nine numbers this is twice as fast as the other way round.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .... import native
from ....data.array_types import Bools, Floats, Ints


class KalmanStates(NamedTuple):
    """T points: x (9, T) their positions, velocities, accelerations in mm and s; V (9, 9, T) the covariance."""

    x: Floats
    V: Floats

    @property
    def position(self) -> Floats:
        """(3, T) mm."""
        return self.x[:3]

    @property
    def cov(self) -> Floats:
        """(3, 3, T) of the positions, mm²."""
        return self.V[:3, :3]

    def take(self, which: Ints | Bools) -> KalmanStates:
        """Only these points."""
        return KalmanStates(self.x[:, which], self.V[:, :, which])

    def plus(self, other: KalmanStates) -> KalmanStates:
        """These and others after them."""
        return KalmanStates(np.concatenate([self.x, other.x], -1), np.concatenate([self.V, other.V], -1))


def initial_states(xyz: Floats, cov: Floats, *, speed: float, acceleration: float) -> KalmanStates:
    """Points (3, T) of covariance (3, 3, T) of which no motion is known but its usual size, mm/s and mm/s²."""
    x, V = np.zeros((9, xyz.shape[-1])), np.zeros((9, 9, xyz.shape[-1]))
    x[:3], V[:3, :3] = xyz, cov
    V[3:6, 3:6], V[6:, 6:] = np.eye(3)[..., None] * speed**2, np.eye(3)[..., None] * acceleration**2
    return KalmanStates(x, V)


def predict(motion: KalmanStates, T: float | Floats, q: float) -> KalmanStates:
    """The points a time T in s later, one for all or (T) one of each; q in mm/s^2.5."""
    T = np.full(motion.x.shape[-1], T) if np.ndim(T) == 0 else np.asarray(T)
    return KalmanStates(*native.predict(motion.x, motion.V, T, q=q))


def back(motion: KalmanStates, T: float, q: float) -> KalmanStates:
    """The points a time T in s earlier."""
    turned = predict(reversed_time(motion), T, q)
    return reversed_time(turned)


def reversed_time(motion: KalmanStates) -> KalmanStates:
    """The points as they look when time runs backwards: (p, −v, a)."""
    sign = np.repeat([1.0, -1.0, 1.0], 3)
    return KalmanStates(motion.x * sign[:, None], motion.V * np.outer(sign, sign)[..., None])


def update(motion: KalmanStates, N: Floats, g: Floats) -> KalmanStates:
    """The points after a measurement with information N (3, 3, T) 1/mm² and pull g (3, T) 1/mm."""
    return KalmanStates(*native.update(motion.x, motion.V, N, g))
