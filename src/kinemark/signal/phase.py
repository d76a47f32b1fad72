"""Where in its cycle a motion is, from whatever is visible of it (recommended by Swamidas 1997, 5.2).

A template m_j(φ) says what each sequence y_j is at phase φ, counted in cycles; m has the period 1. Wanted is φ(t),
which grows by about 1/T a frame, T the length of a cycle, from samples of which any may be missing. Minimised is

    E = w Σ_t Σ_j∈seen(t) [y_j(t) − m_j(φ(t))]² / s_j² + Σ_t [φ(t+1) − 2 φ(t) + φ(t−1)]² / q         (1)

s_j is the spread of sequence j about the template. As deviations last, frames are not independent: w = 10 / T counts
ten of them a cycle. Speed walks at random, by the share 0.1 of itself in a cycle: q = 0.1² / T³ (2).

E has many minima, one at least for each cycle. A coarse search finds the right one: phases in 64 steps, sixteen
frames a cycle, advances of 1 to 8 steps (4 is the mean speed), and the path with the least sum of the first term and
[(advance − 4) / 2]² by dynamic programming (3). From there Newton's method after Gauss: with m' the slope of the
template, the steps δ solve

    [w Σ_j m_j'² / s_j² + D₂ᵀD₂ / q] δ = w Σ_j m_j' (y_j − m_j) / s_j² − D₂ᵀD₂ φ / q                 (4)

a matrix of five diagonals. Frames of which nothing is seen go on at a speed that joins those before and after. The
variance of φ(t) is the diagonal of the inverse of the matrix in (4) (5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Bools, Floats, Ints

STEPS, A_CYCLE, MEAN, MOST = 64, 16, 4, 8
"""Of (3): steps and frames a cycle, the mean advance and the greatest; chosen."""
ROUNDS = 10
"""Steps of (4) at most; chosen."""
INDEPENDENT_FRAMES = 10.0
"""Frames a cycle that count, of (1); chosen."""
SPEED_CHANGE = 0.1
"""Share of the speed by which it walks in a cycle, of (2); chosen."""


class CycleTemplate:
    """m of (1): sequences as smooth functions of the phase, from their values (B, K) at phases 0, 1/B, …"""

    def __init__(self, values: Floats) -> None:
        closed = np.concatenate([values, values[:1]])
        curve = scipy.interpolate.CubicSpline(np.linspace(0, 1, len(closed)), closed, bc_type="periodic")
        self._curve: scipy.interpolate.PPoly[np.float64] = curve
        self._slope: scipy.interpolate.PPoly[np.float64] = curve.derivative()

    def __call__(self, phase: Floats) -> Floats:
        """(…, K) at phases (…) in cycles."""
        return np.asarray(self._curve(phase % 1.0))

    def slope(self, phase: Floats) -> Floats:
        """(…, K) a cycle."""
        return np.asarray(self._slope(phase % 1.0))

    def select(self, columns: Ints) -> CycleTemplate:
        """Of these sequences (n) alone."""
        out = object.__new__(CycleTemplate)
        out._curve, out._slope = (
            scipy.interpolate.PPoly.construct_fast(p.c[..., columns], p.x) for p in (self._curve, self._slope)
        )
        return out


class CyclePhase(NamedTuple):
    """φ (F) of (1) in cycles, never wrapped; cost, the mean over the samples seen of the first term without w: about
    1 where the motion is that of the template, many where it is another."""

    cycles: Floats
    cost: float

    def frames_at(self, percent: float) -> Floats:
        """(n) moments, in frames and parts of them, at which the motion passes this percent of its cycle."""
        rising = np.maximum.accumulate(self.cycles)
        whole = np.arange(np.ceil(rising[0] - percent / 100), np.floor(rising[-1] - percent / 100) + 1)
        return np.interp(whole + percent / 100, rising, np.arange(len(rising)))


def find_phase(y: Floats, template: CycleTemplate, spread: Floats, *, cycle: float) -> CyclePhase:
    """The phase of each frame by (3) and (4).

    Args:
        y: (F, K) samples, NaN where missing; F two or more.
        template: of the K sequences.
        spread: (K) s.
        cycle: T, frames; right to a third or so.

    Raises:
        ValueError: no sample is there, or fewer than two frames.
    """
    if len(y) < 2 or np.isnan(y).all():
        raise ValueError(
            f"y has {len(y)} frames and {int((~np.isnan(y)).sum())} samples, wanted two frames and samples"
        )
    return refine_phase(y, template, spread, coarse_phase(y, template, spread, cycle), cycle=cycle)


def coarse_phase(y: Floats, template: CycleTemplate, spread: Floats, cycle: float) -> Floats:
    """(F) of (3)."""
    every = cycle / A_CYCLE
    frames = np.unique(np.rint(np.arange(0, len(y) - 1 + every, every)).astype(np.int64).clip(0, len(y) - 1))
    there = ~np.isnan(y[frames])
    seen, m, w = np.where(there, y[frames], 0.0), template(np.arange(STEPS) / STEPS), spread**-2.0
    cost = (seen**2) @ w
    cost = cost[:, None] - 2 * seen @ (w * m).T + there @ (w * m**2).T  # (N, STEPS)
    cost *= INDEPENDENT_FRAMES / A_CYCLE
    advance_cost = ((np.arange(1, MOST + 1) - MEAN) / 2.0) ** 2
    total, advance_of = cost[0].copy(), np.zeros(cost.shape, np.int64)
    for k in range(1, len(frames)):
        paths = np.stack([np.roll(total, advance) for advance in range(1, MOST + 1)]) + advance_cost[:, None]
        advance_of[k] = paths.argmin(0)
        total = paths.min(0) + cost[k]
    path = np.empty(len(frames), np.int64)
    path[-1] = total.argmin()
    for k in range(len(frames) - 1, 0, -1):
        path[k - 1] = path[k] - advance_of[k, path[k] % STEPS] - 1
    return np.interp(np.arange(len(y)), frames, path / STEPS)


def refine_phase(y: Floats, template: CycleTemplate, spread: Floats, phase: Floats, *, cycle: float) -> CyclePhase:
    """(4) from a phase (F) near the right one; other arguments as in `find_phase`."""
    weight = np.where(np.isnan(y), 0.0, 1 / spread)
    y = np.nan_to_num(y)
    for _ in range(ROUNDS):
        residual, slope = weight * (y - template(phase)), weight * template.slope(phase)
        gradient = INDEPENDENT_FRAMES / cycle * np.einsum("fk,fk->f", slope, residual) - _smoothness_gradient(
            phase, cycle
        )
        try:
            step = np.asarray(
                scipy.linalg.solveh_banded(_matrix(_information(slope, cycle), cycle), gradient, lower=True)
            )
        except scipy.linalg.LinAlgError:
            break
        phase = phase + step.clip(-0.05, 0.05)
        if np.abs(step).max() < 1e-5:
            break
    residual = weight * (y - template(phase))
    return CyclePhase(phase, float((residual**2).sum() / max((weight > 0).sum(), 1)))


def _smoothness_gradient(phase: Floats, cycle: float) -> Floats:
    """D₂ᵀD₂ φ / q."""
    force, second = np.zeros(len(phase)), np.diff(phase, 2)
    for k, factor in enumerate((1.0, -2.0, 1.0)):
        force[k : len(phase) - 2 + k] += factor * second
    return force * cycle**3 / SPEED_CHANGE**2


def _information(slope: Floats, cycle: float) -> Floats:
    """w Σ_j m_j'² / s_j² (F) from m' / s (F, K), 0 where nothing is seen."""
    return np.asarray(INDEPENDENT_FRAMES / cycle * np.einsum("fk,fk->f", slope, slope))


def _matrix(frame_information: Floats, cycle: float) -> Floats:
    """The matrix of (4), its lower diagonals (3, F), from its first term (F)."""
    n = len(frame_information)
    bands = np.zeros((3, n))
    for j in range(3):
        for i in range(j, 3):
            bands[i - j, j : max(n - 2 + j, j)] += (1.0, -2.0, 1.0)[i] * (1.0, -2.0, 1.0)[j]
    bands *= cycle**3 / SPEED_CHANGE**2
    bands[0] += frame_information
    bands[0] += 1e-9 * bands[0].max()
    return bands


def phase_variance(
    y: Floats, template: CycleTemplate, spread: Floats, phase: Floats, frames: Ints, *, cycle: float
) -> Floats:
    """(5) at some frames, cycles²; looked at from one cycle about them."""
    return variance_at(information(~np.isnan(y), template, spread, phase, cycle=cycle), frames, cycle=cycle)


def information(there: Bools, template: CycleTemplate, spread: Floats, phase: Floats, *, cycle: float) -> Floats:
    """(F) the first term of the matrix of (4), from what is there (F, K) of the sequences."""
    return _information(np.where(there, template.slope(phase) / spread, 0.0), cycle)


def variance_at(frame_information: Floats, frames: Ints, *, cycle: float) -> Floats:
    """`phase_variance` from the `information` (F) of all frames."""
    first, last = max(int(frames.min() - cycle), 0), min(int(frames.max() + cycle) + 1, len(frame_information))
    unit = np.zeros((last - first, len(frames)))
    unit[frames - first, np.arange(len(frames))] = 1.0
    solved = np.asarray(
        scipy.linalg.solveh_banded(_matrix(frame_information[first:last], cycle), unit, lower=True, check_finite=False)
    )
    return np.maximum(solved[frames - first, np.arange(len(frames))], 0.0)
