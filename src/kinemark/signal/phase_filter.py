"""Where in its cycle a motion is, frame by frame, from what was visible until now (recommended by Swamidas 1997, 5.2).

`phase` finds the phase of a whole trial; this is its on-line half, for tracking. The state is the phase φ in cycles and
its speed s in cycles a frame,

    φ(t+1) = φ(t) + s(t),   s(t+1) = s(t) + w,   E[w²] = q = SPEED_CHANGE² / T³                  (1)

T the length of a cycle, frames, as in (2) of `phase`. A frame's samples y_j of spread s_j about the template m_j say

    [w m'(φ) / s]ᵀ [(y − m(φ)) / s] = g,   w Σ_j m_j'² / s_j² = I,   w = 10 / T                  (2)

(an extended Kalman filter in its information form): P⁻¹ ← P⁻¹ + diag(I, 0), x ← x + P [g, 0]ᵀ, a few times over, as m
bends. Where nothing is seen the phase goes on at its speed and its variance grows.

It begins with several frames together: phase and speed minimise the squared deviations of (2) and (ln s T / SPEEDS)²
(3), from the best of 64 phases and five speeds about 1 / T on. One frame alone would not do: an arm that bends passes
each of its postures twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Floats
from .phase import INDEPENDENT_FRAMES, SPEED_CHANGE, STEPS, CycleTemplate

SPEEDS = 0.1
"""Standard deviation of the cadence about the model's, as a share, of (3); chosen: people walk more alike."""
TRIED = np.array([0.8, 0.9, 1.0, 1.1, 1.25])
"""Speeds over 1 / T that are tried at the beginning; chosen, two standard deviations to either side."""
ROUNDS = 3  # of (2) in a frame; chosen: few settle it


class PhaseState(NamedTuple):
    """x (2) phase in cycles and speed in cycles a frame; P (2, 2) their covariance."""

    x: Floats
    P: Floats

    @property
    def phase(self) -> float:
        """Cycles."""
        return float(self.x[0])

    @property
    def variance(self) -> float:
        """Of the phase, cycles²."""
        return float(self.P[0, 0])


def begin_phase(y: Floats, template: CycleTemplate, spread: Floats, *, cycle: float) -> PhaseState:
    """The state in the last of the first frames (F, K), F two or more, NaN where missing, by (3)."""
    t = np.arange(len(y)) - (len(y) - 1)
    there, weight = ~np.isnan(y), np.sqrt(INDEPENDENT_FRAMES / cycle) / spread

    def residual(x: Floats) -> Floats:
        """Of (3): what phase and relative speed (2) leave."""
        left = np.where(there, weight * (np.nan_to_num(y) - template(x[0] + x[1] / cycle * t)), 0.0)
        return np.append(left.ravel(), np.log(x[1]) / SPEEDS)

    starts = [np.array([b / STEPS, speed]) for b in range(STEPS) for speed in TRIED]
    start = min(starts, key=lambda x: float((residual(x) ** 2).sum()))
    found = scipy.optimize.least_squares(residual, start, x_scale=[0.01, 0.1], bounds=([-np.inf, 0.5], [np.inf, 2.0]))
    scale = np.diag([1.0, 1 / cycle])
    jacobian = np.asarray(found.jac)
    information = jacobian.T @ jacobian + np.diag([1e-6, 0.0])  # a template that stands still tells nothing
    return PhaseState(scale @ found.x, scale @ np.linalg.inv(information) @ scale)


def predict_phase(state: PhaseState, *, cycle: float) -> PhaseState:
    """One frame on, by (1)."""
    A = np.array([[1.0, 1.0], [0.0, 1.0]])
    return PhaseState(A @ state.x, A @ state.P @ A.T + np.diag([0.0, SPEED_CHANGE**2 / cycle**3]))


def update_phase(state: PhaseState, y: Floats, template: CycleTemplate, spread: Floats, *, cycle: float) -> PhaseState:
    """With the samples (K) of the frame, NaN where missing, of spread (K), by (2)."""
    there = ~np.isnan(y)
    if not there.any():
        return state
    x, prior = state.x, np.linalg.inv(state.P)
    for _ in range(ROUNDS):
        slope, residual = (template.slope(x[0]) / spread)[there], ((y - template(x[0])) / spread)[there]
        weight = INDEPENDENT_FRAMES / cycle
        P = np.linalg.inv(prior + np.diag([weight * float(slope @ slope), 0.0]))
        x = x + P @ (np.array([weight * float(slope @ residual), 0.0]) + prior @ (state.x - x))
    return PhaseState(x, P)
