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
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...data.method import parameter
from ...signal.kalman import follow, predict
from ...signal.smoother import GapPositions, measurement_sd_of, predict_gaps, process_sd_of, smooth_gaps
from ..marker_array import Gap, MarkerArray, Prediction
from .stage import FILL, FillMethod

FEWEST = 3
"""Samples that a state of position, velocity and acceleration needs; by definition."""

STRIDE = 0.05
"""Time over which U is found, s; chosen (see benchmarks/gaps.py)."""

Mode = Literal["forward", "forward_backward", "smoother"]


@dataclass(frozen=True, slots=True)
class Kalman(FillMethod):
    """Kalman prediction of position, velocity and acceleration, from one side or both, or smoothed."""

    mode: Mode = parameter(
        "smoother", meaning="prediction from before the gap, from before and after it, or the Kalman smoother"
    )
    measurement_sd: float | None = parameter(
        None, unit="mm", above=0, meaning="standard deviation of a measured coordinate; None: found from the samples"
    )
    jerk: float | None = parameter(
        None, unit="mm/s³", above=0,
        meaning="process noise: by which acceleration changes in a frame's time, as a rate; U is jerk · T³; None: "
        "found",
    )  # fmt: skip
    margin: float = parameter(1.0, unit="s", above=0, meaning="how much of the samples on each side of the gap is used")
    differences: bool = parameter(
        False,
        meaning="as in the thesis, velocity and acceleration by differences counted as measured; not of the smoother",
    )

    def check_together(self) -> None:
        """Refuse differences for the smoother."""
        if self.differences and self.mode == "smoother":
            raise ValueError("differences is of the predictor; with it mode must be forward or forward_backward")

    def for_many_gaps(self, gaps: Sequence[Gap], source: MarkerArray | None) -> Kalman:
        """The same from a quarter of a second on each side."""
        return replace(self, margin=min(self.margin, 0.25))


class _Windows(NamedTuple):
    """G gaps with their surroundings.

    before, after (G, 3, H) mm, both from far to near; length (G) frames; sd, process_sd (G, 3) σ mm and U mm/frame².
    """

    before: Floats
    after: Floats
    length: Ints
    sd: Floats
    process_sd: Floats


@FILL.method("kalman", Kalman, rank=10, source="Swamidas 1997, 3.3 and 5.2")
def fill_kalman(motion: MarkerArray, gaps: Sequence[Gap], *, method: Kalman = Kalman()) -> list[Prediction]:
    """What the predictor, forwards, from both sides or smoothed, says of each gap.

    A gap with fewer than three samples within `history` before it ("forward") or on either side, gets none.
    """
    if not gaps:
        return []
    answers = _answers(_windows(motion, gaps, method), method)
    return [_prediction(*answer, method) for answer in answers]


def _answers(windows: _Windows, method: Kalman) -> list[GapPositions]:
    """Positions and variances (3, L) of each gap in the order of time."""
    if method.mode == "smoother":
        return _smoothed(windows)
    found = _predicted(windows.before, windows, method)
    if method.mode == "forward":
        return found
    back = _predicted(windows.after, windows, method)
    return [_met(one, GapPositions(*(a[:, ::-1] for a in other))) for one, other in zip(found, back, strict=True)]


def _prediction(x: Floats, variance: Floats, method: Kalman) -> Prediction:
    if not np.isfinite(x).all():
        side = "before" if method.mode == "forward" else "on either side of"
        return Prediction.none(x.shape[1], f"fewer than {FEWEST} samples within {method.margin:g} s {side} the gap")
    return Prediction(x.T, variance.T[..., None] * np.eye(3))


