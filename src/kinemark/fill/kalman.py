"""The Kalman predictor as filler: forwards, forwards and backwards meeting, and a true smoother.

After Swamidas (1997), 3.3, who predicts forwards, and 5.2, who recommends that a forward and a backward prediction
"start at the two ends of the interval and meet in the middle".

**Forward.** Each coordinate of a marker is followed by `signal.smoother` through the samples before the gap, and on
through it (1). The covariance is that of the filter; it grows with the fifth power of the time.

**Forward and backward.** The same on the samples after the gap with time reversed. Neither knows of the other's
samples, so they are two measurements of the same position, and meet where they are equally sure:

    x = (x₁ / P₁ + x₂ / P₂) / (1 / P₁ + 1 / P₂),   P = 1 / (1 / P₁ + 1 / P₂)                             (2)

As P grows so fast, one of them has nearly all the weight except about the middle.

**Smoother.** (2) weighs positions alone. The smoother (Rauch, Tung & Striebel 1965) also makes velocity and
acceleration of the two sides agree (3); with exact samples it is the quintic spline of the gap.

σ and U are found from the marker's own samples, U over a twentieth of a second (`signal.smoother`, 7 to 9). With
`differences`, forward is the thesis' own predictor, that takes velocity and acceleration by differences for measured
(4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data.arrays import check_positive
from ..signal.kalman import State, predict, start, update
from ..signal.smoother import filter_positions, jump_of, noise_of, smooth_positions
from .motion import Gap, Motion, Prediction

Floats = NDArray[np.float64]

FEWEST = 3
"""Samples that a state of position, velocity and acceleration needs."""

GROUPS = 4
"""Of gaps about as long as each other that are worked out at once."""

STRIDE = 0.05
"""Time over which U is found, s."""

Mode = Literal["forward", "forward_backward", "smoother"]


@dataclass(frozen=True, slots=True)
class Kalman:
    """Parameters.

    Attributes:
        mode: "forward", "forward_backward" or "smoother".
        sd: of a measured coordinate, mm; None: found from the marker's samples.
        jerk: by which acceleration changes in a frame's time, as a rate, mm/s³; U is jerk · T³; None: found.
        history: of samples on each side of a gap that count, s.
        differences: "forward" as in the thesis, velocity and acceleration by differences counted as measured.
    """

    mode: Mode = "smoother"
    sd: float | None = None
    jerk: float | None = None
    history: float = 1.0
    differences: bool = False

    def __post_init__(self) -> None:
        if self.mode not in ("forward", "forward_backward", "smoother"):
            raise ValueError(f"mode is {self.mode!r}, wanted forward, forward_backward or smoother")
        check_positive(sd=self.sd, jerk=self.jerk, history=self.history)
        if self.differences and self.mode == "smoother":
            raise ValueError("differences is of the predictor; with it mode must be forward or forward_backward")


class _Windows(NamedTuple):
    """G gaps with their surroundings.

    before, after (G, 3, H) mm, both from far to near; length (G) frames; sd, jump (G, 3) σ mm and U mm/frame².
    """

    before: Floats
    after: Floats
    length: NDArray[np.int64]
    sd: Floats
    jump: Floats


def fill_kalman(motion: Motion, gaps: Sequence[Gap], *, method: Kalman = Kalman()) -> list[Prediction]:
    """What the predictor, forwards, from both sides or smoothed, says of each gap.

    A gap with fewer than three samples within `history` before it ("forward") or on either side, gets none.
    """
    if not gaps:
        return []
    order = np.argsort([gap.length for gap in gaps], kind="stable")
    found: dict[int, Prediction] = {}
    for some in np.array_split(order, min(GROUPS, 1 + len(gaps) // 50)):  # the longest of a group costs for all
        group = [gaps[g] for g in some]
        x, variance = _answers(_windows(motion, group, method), method)
        found |= {int(g): _prediction(x[k], variance[k], gaps[g].length, method) for k, g in enumerate(some)}
    return [found[g] for g in range(len(gaps))]


def _answers(windows: _Windows, method: Kalman) -> tuple[Floats, Floats]:
    """Positions and variances (G, 3, L) in the order of time."""
    if method.mode == "smoother":
        return _smoothed(windows)
    x, variance = _predicted(windows.before, windows, method)
    if method.mode == "forward":
        return x, variance
    back, back_variance = _predicted(windows.after, windows, method)
    return _met(x, variance, *_turned(back, back_variance, windows.length))


def _prediction(x: Floats, variance: Floats, length: int, method: Kalman) -> Prediction:
    if not np.isfinite(x[:, :length]).all():
        side = "before" if method.mode == "forward" else "on either side of"
        return Prediction.none(length, f"fewer than {FEWEST} samples within {method.history:g} s {side} the gap")
    return Prediction(x[:, :length].T, variance[:, :length].T[..., None] * np.eye(3))


def _windows(motion: Motion, gaps: Sequence[Gap], method: Kalman) -> _Windows:
    """The samples about each gap; σ and U of its marker."""
    n_frames, size = motion.xyz.shape[1], max(round(method.history * motion.rate), FEWEST)
    before, after = np.full((2, len(gaps), 3, size), np.nan)
    sd, jump = np.empty((2, len(gaps), 3))
    known: dict[int, tuple[Floats, Floats]] = {}
    for g, gap in enumerate(gaps):
        path = motion.xyz[gap.marker].T
        old, new = path[:, max(gap.start - size, 0) : gap.start], path[:, gap.stop : min(gap.stop + size, n_frames)]
        before[g, :, size - old.shape[1] :], after[g, :, size - new.shape[1] :] = old, new[:, ::-1]
        if gap.marker not in known:
            known[gap.marker] = _noise_and_jump(path, motion.rate, method)
        sd[g], jump[g] = known[gap.marker]
    for side in (before, after):
        side[(~np.isnan(side[:, 0])).sum(1) < FEWEST] = np.nan
    return _Windows(before, after, np.array([gap.length for gap in gaps]), sd, jump)


def _noise_and_jump(path: Floats, rate: float, method: Kalman) -> tuple[Floats, Floats]:
    """σ and U of a marker's coordinates (3, F), given or found."""
    sd = noise_of(path) if method.sd is None else np.full(3, method.sd)
    if method.jerk is not None:
        return sd, np.full(3, method.jerk / rate**3)
    return sd, jump_of(path, max(round(STRIDE * rate), 1), sd)


