"""Gait with right centres of inertia, smoothed markers and only contacts that are whole: the method `physical`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from ..data import Trial
from ..data.array_types import Floats
from ..data.method import Method, parameter
from ..data.subject_measures import SubjectMeasures
from ..kinematics import Butterworth, WoltringSpline, smooth
from .gait_trial import GaitTrial, Mechanics, gait_of, inputs_of, marker_points
from .inverse_dynamics import five_point
from .lower_limb import MODEL_MARKERS
from .segment_inertia import INERTIAS
from .stage import GAIT
from .upper_body import UPPER_BODY_MARKERS


@dataclass(frozen=True, slots=True)
class Physical(Method):
    """The conventional gait model with mechanics as they are, and with what limits a result left out of it."""

    hip_centre: Literal["davis", "harrington", "hara"] = parameter(
        "davis", meaning="regression of the hip joint centre"
    )
    inertia: Literal["winter", "de_leva_male", "de_leva_female", "plug_in_gait"] = parameter(
        "winter", meaning="masses, centres and inertias of segments"
    )
    smoothing: Literal["none", "butterworth", "woltring"] = parameter(
        "butterworth", meaning="of the markers before derivatives are taken"
    )
    cutoff_hz: float | None = parameter(
        None, unit="Hz", above=0, meaning="of the smoothing; None: by residual analysis or cross-validation"
    )
    threshold_n: float = parameter(20.0, unit="N", above=0, meaning="vertical force of a loaded plate")

    @property
    def mechanics(self) -> Mechanics:
        """As chosen; contacts that the recording cuts still count."""
        return Mechanics(self.hip_centre, INERTIAS[self.inertia], five_point, ("", "cut"))

    def markers(self, trial: Trial) -> dict[str, Floats]:
        """(F, 3) mm by name, smoothed."""
        return marker_points(smoothed_trial(trial, self))


@GAIT.method("physical", Physical)
def physical_gait(trial: Trial, measures: SubjectMeasures, *, method: Physical) -> GaitTrial:
    """See `analyse_gait`."""
    given = inputs_of(trial, method.markers(trial), measures, threshold_n=method.threshold_n)
    return gait_of(given, method.mechanics)


def smoothed_trial(trial: Trial, method: Physical) -> Trial:
    """The trial with the model's markers, smoothed."""
    if method.smoothing == "none":
        return trial
    make = Butterworth if method.smoothing == "butterworth" else WoltringSpline
    markers = trial.trajectories.select(
        [n for n in trial.trajectories.names if n.rsplit(":", 1)[-1] in MODEL_MARKERS + UPPER_BODY_MARKERS]
    )
    return replace(trial, trajectories=smooth(markers, method=make(cutoff_hz=method.cutoff_hz)))
