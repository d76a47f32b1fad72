"""Gait with right centres of inertia, smoothed markers and only contacts that are whole: the method `physical`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from ..data import Trial
from ..data.method import Method, parameter
from ..data.subject_measures import SIDES, SubjectMeasures
from ..kinematics import Butterworth, WoltringSpline, smooth
from .gait_trial import GaitTrial, ground_contact, leg_loads, marker_points, signals_of
from .inverse_dynamics import five_point
from .lower_limb import MODEL_MARKERS, lower_limbs
from .plate_contacts import contacts
from .reaction import reaction
from .segment_inertia import INERTIAS
from .segments import Z_UP
from .stage import GAIT


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


@GAIT.method("physical", Physical)
def physical_gait(trial: Trial, measures: SubjectMeasures, *, method: Physical) -> GaitTrial:
    """See `analyse_gait`."""
    rate, n = trial.trajectories.rate, trial.trajectories.n_frames
    smoothed = smoothed_trial(trial, method)
    points = marker_points(smoothed)
    limbs = lower_limbs(points, measures, hip_centre=method.hip_centre)
    plates = tuple(
        reaction(plate, trial.analog, n_frames=n, rate=rate, threshold_n=method.threshold_n) for plate in trial.plates
    )
    stood = contacts(plates, points, rate=rate)
    loads = leg_loads(
        limbs, plates, stood, points, measures, rate=rate, counts=("", "cut"), inertia=INERTIAS[method.inertia],
        rotation_derivative=five_point, up=Z_UP,
    )  # fmt: skip
    on = {side: ground_contact(side, plates, stood, ("", "cut")) for side in SIDES}
    return GaitTrial(limbs, plates, stood, loads, signals_of(limbs, loads, on, measures.mass_kg, rate=rate, up=Z_UP))


def smoothed_trial(trial: Trial, method: Physical) -> Trial:
    """The trial with the model's markers, smoothed."""
    if method.smoothing == "none":
        return trial
    make = Butterworth if method.smoothing == "butterworth" else WoltringSpline
    markers = trial.trajectories.select([n for n in trial.trajectories.names if n.rsplit(":", 1)[-1] in MODEL_MARKERS])
    return replace(trial, trajectories=smooth(markers, method=make(cutoff_hz=method.cutoff_hz)))