def _predicted(side: Floats, windows: _Windows, method: Kalman) -> tuple[Floats, Floats]:
    """(1): positions and variances (G, 3, L) from one side on, L of the longest gap."""
    longest = int(windows.length.max())
    if method.differences:
        return _by_differences(side, windows, longest)
    y = np.concatenate([side, np.full((*side.shape[:2], longest), np.nan)], -1).reshape(-1, side.shape[2] + longest)
    found = filter_positions(y, sd=windows.sd.ravel(), jump=windows.jump.ravel())
    shape = (*side.shape[:2], longest)
    return found.x[:, -longest:, 0].reshape(shape), found.P[:, -longest:, 0, 0].reshape(shape)


def _by_differences(side: Floats, windows: _Windows, longest: int) -> tuple[Floats, Floats]:
    """(4): as `_predicted`, gap by gap, since these predictors begin with whole triples."""
    x, variance = np.full((2, *side.shape[:2], longest), np.nan)
    for g, path in enumerate(side):
        sd, jump = float(np.sqrt((windows.sd[g] ** 2).mean())), float(np.sqrt((windows.jump[g] ** 2).mean()))
        state = _follow(path, sd, jump)
        if state is None:
            continue
        for k in range(longest):
            x[g, :, k], variance[g, :, k] = state.x[0, 0], state.P[0, 0, 0]
            state = predict(state, jump)
    return x, variance


def _follow(path: Floats, sd: float, jump: float) -> State | None:
    """The thesis' predictor one frame after the last of the samples (3, H); None without three in a row."""
    state: State | None = None
    for k in range(2, path.shape[1]):
        past = path[:, k - 2 : k + 1].T[None, ::-1]
        whole = not np.isnan(past).any()
        if state is None:
            state = start(past, sd, jump) if whole else None
        elif np.isnan(past[0, 0]).any():
            state = predict(state, jump)
        else:
            state = update(state, np.nan_to_num(past), np.array([whole]), sd, jump)
    return state


def _smoothed(windows: _Windows) -> tuple[Floats, Floats]:
    """(3): positions and variances (G, 3, L)."""
    n, _, size = windows.before.shape
    longest = int(windows.length.max())
    y = np.full((n, 3, 2 * size + longest), np.nan)
    y[..., :size] = windows.before
    for g, length in enumerate(windows.length):
        y[g, :, size + length : 2 * size + length] = windows.after[g, :, ::-1]
    # A sequence begins at its first sample; a gap before which there is none is done backwards.
    late = np.isnan(windows.before[:, 0]).all(1)
    y[late] = y[late, :, ::-1]
    found = smooth_positions(y.reshape(3 * n, -1), sd=windows.sd.ravel(), jump=windows.jump.ravel())
    x, variance = found.x[..., 0].reshape(y.shape), found.P[..., 0, 0].reshape(y.shape)
    x[late], variance[late] = x[late, :, ::-1], variance[late, :, ::-1]
    return x[..., size : size + longest], variance[..., size : size + longest]


def _turned(x: Floats, variance: Floats, length: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Backward predictions (G, 3, L) in the order of time."""
    turned, turned_variance = np.full_like(x, np.nan), np.full_like(x, np.nan)
    for g, n in enumerate(length):
        turned[g, :, :n], turned_variance[g, :, :n] = x[g, :, :n][:, ::-1], variance[g, :, :n][:, ::-1]
    return turned, turned_variance


def _met(x1: Floats, P1: Floats, x2: Floats, P2: Floats) -> tuple[Floats, Floats]:
    """(2); where only one of the two is, that."""
    w1, w2 = (np.where(np.isnan(x), 0.0, 1 / P) for x, P in ((x1, P1), (x2, P2)))
    with np.errstate(invalid="ignore", divide="ignore"):
        return (np.nan_to_num(x1) * w1 + np.nan_to_num(x2) * w2) / (w1 + w2), 1 / (w1 + w2)