def _windows(motion: MarkerArray, gaps: Sequence[Gap], method: Kalman) -> _Windows:
    """The samples about each gap; σ and U of its marker."""
    n_frames, size = motion.xyz.shape[1], max(round(method.margin * motion.rate), FEWEST)
    before, after = np.full((2, len(gaps), 3, size), np.nan)
    sd, process_sd = np.empty((2, len(gaps), 3))
    known: dict[int, tuple[Floats, Floats]] = {}
    for g, gap in enumerate(gaps):
        path = motion.xyz[gap.marker].T
        old, new = path[:, max(gap.start - size, 0) : gap.start], path[:, gap.stop : min(gap.stop + size, n_frames)]
        before[g, :, size - old.shape[1] :], after[g, :, size - new.shape[1] :] = old, new[:, ::-1]
        if gap.marker not in known:
            known[gap.marker] = _noise_and_jump(np.ascontiguousarray(path), motion.rate, method)
        sd[g], process_sd[g] = known[gap.marker]
    for side in (before, after):
        side[(~np.isnan(side[:, 0])).sum(1) < FEWEST] = np.nan
    return _Windows(before, after, np.array([gap.length for gap in gaps]), sd, process_sd)


def _noise_and_jump(path: Floats, rate: float, method: Kalman) -> tuple[Floats, Floats]:
    """σ and U of a marker's coordinates (3, F), given or found."""
    sd = measurement_sd_of(path) if method.measurement_sd is None else np.full(3, method.measurement_sd)
    if method.jerk is not None:
        return sd, np.full(3, method.jerk / rate**3)
    return sd, process_sd_of(path, max(round(STRIDE * rate), 1), sd)


def _predicted(side: Floats, windows: _Windows, method: Kalman) -> list[GapPositions]:
    """(1): positions and variances (3, L) from one side on."""
    if method.differences:
        each = zip(side, windows.sd, windows.process_sd, windows.length, strict=True)
        return [_by_differences(*gap) for gap in each]
    return _of_markers(predict_gaps(_flat(side), np.repeat(windows.length, 3), **_model(windows)))


def _by_differences(path: Floats, sd: Floats, process_sd: Floats, length: int) -> GapPositions:
    """(4): as `_predicted` for one gap, since these predictors begin with whole triples."""
    found = GapPositions(*np.full((2, 3, length), np.nan))
    one_sd, one_process_sd = float(np.sqrt((sd**2).mean())), float(np.sqrt((process_sd**2).mean()))
    state = follow(path.T, one_sd, one_process_sd)
    if state is None:
        return found
    for k in range(length):
        found.x[:, k], found.variance[:, k] = state.x[0, 0], state.P[0, 0, 0]
        state = predict(state, one_process_sd)
    return found


def _smoothed(windows: _Windows) -> list[GapPositions]:
    """(3): positions and variances (3, L); a gap before which there is no sample is done backwards."""
    late = np.asarray(np.isnan(windows.before[:, 0]).all(1))
    before = np.where(late[:, None, None], windows.after, windows.before)
    after = np.where(late[:, None, None], windows.before, windows.after)
    each = smooth_gaps(_flat(before), _flat(after)[:, ::-1], np.repeat(windows.length, 3), **_model(windows))
    found = _of_markers(each)
    return [GapPositions(*(a[:, ::-1] for a in one)) if back else one for one, back in zip(found, late, strict=True)]


def _flat(side: Floats) -> Floats:
    """(G, 3, H) as sequences (3 G, H)."""
    return side.reshape(-1, side.shape[2])


def _model(windows: _Windows) -> dict[str, Floats]:
    return {"sd": windows.sd.ravel(), "process_sd": windows.process_sd.ravel()}


def _of_markers(each: list[GapPositions]) -> list[GapPositions]:
    """Three coordinates (L) as one (3, L)."""
    return [GapPositions(*map(np.array, zip(*each[k : k + 3], strict=True))) for k in range(0, len(each), 3)]


def _met(one: GapPositions, other: GapPositions) -> GapPositions:
    """(2); where only one of the two is, that."""
    w1, w2 = (np.where(np.isnan(side.x), 0.0, 1 / side.variance) for side in (one, other))
    with np.errstate(invalid="ignore", divide="ignore"):
        x = (np.nan_to_num(one.x) * w1 + np.nan_to_num(other.x) * w2) / (w1 + w2)
        return GapPositions(x, 1 / (w1 + w2))
