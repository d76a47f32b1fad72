"""The component angle model made from a trial: the mean of its cycles over percent of the cycle (Swamidas 1997, 3.5.1).

Of each segment the unit vector u(t) from one marker to the other is taken, whose components are the cosines of the
angles with the axes (3.34, 3.35). The mean is taken of these vectors and made a unit vector again, not of the angles:
an angle with an axis folds where the segment crosses the axis, and the mean of a folded angle leans away from it.

1. The cycle T is found from all directions together (`signal.periodic`), which, unlike positions, come back in walking.
2. The phase is at first t / T.
3. Each cycle is read at B equal steps of phase, between frames by the cubic through four of them, or a line where one
   of the four is missing; the mean of all cycles that have a step is the template (1), their spread about it the
   covariance (2), with n − 1.
4. The phase of each frame is fitted to the template (`signal.phase`), so that a stride that is faster than the mean is
   no spread; then 3 again.

A step of the cycle at which a segment was never seen is bridged from its neighbours if the hole is a tenth of the
cycle at most (3); a segment with a longer one, always hidden in the same part of the cycle, is left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..data import AngleModel, KinemarkError
from ..data.array_types import Floats, Ints
from .periodic import cycle_length
from .phase import CyclePhase, CycleTemplate, refine_phase
from .segment_directions import LinkedSegments, directions

STEPS = 100
"""B of the model, steps of a cycle: percent, by definition."""
LEAST_SPREAD = 0.02
"""Of a direction; what marks on skin do at least; chosen (see studies/missing_markers.py)."""
ONE_CYCLE = 0.1
"""Spread taken where one cycle only was seen; chosen (see studies/missing_markers.py)."""
HOLE = 0.1
"""Of the cycle, the longest part that may be unknown, of (3); chosen (see studies/missing_markers.py)."""
MOST = 60
"""Sequences that the cycle and the phase are found from; chosen (see studies/missing_markers.py)."""
ROUNDS = 3  # of phase and mean in turn; chosen: few settle it (see studies/missing_markers.py)
DENSE = 24
"""Frames a cycle that are enough for its phase and its mean; chosen (see studies/missing_markers.py)."""
LONG = 1500
"""Frames of a trial above which it is thinned to that; chosen (see studies/missing_markers.py)."""
ENOUGH = 40
"""Times the longest cycle that is looked for, of the middle of a trial in which the cycle is found.
Chosen (see studies/missing_markers.py)."""
CYCLES = 100
"""That are enough for a mean; of more, some are taken, evenly spread; chosen (see studies/missing_markers.py)."""
WHOLE = 1.2
"""Cycles that a trial must hold for its cycle to be seen coming back; chosen (see studies/missing_markers.py)."""


class Learned(NamedTuple):
    """A model and the phase of the trial's frames in it."""

    model: AngleModel
    phase: CyclePhase


def learn_model(
    xyz: Floats,
    *,
    rate: float,
    names: Sequence[str],
    segments: LinkedSegments,
    period: float | None = None,
    shortest: float = 0.3,
    longest: float = 6.0,
) -> Learned:
    """The model of a trial (M, F, 3) mm, NaN where missing; of a long one at every so many frames.

    Args:
        xyz: paths.
        rate: Hz.
        names: (M).
        segments: of these markers.
        period: of a cycle, s; None: found.
        shortest, longest: of cycles looked for, s.

    Raises:
        KinemarkError: no segments, no cycle, or less than one whole cycle; the message says which.
    """
    if not len(segments.link):
        raise KinemarkError("No two markers keep their distance, so there are no segments. Name them as links.")
    n_frames = xyz.shape[1]
    T = period * rate if period else _period(xyz, segments.link, rate, shortest, longest)
    if n_frames < WHOLE * T:
        raise KinemarkError(
            f"The trial has {n_frames} frames, and a cycle of {T:.1f} frames needs {WHOLE:g} times as many."
        )
    step = int(np.clip(min(T / DENSE, n_frames / LONG), 1, None))
    y = columns(xyz[:, ::step], segments.link)
    phase = _own_phase(y, T / step)
    mean, cycles = mean_cycle(y, phase.cycles)
    return Learned(_model(mean, cycles, names, segments, T / rate), _spread_out(phase, step, n_frames))


def columns(xyz: Floats, link: Ints) -> Floats:
    """Directions (F, 3 S) of segments (S, 2) as columns."""
    return np.ascontiguousarray(directions(xyz, link).swapaxes(1, 2).reshape(-1, xyz.shape[1]).T)


