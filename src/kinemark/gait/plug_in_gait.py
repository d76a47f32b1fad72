"""Gait as Plug-in Gait computes it, number by number: the method `plug_in_gait`."""

from __future__ import annotations

from dataclasses import dataclass

from ..data import Trial
from ..data.method import Method, parameter
from ..data.subject_measures import SIDES, SubjectMeasures
from .gait_trial import GaitTrial, ground_contact, leg_loads, marker_points, signals_of
from .inverse_dynamics import five_point_slope
from .lower_limb import lower_limbs
from .plate_contacts import contacts
from .reaction import THRESHOLD_N, reaction
from .segment_inertia import PLUG_IN_GAIT
from .segments import Z_UP
from .stage import GAIT

STILL_COUNT = ("", "beside", "cut")
"""Why contacts do not count, which Plug-in Gait does not look at."""


@dataclass(frozen=True, slots=True)
class PlugInGait(Method):
    """The conventional gait model with Plug-in Gait's own numbers; nothing is filtered."""

    threshold_n: float = parameter(THRESHOLD_N, unit="N", above=0, meaning="vertical force of a loaded plate")


@GAIT.method("plug_in_gait", PlugInGait, source="Kadaba et al. 1990; Davis et al. 1991")
def gait_as_plug_in_gait(trial: Trial, measures: SubjectMeasures, *, method: PlugInGait) -> GaitTrial:
    """See `analyse_gait`."""
    points, rate, n = marker_points(trial), trial.trajectories.rate, trial.trajectories.n_frames
    limbs = lower_limbs(points, measures)
    plates = tuple(
        reaction(plate, trial.analog, n_frames=n, rate=rate, threshold_n=method.threshold_n) for plate in trial.plates
    )
    stood = contacts(plates, points, rate=rate)
    loads = leg_loads(
        limbs, plates, stood, points, measures, rate=rate, counts=STILL_COUNT, inertia=PLUG_IN_GAIT,
        rotation_derivative=five_point_slope, up=Z_UP,
    )  # fmt: skip
    on = {side: ground_contact(side, plates, stood, STILL_COUNT) for side in SIDES}
    return GaitTrial(limbs, plates, stood, loads, signals_of(limbs, loads, on, measures.mass_kg, rate=rate, up=Z_UP))
