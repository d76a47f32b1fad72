"""The Kalman filter of many points in motion at once.

A point of position p, velocity v and acceleration a, whose acceleration is driven by white noise of density q²
(Bar-Shalom, Li & Kirubarajan 2001, "Estimation with Applications to Tracking and Navigation", 6.2.3), is predicted a
time T ahead by

    (p, v, a) ← A (p, v, a),   A = [1  T  T²/2; 0  1  T; 0  0  1]                        (1)
    V ← A V Aᵀ + q² G,   G = [T⁵/20  T⁴/8  T³/6; T⁴/8  T³/3  T²/2; T³/6  T²/2  T]        (2)

the same in each of the three axes. What is measured of p has the information N and pulls it by g = N (measured − p); N
is singular where only one camera sees the point, and what it says across its ray is used all the same. With V₀ the
covariance of p and V_p that of the whole state with p, the update is

    P = (V₀⁻¹ + N)⁻¹,   R = V₀⁻¹ − V₀⁻¹ P V₀⁻¹                                           (3)
    state ← state + V_p V₀⁻¹ P g,   V ← V − V_p R V_pᵀ                                   (4)

The points are along the last axis of every array, so that the innermost loop runs over them.
"""

from __future__ import annotations

import math

import numpy as np

from ..data.array_types import Floats
from .array_checks import FLOAT, Arrays
from .compiled_library import library
from .symmetric3 import inverse

_PREDICT = Arrays(x=(FLOAT, 9, "n"), V=(FLOAT, 9, 9, "n"), T=(FLOAT, "n"))
_UPDATE = Arrays(x=(FLOAT, 9, "n"), V=(FLOAT, 9, 9, "n"), N=(FLOAT, 3, 3, "n"), g=(FLOAT, 3, "n"))


def predict(x: Floats, V: Floats, T: Floats, *, q: float) -> tuple[Floats, Floats]:
    """x (9, n) and V (9, 9, n) of points a time T (n) s later, by (1) and (2).

    Args:
        x: (9, n) positions, velocities and accelerations, mm and s.
        V: (9, 9, n) their covariance.
        T: (n) s.
        q: mm/s^2.5.

    Raises:
        ValueError: an array has another shape or dtype, or q is not finite.
    """
    x, V, T = _PREDICT(x, V, T)
    if not math.isfinite(q):
        raise ValueError(f"q is {q}, wanted a finite number")
    if compiled := library():
        out = np.empty_like(x), np.empty_like(V)
        compiled.predict(len(T), q, T, x, V, *out)
        return out
    return _numpy_predict(x, V, T, q)


@np.errstate(all="ignore")
def _numpy_predict(x: Floats, V: Floats, T: Floats, q: float) -> tuple[Floats, Floats]:
    n = len(T)
    x, half = _moved(x.reshape(3, 3, n), T), _moved(V.reshape(3, 27, n), T)
    V = _moved(half.reshape(9, 3, 3, n).swapaxes(0, 1), T).swapaxes(0, 1).reshape(9, 9, n)
    V += q * q * np.kron(_process_noise(T).T, np.eye(3)).T
    return x.reshape(9, n), V


def _moved(state: Floats, T: Floats) -> Floats:
    """A of (1) times (3, …, T)."""
    p, v, a = state
    return np.array([p + T * v + T * T / 2 * a, v + T * a, a])


def _process_noise(T: Floats) -> Floats:
    """(3, 3, T) G of (2)."""
    return np.array([[T**5 / 20, T**4 / 8, T**3 / 6], [T**4 / 8, T**3 / 3, T**2 / 2], [T**3 / 6, T**2 / 2, T]])


def update(x: Floats, V: Floats, N: Floats, g: Floats) -> tuple[Floats, Floats]:
    """x (9, n) and V (9, 9, n) of points after measurements, by (3) and (4).

    Args:
        x: (9, n) positions, velocities and accelerations, mm and s.
        V: (9, 9, n) their covariance.
        N: (3, 3, n) information of the measurements, 1/mm².
        g: (3, n) their pull, 1/mm.

    Raises:
        ValueError: an array has another shape or dtype.
    """
    x, V, N, g = _UPDATE(x, V, N, g)
    if compiled := library():
        out = np.empty_like(x), np.empty_like(V)
        compiled.update(x.shape[1], x, V, N, g, *out)
        return out
    return _numpy_update(x, V, N, g)


@np.errstate(all="ignore")
def _numpy_update(x: Floats, V: Floats, N: Floats, g: Floats) -> tuple[Floats, Floats]:
    with_p = V[:, :3]
    before = inverse(V[:3, :3])
    gain = np.einsum("ijt,jkt->ikt", before, inverse(before + N))  # V₀⁻¹ P
    R = before - np.einsum("ijt,jkt->ikt", gain, before)  # (3)
    R = (R + R.swapaxes(0, 1)) / 2  # rounding would make it less symmetric at every update
    x = x + np.einsum("ijt,jt->it", with_p, np.einsum("ijt,jt->it", gain, g))  # (4)
    V = V - np.einsum("ijt,kjt->ikt", np.einsum("ijt,jkt->ikt", with_p, R), with_p)
    return x, V
