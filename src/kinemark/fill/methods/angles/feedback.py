"""The thesis' own filler: the predictor, checked against the component angle model and put right (Swamidas 1997,
3.5.2).

Frame by frame, forwards. A missing marker is predicted by the three-state predictor (`signal.kalman`). Then, if any
is missing:

1. The component angles of all segments that it belongs to are formed from predicted and observed markers (3.35).
2. They pass where each lies within what the model's angle is anywhere within ±5 % of the cycle about the present
   phase (1).
   The phase, which the thesis gives by hand, is found (`signal.phase`).
3. If one fails, the marker is put where the observed markers, lengths and the model's angles at the phase have it, in
   steps from
   marker to marker (2). Where several neighbours are known their mean is taken.
4. That place is fed back into the predictor.

**Feedback "position"** is the thesis': the place counts as measured, and velocity and acceleration are the
differences of it and the two positions before, which were predicted:

    Y = D [x; x̂(k−1); x̂(k−2)],   D = [1 0 0; 3/2 −2 1/2; 1 −2 1]                                 (3)

A correction by e is then a velocity of 3/2 e a frame and an acceleration of e a frame², which is not there: the next
prediction is e + 3/2 e + e / 2 = 3 e too far where the gain is 1, fails again on the other side, and so on. This is
the oscillation of the thesis' figure 4.19, which it holds for unavoidable.

**Feedback "path"** takes away the false velocity. The model says where the marker was in the two frames before, as
well: these replace the predicted ones,

    Y = D [x; x_model(k−1); x_model(k−2)]                                                        (4)

The predictor then overshoots no more, but the curve still jumps back each time it leaves the band.

**Feedback "measured"** cures the oscillation. The model is asked in every frame of the gap, whether (1) passes or
not, and its place is a measured position with the variance v of its cycles, R = v T / 10 (5), since the errors of a
model last about a tenth of a cycle of T frames and are not new in each. The gain weighs it against the prediction;
velocity and acceleration follow from the filter and no differences are taken. At the edge of the gap the predictor is
sure and has its way, later the model.

**Feedback "none"** leaves the predictor alone; it "will continue to predict along the erroneous path", and is
corrected each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from ....data import KinemarkError
from ....data.array_types import Bools, Floats
from ....data.method import ONE, parameter
from ....signal.kalman import KalmanState, initial_state, predict, update, update_position
from ....signal.model_places import ModelPlaces
from ....signal.smoother import measurement_sd_of, process_sd_of
from ...marker_array import Gap, MarkerArray, Prediction
from ..kalman_predictor import STRIDE
from ..stage import FILL, FillMethod
from .limb_angles import LimbAngles, fit_model
from .place import Placer

LEAST = 1e-4
"""Variance of a place at least, mm²; chosen (see studies/missing_markers.py)."""

Feedback = Literal["position", "path", "measured", "none"]


@dataclass(frozen=True, slots=True)
class KalmanAngles(FillMethod):
    """Kalman prediction that a model of limb angles over the cycle corrects."""

    together: ClassVar[bool] = True
    automatic: ClassVar[bool] = False  # limb_angles does all that the thesis' own algorithm does, and better

    feedback: Feedback = parameter(
        "position", meaning="how a correction enters the predictor, see the module; position is the thesis'"
    )
    phase_tolerance: float = parameter(
        0.05, unit="cycles", low=0, below=0.5,
        meaning="of (1): an angle passes that the model has within this of the present phase",
    )  # fmt: skip
    segment_tolerance: float | None = parameter(
        None, unit=ONE, above=0,
        meaning="share by which a segment may be longer or shorter than it is before it fails; None: only angles "
        "are checked, as in the thesis, so that a marker that strays along its segment is not noticed",
    )  # fmt: skip
    measurement_sd: float | None = parameter(
        None, unit="mm", above=0,
        meaning="standard deviation of a measured coordinate; None: found (the thesis' sensors have 2.54)",
    )  # fmt: skip
    jerk: float | None = parameter(
        None, unit="mm/s³", above=0,
        meaning="process noise of the predictor; None: found, the mean of all markers",
    )  # fmt: skip
    margin: float = parameter(1.0, unit="s", above=0, meaning="how much of the samples before the gap is used")
    limbs: LimbAngles = parameter(factory=LimbAngles, meaning="the model and how it is made; its edges play no part")


class PredictedPath(NamedTuple):
    """Markers as the predictor and the model have them: xyz (M, F, 3) mm, NaN where the predictor has not begun;
    variance (M, F) mm² of a coordinate; corrected (M, F) whether the model put the marker there."""

    xyz: Floats
    variance: Floats
    corrected: Bools


@FILL.method("kalman_angles", KalmanAngles, rank=9, source="Swamidas 1997, 3.5.2")
def fill_kalman_angles(
    motion: MarkerArray, gaps: Sequence[Gap], *, method: KalmanAngles = KalmanAngles()
) -> list[Prediction]:
    """What predictor and model say of each gap; where there is no model, or nothing before the gap, the reason."""
    if not gaps:
        return []
    try:
        placer = fit_model(motion, method=method.limbs)
    except KinemarkError as error:
        return [Prediction.none(gap.length, str(error)) for gap in gaps]
    found = follow(motion, placer, _near(motion, gaps, method), method)
    return [_prediction(found, gap) for gap in gaps]


def _prediction(found: PredictedPath, gap: Gap) -> Prediction:
    xyz = found.xyz[gap.marker, gap.start : gap.stop]
    if np.isnan(xyz).any():
        return Prediction.none(
            gap.length, "no three samples in a row shortly before the gap for the predictor to begin"
        )
    return Prediction(xyz, found.variance[gap.marker, gap.start : gap.stop, None, None] * np.eye(3))


def _near(motion: MarkerArray, gaps: Sequence[Gap], method: KalmanAngles) -> Bools:
    """(F) frames in gaps and shortly before."""
    use = np.zeros(motion.xyz.shape[1], bool)
    for gap in gaps:
        use[max(gap.start - max(round(method.margin * motion.rate), 3), 0) : gap.stop] = True
    return use


def follow(motion: MarkerArray, placer: Placer, frames: Bools, method: KalmanAngles) -> PredictedPath:
    """Predict, check, correct and feed back in the `frames` (F) wanted; where they have a hole, all begins anew."""
    run = _Run(motion, placer, method)
    for f in np.flatnonzero(frames):
        if f == 0 or not frames[f - 1]:
            run.begin()
        run.step(int(f))
    return PredictedPath(run.xyz, run.variance, run.corrected)


def _noise(motion: MarkerArray, method: KalmanAngles) -> tuple[float, float]:
    """σ and U, given or found, one for all markers."""
    y = motion.xyz.transpose(0, 2, 1).reshape(-1, motion.xyz.shape[1])
    noise = measurement_sd_of(y)
    sd = float(np.sqrt((noise**2).mean())) if method.measurement_sd is None else method.measurement_sd
    if method.jerk is not None:
        return sd, method.jerk / motion.rate**3
    return sd, float(np.sqrt((process_sd_of(y, max(round(STRIDE * motion.rate), 1), noise) ** 2).mean()))


class _Run:
    """The state of all markers in one frame, and what was found in those before."""

    def __init__(self, motion: MarkerArray, placer: Placer, method: KalmanAngles) -> None:
        n, n_frames, _ = motion.xyz.shape
        self._seen, self._method = motion.xyz, method
        self._sd, self._process_sd = _noise(motion, method)
        self._lasting = max(placer.cycle / 10, 1.0)
        self._phase = placer.phase.cycles
        self._places = ModelPlaces(
            placer.model, phase_tolerance=method.phase_tolerance, segment_tolerance=method.segment_tolerance
        )
        self.xyz, self.variance = np.full((n, n_frames, 3), np.nan), np.full((n, n_frames), np.nan)
        self.corrected = np.zeros((n, n_frames), bool)
        self.begin()

    def begin(self) -> None:
        """Nothing is known."""
        n = len(self._seen)
        self._state = KalmanState(np.zeros((n, 3, 3)), np.zeros((n, 3, 3)))
        self._next = self._state
        self._going, self._row = np.zeros(n, bool), np.zeros(n, np.int64)

    def step(self, f: int) -> None:
        """One frame."""
        seen = ~np.isnan(self._seen[:, f, 0])
        at = np.where(self._going[:, None], self._state.x[:, 0], np.nan)
        at[seen] = self._seen[seen, f]
        self.variance[:, f] = np.where(seen, self._sd**2, np.where(self._going, self._state.P[:, 0, 0], np.nan))
        self.xyz[:, f] = at
        wrong = self._going & ~seen
        if wrong.any():
            if self._method.feedback != "measured":
                wrong &= self._places.wrong(at, self._phase[f])
            placed, variance = self._places.place(at, seen, self._phase[f])
            wrong &= ~np.isnan(placed[:, 0])
            if self._method.feedback == "measured":
                placed, variance = self._weighed(placed, variance * self._lasting, wrong)
            self.xyz[wrong, f], self.variance[wrong, f] = placed[wrong], variance[wrong]
            self.corrected[wrong, f] = True
        self._advance(f, seen, wrong)

    def _weighed(self, placed: Floats, variance: Floats, wrong: Bools) -> tuple[Floats, Floats]:
        """(5): places (M, 3) and variances (M) of the markers `wrong`, whose state becomes that of the frame's end."""
        placed, variance = placed.copy(), variance.copy()
        state = KalmanState(self._state.x[wrong], self._state.P[wrong])
        prior, R = state.P[:, 0, 0].copy(), np.maximum(variance[wrong], LEAST)
        placed[wrong], self._next = update_position(state, placed[wrong], R, self._process_sd)
        variance[wrong] = prior * R / (prior + R)
        return placed, variance

    def _advance(self, f: int, seen: Bools, wrong: Bools) -> None:
        """The predictor one frame on."""
        self._row = np.where(seen, np.minimum(self._row + 1, 3), 0)
        past = self.xyz[:, [f, max(f - 1, 0), max(f - 2, 0)]].copy()
        fed = wrong if self._method.feedback in ("position", "path") else np.zeros_like(wrong)
        if self._method.feedback == "path":
            for back in (1, 2):
                if f >= back and fed.any():
                    before, _ = self._places.place(self.xyz[:, f - back], seen, self._phase[f - back])
                    past[fed, back] = before[fed]  # (4)
        fed = fed & ~np.isnan(past).any((1, 2))
        begins = ~self._going & (self._row == 3)
        on = self._going & (seen | fed)
        old = self._state
        new = predict(old, self._process_sd)
        if begins.any():
            new.x[begins], new.P[begins] = initial_state(past[begins], self._sd, self._process_sd)
        if on.any():
            whole = ((self._row == 3) | fed)[on]  # (3)
            state = KalmanState(old.x[on], old.P[on])
            new.x[on], new.P[on] = update(state, np.nan_to_num(past[on]), whole, self._sd, self._process_sd)
        if self._method.feedback == "measured" and wrong.any():
            new.x[wrong], new.P[wrong] = self._next
        self._state, self._going = new, self._going | begins
