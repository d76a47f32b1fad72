"""Gait as Plug-in Gait computes it, number by number: the method `plug_in_gait`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from ..data import KinemarkError, Trial
from ..data.array_types import Floats
from ..data.method import Method, parameter
from ..data.subject_measures import SubjectMeasures
from .clusters import CalibratedBody
from .gait_trial import GaitTrial, Mechanics, gait_of, inputs_of, marker_points
from .inverse_dynamics import five_point_slope, spline_acceleration
from .reaction import THRESHOLD_N
from .segment_inertia import PLUG_IN_GAIT
from .stage import GAIT

STILL_COUNT = ("", "beside", "cut")
"""Why contacts do not count, which Plug-in Gait does not look at."""


@dataclass(frozen=True, slots=True)
class PlugInGait(Method):
    """The conventional gait model with Plug-in Gait's own numbers; nothing is filtered."""

    threshold_n: float = parameter(THRESHOLD_N, unit="N", above=0, meaning="vertical force of a loaded plate")

    @property
    def mechanics(self) -> Mechanics:
        """Plug-in Gait's own."""
        return Mechanics("davis", PLUG_IN_GAIT, five_point_slope, STILL_COUNT, spline_acceleration, along_way=False)

    def markers(
        self, trial: Trial, *, besides: Collection[str] = (), cutoffs: Sequence[float | None] = ()
    ) -> dict[str, Floats]:
        """(F, 3) mm by name, as they are."""
        return marker_points(trial)

    def cutoffs(self, trial: Trial, *, besides: Collection[str] = ()) -> tuple[float | None, ...]:
        """Nothing is filtered."""
        return ()

    def smoothed_otherwise(self, trial: Trial, *, besides: Collection[str] = ()) -> tuple[dict[str, Floats], ...]:
        """Nothing is filtered."""
        return ()


@GAIT.method("plug_in_gait", PlugInGait, source="Kadaba et al. 1990; Davis et al. 1991")
def gait_as_plug_in_gait(
    trial: Trial, measures: SubjectMeasures, *, method: PlugInGait, body: CalibratedBody | None = None
) -> GaitTrial:
    """See `analyse_gait`.

    Raises:
        KinemarkError: there are clusters.
    """
    if body is not None:
        raise KinemarkError("Plug-in Gait has no clusters. Use the method physical with them, or leave them out.")
    given = inputs_of(trial, method.markers(trial), measures, threshold_n=method.threshold_n)
    return gait_of(given, method.mechanics)
