"""How gait is computed: by `kinemark gait`, and by `[gait]` of a session."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...data.array_types import Floats
from ...gait.gait_methods import Physical, PlugInGait
from ...gait.standard_trial import Up
from ...gait.static_axes import AxesShown, axes_shown
from ...gait.uncertainty import GaitErrors


@dataclass(frozen=True, slots=True)
class GaitSettings:
    """How gait is computed.

    Attributes:
        method: "physical", or "plug_in_gait", which is that program's numbers.
        hip_centre: regression of the hip, where the method is physical.
        inertia: of the segments, likewise.
        smoothing: of the markers, likewise.
        cutoff_hz: of the smoothing; by residual analysis or cross-validation where none is given.
        force_cutoff_hz: of a low-pass filter of the plates, likewise; none where none is given.
        flat_foot: in the standing trial heel and toe are at one height.
        axes: knee alignment devices and markers inside of knees and ankles, where the standing trial wears them, show
            the joints' axes; markers inside not where the method is plug_in_gait, which does not look at them.
        placement_mm: standard uncertainty of where a marker is put on, along each axis.
        hip_mm: standard uncertainty of the hip joint centre, along each axis.
        tissue_mm: of thigh's and shank's markers, by skin that moves over bone, likewise.
        plate_mm: of where force plates lie among the markers, along each horizontal axis.
        uncertainty: whether to compute the error bars.
        emg_to: what 100 % of an EMG envelope are, where no trial of greatest contractions is given: "trial", its
            greatest value of each walk, or "strides", the mean of the strides' greatest values, over all walks.
        up: the axis of the laboratory that goes up; as the markers show where "auto".
        subject: whose gait it is, where files have the markers of several, as A of A:LASI.
    """

    method: Literal["physical", "plug_in_gait"] = "physical"
    hip_centre: Literal["davis", "harrington", "hara"] = "davis"
    inertia: Literal["winter", "de_leva_male", "de_leva_female", "plug_in_gait"] = "winter"
    smoothing: Literal["none", "butterworth", "woltring"] = "butterworth"
    cutoff_hz: float | None = None
    force_cutoff_hz: float | None = None
    flat_foot: bool = True
    axes: bool = True
    placement_mm: float = 5.0
    hip_mm: float = 10.0
    tissue_mm: float = 5.0
    plate_mm: float = 3.0
    uncertainty: bool = True
    emg_to: Literal["trial", "strides"] = "trial"
    up: Up = "auto"
    subject: str = ""

    @property
    def made(self) -> Physical | PlugInGait:
        """The method with its parameters."""
        if self.method == "plug_in_gait":
            return PlugInGait()
        return Physical(
            hip_centre=self.hip_centre, inertia=self.inertia, smoothing=self.smoothing, cutoff_hz=self.cutoff_hz,
            force_cutoff_hz=self.force_cutoff_hz,
        )  # fmt: skip

    def axes_from(self, static: Mapping[str, Floats] | None) -> AxesShown:
        """By what of a standing trial, (F, 3) mm by the model's names, the axes are taken; "" where by nothing."""
        shown = "" if static is None or not self.axes else axes_shown(static)
        return "" if shown == "markers" and self.method == "plug_in_gait" else shown

    def errors(self, *, width_mm: float) -> GaitErrors:
        """Of the causes, with that of the widths of knee and ankle."""
        return GaitErrors(
            placement_mm=self.placement_mm, hip_mm=self.hip_mm, tissue_mm=self.tissue_mm, plate_mm=self.plate_mm,
            width_mm=width_mm,
        )  # fmt: skip
