"""The methods of gait analysis.

`physical` has right centres of inertia, smoothed markers and only contacts that are whole; `plug_in_gait` computes as
that program does, number by number.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ..data import KinemarkError, Trajectories, Trial
from ..data.array_types import Floats
from ..data.method import Method, parameter
from ..data.model_markers import MODEL_MARKERS, UPPER_BODY_MARKERS
from ..data.subject_measures import SubjectMeasures
from ..kinematics import Butterworth, WoltringSpline, smooth
from ..kinematics.smooth import residual_cutoff, smooth_butterworth
from ..signal.filters import HIGHEST
from .clusters import CalibratedBody
from .gait_trial import GAIT, GaitTrial, Inputs, Mechanics, gait_of, inputs_of, marker_points
from .inverse_dynamics import five_point, five_point_slope, spline_acceleration
from .reaction import THRESHOLD_N
from .segment_inertia import INERTIAS, PLUG_IN_GAIT

Points = Mapping[str, Floats]
"""(F, 3) mm by name."""
Cutoffs = Sequence[float | None]
"""Hz of markers."""
WIDER = 2**0.5
"""By which another cut-off is higher; chosen: errors of moments of the swing are then about what is stated."""


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
    force_cutoff_hz: float | None = parameter(
        None, unit="Hz", above=0, meaning="of a low-pass filter of the plates' forces and moments; None: no filter"
    )

    @property
    def mechanics(self) -> Mechanics:
        """As chosen; contacts that the recording cuts still count."""
        return Mechanics(self.hip_centre, INERTIAS[self.inertia], five_point, ("", "cut", "shared"))

    def inputs(
        self, trial: Trial, points: Points, measures: SubjectMeasures, *, body: CalibratedBody | None = None
    ) -> Inputs:
        """With plates that are less what they show without a load, filtered where that is asked for."""
        return inputs_of(
            trial, points, measures, threshold_n=self.threshold_n, zeroed=True, force_cutoff_hz=self.force_cutoff_hz,
            body=body,
        )  # fmt: skip

    def markers(self, trial: Trial, *, besides: Collection[str] = (), cutoffs: Cutoffs = ()) -> dict[str, Floats]:
        """(F, 3) mm by name, smoothed; the model's, and those of clusters besides; low-passed at `cutoffs` if given."""
        if not cutoffs:
            return marker_points(smoothed_trial(trial, self, besides=besides))
        return marker_points(replace(trial, trajectories=_filtered(_used(trial, besides), cutoffs)))

    def cutoffs(self, trial: Trial, *, besides: Collection[str] = ()) -> Cutoffs:
        """Hz of each of `markers`, None of one that is too short; nothing where no filter is."""
        used = _used(trial, besides) if self.smoothing == "butterworth" else ()
        return tuple(self.cutoff_hz or residual_cutoff(path, rate=trial.trajectories.rate) for path in used)

    def smoothed_otherwise(self, trial: Trial, *, besides: Collection[str] = ()) -> tuple[dict[str, Floats], ...]:
        """(F, 3) mm by name, filtered twice, and once at a cut-off that is `WIDER` times as high, each marker from its
        own; nothing where no filter is.

        What a filter H takes of the motion s, (1 − H) s, is hardly noise any more when it is done again: H (1 − H) s.
        """
        if self.smoothing != "butterworth":
            return ()
        used, rate = _used(trial, besides), trial.trajectories.rate
        cutoffs = self.cutoffs(trial, besides=besides)
        once = _filtered(used, cutoffs)
        wider = [hz and min(WIDER * hz, HIGHEST * rate) for hz in cutoffs]
        others = (_filtered(once, cutoffs), _filtered(used, wider))
        return tuple(marker_points(replace(trial, trajectories=one)) for one in others)


@GAIT.method("physical", Physical)
def physical_gait(
    trial: Trial, measures: SubjectMeasures, *, method: Physical, body: CalibratedBody | None = None
) -> GaitTrial:
    """See `analyse_gait`."""
    points = method.markers(trial, besides=() if body is None else body.markers)
    return gait_of(method.inputs(trial, points, measures, body=body), method.mechanics)


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


def _filtered(markers: Trajectories, cutoffs: Cutoffs) -> Trajectories:
    """Each marker at a cut-off of its own, Hz; as it is where there is none."""
    paths = [
        path if hz is None else smooth_butterworth(path, markers.rate, method=Butterworth(cutoff_hz=hz))
        for path, hz in zip(markers, cutoffs, strict=True)
    ]
    return replace(markers, paths=tuple(paths))


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

    def inputs(self, trial: Trial, points: Points, measures: SubjectMeasures) -> Inputs:
        """With plates as they were recorded."""
        return inputs_of(trial, points, measures, threshold_n=self.threshold_n)

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
    return gait_of(method.inputs(trial, method.markers(trial), measures), method.mechanics)
