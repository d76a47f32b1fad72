"""Gait with right centres of inertia, smoothed markers and only contacts that are whole: the method `physical`."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Literal

from ..data import Trajectories, Trial
from ..data.array_types import Floats
from ..data.method import Method, parameter
from ..data.subject_measures import SubjectMeasures
from ..kinematics import Butterworth, WoltringSpline, smooth
from ..kinematics.smooth import residual_cutoff, smooth_butterworth
from .clusters import CalibratedBody
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

    def markers(self, trial: Trial, *, besides: Collection[str] = ()) -> dict[str, Floats]:
        """(F, 3) mm by name, smoothed; the model's, and those of clusters besides."""
        return marker_points(smoothed_trial(trial, self, besides=besides))

    def smoothed_again(self, trial: Trial, *, besides: Collection[str] = ()) -> dict[str, Floats] | None:
        """(F, 3) mm by name, filtered twice, each marker at the cut-off of the first time; None where no filter is.

        What a filter H takes of the motion s, (1 − H) s, is hardly noise any more when it is done again: H (1 − H) s.
        """
        if self.smoothing != "butterworth":
            return None
        once = smoothed_trial(trial, self, besides=besides)
        paths = []
        for raw, path in zip(_used(trial, besides), once.trajectories, strict=True):
            cutoff = self.cutoff_hz or residual_cutoff(raw, rate=trial.trajectories.rate)
            paths.append(smooth_butterworth(path, trial.trajectories.rate, method=Butterworth(cutoff_hz=cutoff)))
        return marker_points(replace(once, trajectories=replace(once.trajectories, paths=tuple(paths))))


@GAIT.method("physical", Physical)
def physical_gait(
    trial: Trial, measures: SubjectMeasures, *, method: Physical, body: CalibratedBody | None = None
) -> GaitTrial:
    """See `analyse_gait`."""
    points = method.markers(trial, besides=() if body is None else body.markers)
    given = inputs_of(trial, points, measures, threshold_n=method.threshold_n, body=body)
    return gait_of(given, method.mechanics)


def smoothed_trial(trial: Trial, method: Physical, *, besides: Collection[str] = ()) -> Trial:
    """The trial with the model's markers and those besides, smoothed."""
    if method.smoothing == "none":
        return trial
    make = Butterworth if method.smoothing == "butterworth" else WoltringSpline
    return replace(trial, trajectories=smooth(_used(trial, besides), method=make(cutoff_hz=method.cutoff_hz)))


def _used(trial: Trial, besides: Collection[str]) -> Trajectories:
    """The model's markers and those besides."""
    wanted = {*MODEL_MARKERS, *UPPER_BODY_MARKERS, *besides}
    return trial.trajectories.select([n for n in trial.trajectories.names if n.rsplit(":", 1)[-1] in wanted])
