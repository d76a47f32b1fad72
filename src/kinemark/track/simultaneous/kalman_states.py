"""Many points in motion at once: their Kalman filter.

A point of position p, velocity v and acceleration a, whose acceleration wanders as white noise of density q² drives it
(Bar-Shalom, Li & Kirubarajan 2001, "Estimation with Applications to Tracking and Navigation", 6.2.3), goes on in T by

    (p, v, a) ← A (p, v, a),   A = [1  T  T²/2; 0  1  T; 0  0  1]                        (1)
    V ← A V Aᵀ + q² G,   G = [T⁵/20  T⁴/8  T³/6; T⁴/8  T³/3  T²/2; T³/6  T²/2  T]        (2)

the same in each of the three axes. What is measured of p has the information N and pulls it by g = N (measured − p); N
is singular where only one camera sees the point, and what it says across its ray is used all the same. With V₀ the
covariance of p and V_p that of the whole state with p,

    P = (V₀⁻¹ + N)⁻¹,   R = V₀⁻¹ − V₀⁻¹ P V₀⁻¹                                           (3)
    state ← state + V_p V₀⁻¹ P g,   V ← V − V_p R V_pᵀ                                   (4)

Against time the same holds for (p, −v, a).

The points stand along the last axis of every array, so that NumPy's innermost loop runs over them: with forty points of
nine numbers this is twice as fast as the other way round.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...numerics.small_matrices import inverse3_last
from .compiled import library


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


def at_rest(xyz: Floats, cov: Floats, *, speed: float, acceleration: float) -> KalmanStates:
    """Points (3, T) of covariance (3, 3, T) of which no motion is known but its usual size, mm/s and mm/s²."""
    x, V = np.zeros((9, xyz.shape[-1])), np.zeros((9, 9, xyz.shape[-1]))
    x[:3], V[:3, :3] = xyz, cov
    V[3:6, 3:6], V[6:, 6:] = np.eye(3)[..., None] * speed**2, np.eye(3)[..., None] * acceleration**2
    return KalmanStates(x, V)


def ahead(motion: KalmanStates, T: float | Floats, q: float) -> KalmanStates:
    """The points a time T in s later, one for all or (T) one of each, by (1) and (2); q in mm/s^2.5."""
    n = motion.x.shape[-1]
    T = np.full(n, T) if np.ndim(T) == 0 else np.asarray(T)
    if kernel := library():
        return KalmanStates(*kernel.ahead(motion.x, motion.V, T, q))
    x, half = _gone_on(motion.x.reshape(3, 3, n), T), _gone_on(motion.V.reshape(3, 27, n), T)
    V = _gone_on(half.reshape(9, 3, 3, n).swapaxes(0, 1), T).swapaxes(0, 1).reshape(9, 9, n)
    V += q * q * np.kron(_wandered(T).T, np.eye(3)).T
    return KalmanStates(x.reshape(9, n), V)


def _gone_on(state: Floats, T: Floats) -> Floats:
    """A of (1) times (3, …, T)."""
    p, v, a = state
    return np.array([p + T * v + T * T / 2 * a, v + T * a, a])


def _wandered(T: Floats) -> Floats:
    """(3, 3, T) G of (2)."""
    return np.array([[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]])


def back(motion: KalmanStates, T: float, q: float) -> KalmanStates:
    """The points a time T in s earlier."""
    turned = ahead(reversed_time(motion), T, q)
    return reversed_time(turned)


def reversed_time(motion: KalmanStates) -> KalmanStates:
    """The points as they look when time runs backwards: (p, −v, a)."""
    sign = np.repeat([1.0, -1.0, 1.0], 3)
    return KalmanStates(motion.x * sign[:, None], motion.V * np.outer(sign, sign)[..., None])


def told(motion: KalmanStates, N: Floats, g: Floats) -> KalmanStates:
    """The points after a measurement with information N (3, 3, T) 1/mm² and pull g (3, T) 1/mm, by (3) and (4)."""
    if kernel := library():
        return KalmanStates(*kernel.told(motion.x, motion.V, N, g))
    with_p = motion.V[:, :3]
    before = inverse3_last(motion.cov)
    gain = np.einsum("ijt,jkt->ikt", before, inverse3_last(before + N))  # V₀⁻¹ P
    R = before - np.einsum("ijt,jkt->ikt", gain, before)  # (3)
    R = (R + R.swapaxes(0, 1)) / 2  # rounding would make it lopsided, more and more
    x = motion.x + np.einsum("ijt,jt->it", with_p, np.einsum("ijt,jt->it", gain, g))  # (4)
    V = motion.V - np.einsum("ijt,kjt->ikt", np.einsum("ijt,jkt->ikt", with_p, R), with_p)
    return KalmanStates(x, V)