def _own_phase(y: Floats, T: float) -> CyclePhase:
    """Steps 2 to 4."""
    some = y[:, most_moving(y)]
    phase = CyclePhase(np.arange(len(y)) / T, np.nan)
    for _ in range(ROUNDS):
        phase = _better_phase(some, phase, T)
    return phase


def _spread_out(phase: CyclePhase, step: int, n_frames: int) -> CyclePhase:
    """In all frames, of one known in every so many: it bends little from frame to frame."""
    if step == 1:
        return phase
    return CyclePhase(
        scipy.interpolate.CubicSpline(step * np.arange(len(phase.cycles)), phase.cycles)(np.arange(n_frames)),
        phase.cost,
    )


def most_moving(y: Floats) -> Ints:
    """Columns of y (F, K) of segments that move most and are seen most, three each and `MOST` in all, for time's
    sake."""
    there = ~np.isnan(y)
    known, n = np.where(there, y, 0.0), np.maximum(there.sum(0), 1)
    moved = (np.einsum("fk,fk->k", known, known) - known.sum(0) ** 2 / n).reshape(-1, 3).sum(1)
    rows = np.sort(np.argsort(-moved, kind="stable")[: MOST // 3])
    return np.asarray((3 * rows[:, None] + np.arange(3)).ravel())


def _better_phase(y: Floats, phase: CyclePhase, T: float) -> CyclePhase:
    """Steps 3 and 4."""
    mean, cycles = mean_cycle(y, phase.cycles)
    known = np.isfinite(mean).all(0)
    if not known.any():
        raise KinemarkError("No segment was seen through all parts of the cycle.")
    spread = spread_of(cycles, mean)
    return refine_phase(y[:, known], CycleTemplate(mean[:, known]), spread[known], phase.cycles, cycle=T)


def _period(xyz: Floats, link: Ints, rate: float, shortest: float, longest: float) -> float:
    """Frames of a cycle, found from the segments that tell most."""
    some = most_moving(columns(xyz[:, :: max(1, xyz.shape[1] // LONG)], link))[::3] // 3
    centre, reach = xyz.shape[1] // 2, math.ceil(min(ENOUGH * longest * rate, xyz.shape[1]) / 2)
    y = columns(xyz[:, max(centre - reach, 0) : centre + reach], link[some])
    T = cycle_length(y.T, shortest=shortest * rate, longest=min(longest * rate, xyz.shape[1] / WHOLE))
    if np.isnan(T):
        raise KinemarkError(f"The motion does not come back within {longest:g} s, so there is no cycle to learn.")
    return T


def mean_cycle(y: Floats, phase: Floats) -> tuple[Floats, Floats]:
    """(1): the mean (B, K), NaN for a sequence with holes, and single cycles (C, B, K) of samples y (F, K) at phases
    (F), of at most `CYCLES` cycles."""
    rising = np.maximum.accumulate(phase)
    whole = np.arange(np.floor(rising[0]), np.floor(rising[-1]) + 1)
    whole = whole[:: -(-len(whole) // CYCLES)]
    wanted = whole[:, None] + np.arange(STEPS) / STEPS
    frame = np.interp(wanted, rising, np.arange(len(rising)), left=np.nan, right=np.nan)
    cycles = CycleInterpolation.at(frame.ravel(), len(y)).read(y).reshape(*frame.shape, -1)
    there = ~np.isnan(cycles)
    n = there.sum(0)
    mean = np.where(n > 0, np.where(there, cycles, 0.0).sum(0) / np.maximum(n, 1), np.nan)
    return bridged(mean), cycles


class CycleInterpolation(NamedTuple):
    """Places between frames: frame (4, N) those about each, cubic and line (4, N) their weights; NaN outside the
    frames."""

    frame: Ints
    cubic: Floats
    line: Floats

    @classmethod
    def at(cls, moments: Floats, n_frames: int) -> CycleInterpolation:
        """For moments (N) in frames and parts of them, NaN for none."""
        inside = np.isfinite(moments)
        moment = np.where(inside, moments, 0.0)
        whole = np.clip(np.floor(moment).astype(np.int64), 0, max(n_frames - 2, 0))
        t = np.where(inside, moment - whole, np.nan)
        edge = (whole < 1) | (whole + 2 > n_frames - 1)
        cubic = np.stack(
            [
                -t * (t - 1) * (t - 2) / 6,
                (t + 1) * (t - 1) * (t - 2) / 2,
                -(t + 1) * t * (t - 2) / 2,
                (t + 1) * t * (t - 1) / 6,
            ]
        )
        line = np.stack([0 * t, 1 - t, t, 0 * t])
        return cls(np.clip(whole + np.arange(-1, 3)[:, None], 0, n_frames - 1), np.where(edge, np.nan, cubic), line)

    def read(self, y: Floats) -> Floats:
        """(N, 3 S) of directions y (F, 3 S): cubic, linear where that is not known, or NaN."""
        found, y = weights(self.cubic, self.frame, len(y)) @ y, y.reshape(len(y), -1, 3)
        ways = found.reshape(len(found), -1, 3)
        row, segment = np.nonzero(np.isnan(ways[..., 0]))
        there, (first, then) = ~np.isnan(y[..., 0]), self.line[1:3, row]
        known = (there[self.frame[1, row], segment] | (first == 0)) & (there[self.frame[2, row], segment] | (then == 0))
        row, segment = row[known], segment[known]
        first, then = self.line[1, row, None], self.line[2, row, None]
        a, b = y[self.frame[1, row], segment], y[self.frame[2, row], segment]
        ways[row, segment] = np.where(then == 0, a, np.where(first == 0, b, first * a + then * b))
        return np.asarray(found)


def weights(weight: Floats, frame: Ints, n_frames: int) -> Any:
    """A sparse matrix (N, F) of weights (…, N) of frames (…, N)."""
    n, each = weight.shape[-1], weight.size // max(weight.shape[-1], 1)
    entries = np.arange(n + 1) * each
    return scipy.sparse.csr_array(
        (weight.reshape(each, n).T.ravel(), frame.reshape(each, n).T.ravel(), entries), (n, n_frames)
    )


def bridged(mean: Floats) -> Floats:
    """(3) for (B, K)."""
    mean = mean.copy()
    steps = len(mean)
    for k in np.flatnonzero(np.isnan(mean).any(0)):
        own = np.flatnonzero(~np.isnan(mean[:, k]))
        if not len(own) or np.diff(own, append=own[0] + steps).max() > HOLE * steps + 1:
            mean[:, k] = np.nan
            continue
        round_it = np.concatenate([own - steps, own, own + steps])
        mean[:, k] = scipy.interpolate.PchipInterpolator(round_it, np.tile(mean[own, k], 3))(np.arange(steps))
    return mean


def spread_of(cycles: Floats, mean: Floats) -> Floats:
    """(K) standard deviation of cycles (C, B, K) about the mean, `LEAST_SPREAD` at least; `ONE_CYCLE` where there is
    one."""
    deviation = cycles - mean
    there = ~np.isnan(deviation)
    n, deviation = there.sum(0), np.where(there, deviation, 0.0)
    use = n >= 2
    total = np.where(use, np.einsum("cbk,cbk->bk", deviation, deviation), 0.0).sum(0)
    free = np.where(use, n - 1, 0).sum(0)
    spread = np.sqrt(total / np.maximum(free, 1))
    return np.where(free > 0, np.maximum(spread, LEAST_SPREAD), ONE_CYCLE)


def _model(mean: Floats, cycles: Floats, names: Sequence[str], segments: LinkedSegments, period: float) -> AngleModel:
    """Of the segments that were seen all round."""
    steps, n_segments = len(mean), len(segments.link)
    deviation = np.moveaxis((cycles - mean).reshape(len(cycles), steps, n_segments, 3), -1, 0).copy()  # (3, C, B, S)
    there = ~np.isnan(deviation[0])
    n = there.sum(0)
    deviation[:, ~there] = 0.0
    cov = np.empty((n_segments, steps, 3, 3))
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        cov[..., i, j] = cov[..., j, i] = np.einsum("cbs,cbs->sb", deviation[i], deviation[j])
    with np.errstate(invalid="ignore", divide="ignore"):
        cov /= np.where(n >= 2, n - 1.0, np.nan).T[..., None, None]  # (2)
        direction = mean.reshape(steps, n_segments, 3).swapaxes(0, 1)
        direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    use = np.isfinite(direction).all((1, 2))
    if not use.any():
        raise KinemarkError("No segment was seen through all parts of the cycle.")
    return AngleModel(
        tuple(names), segments.link[use], segments.bank[use], segments.length[use], segments.spread[use],
        direction[use], cov[use], n.T[use], period,
    )  # fmt: skip


def template_of(model: AngleModel) -> tuple[CycleTemplate, Floats]:
    """The model's directions as a template of 3 S sequences, and their spread (3 S)."""
    values = model.direction.swapaxes(0, 1).reshape(model.direction.shape[1], -1)
    variance = np.diagonal(model.cov, axis1=-2, axis2=-1)
    some = np.isfinite(variance).any(1)
    mean = np.where(some, np.nansum(variance, axis=1) / np.maximum(np.isfinite(variance).sum(1), 1), ONE_CYCLE**2)
    return CycleTemplate(values), np.maximum(np.sqrt(mean), LEAST_SPREAD).ravel()
