"""Where in its cycle a motion is, frame by frame, from what was visible until now (recommended by Swamidas 1997, 5.2).

`phase` finds the phase of a whole trial; this is its on-line half, for tracking. The state is the phase φ in cycles and
its speed s in cycles a frame,

    φ(t+1) = φ(t) + s(t),   s(t+1) = s(t) + w,   E[w²] = q = SPEED_CHANGE² / T³                  (1)

T the length of a cycle, frames, as in (2) of `phase`. A frame's samples y_j of spread s_j about the template m_j say

    [w m'(φ) / s]ᵀ [(y − m(φ)) / s] = g,   w Σ_j m_j'² / s_j² = I,   w = 10 / T                  (2)

(an extended Kalman filter in its information form): P⁻¹ ← P⁻¹ + diag(I, 0), x ← x + P [g, 0]ᵀ, a few times over, as m
bends. Where nothing is seen the phase goes on at its speed and its variance grows.

It begins with several frames together: of 64 phases and of five speeds about 1 / T the pair is taken with the least
squared deviation and (ln s T / SPEEDS)² (3). One frame alone would not do: an arm that bends passes each of its
postures twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
    """The state in the last of the first frames (F, K), F two or more, NaN where missing, by (3) and then (2)."""
    phases, t = np.arange(STEPS) / STEPS, np.arange(len(y))
    cost = np.empty((len(TRIED), STEPS))
    for row, speed in zip(cost, TRIED, strict=True):
        off = (y - template(phases[:, None] + speed / cycle * t)) / spread  # (STEPS, F, K)
        row[:] = INDEPENDENT_FRAMES / cycle * np.nansum(off**2, axis=(1, 2)) + (np.log(speed) / SPEEDS) ** 2
    k, b = np.unravel_index(cost.argmin(), cost.shape)
    start = np.array([phases[b], TRIED[k] / cycle])
    state = PhaseState(start, np.diag([1.0 / STEPS**2, (SPEEDS / cycle) ** 2]))
    state = update_phase(state, y[0], template, spread, cycle=cycle)
    for row in y[1:]:
        state = update_phase(predict_phase(state, cycle=cycle), row, template, spread, cycle=cycle)
    return state


def predict_phase(state: PhaseState, *, cycle: float) -> PhaseState:
    """One frame on, by (1)."""
    A = np.array([[1.0, 1.0], [0.0, 1.0]])
    return PhaseState(A @ state.x, A @ state.P @ A.T + np.diag([0.0, SPEED_CHANGE**2 / cycle**3]))


def update_phase(
    state: PhaseState, y: Floats, template: CycleTemplate, spread: Floats, *, cycle: float
) -> PhaseState:
    """With the samples (K) of the frame, NaN where missing, of spread (K), by (2)."""
    there = ~np.isnan(y)
    if not there.any():
        return state
    x, prior = state.x, np.linalg.inv(state.P)
    for _ in range(ROUNDS):
        slope, off = (template.slope(x[0]) / spread)[there], ((y - template(x[0])) / spread)[there]
        weight = INDEPENDENT_FRAMES / cycle
        P = np.linalg.inv(prior + np.diag([weight * float(slope @ slope), 0.0]))
        x = x + P @ (np.array([weight * float(slope @ off), 0.0]) + prior @ (state.x - x))
    return PhaseState(x, P)
