"""GCD, gait cycle data: time-distance parameters and curves of 51 points, each below a line with its name.

    #!DST-0.1 GCD
    !LeftCadence
    111.2
    !LeftKneeFlexExt
    … 51 lines, 0 to 100 % of the stride

Angles in deg, moments in N·m/kg, powers in W/kg, lengths in m, times in s, shares in %. Only quantities all of which
are known are written, since the format has no missing value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ..data.gait_curves import GaitCurves
from .files import replacing

CURVES = {
    "PelvicTilt": ("PelvisAngles", 0), "PelvicObliquity": ("PelvisAngles", 1), "PelvicRotation": ("PelvisAngles", 2),
    "HipFlexExt": ("HipAngles", 0), "HipAbAdduct": ("HipAngles", 1), "HipRotation": ("HipAngles", 2),
    "KneeFlexExt": ("KneeAngles", 0), "KneeValgVar": ("KneeAngles", 1), "KneeRotation": ("KneeAngles", 2),
    "DorsiPlanFlex": ("AnkleAngles", 0), "FootRotation": ("AnkleAngles", 2),
    "FootProgression": ("FootProgressAngles", 1),
    "HipFlexExtMoment": ("HipMoment", 0), "HipAbAdductMoment": ("HipMoment", 1), "HipRotationMoment": ("HipMoment", 2),
    "KneeFlexExtMoment": ("KneeMoment", 0), "KneeValgVarMoment": ("KneeMoment", 1),
    "KneeRotationMoment": ("KneeMoment", 2), "DorsiPlanFlexMoment": ("AnkleMoment", 0),
    "HipPower": ("HipPower", 0), "KneePower": ("KneePower", 0), "AnklePower": ("AnklePower", 0),
}  # fmt: skip
"""Of the format: quantity and component."""
PARAMETERS = {
    "StrideTime": ("stride_time", 1.0), "Cadence": ("cadence", 1.0), "StepTime": ("step_time", 1.0),
    "OppositeFootOff": ("opposite_foot_off", 1.0), "OppositeFootContact": ("opposite_foot_strike", 1.0),
    "FootOff": ("foot_off", 1.0), "SingleSupport": ("single_support", 1.0), "DoubleSupport": ("double_support", 1.0),
    "StrideLength": ("stride_length", 0.001), "StepLength": ("step_length", 0.001), "Speed": ("speed", 0.001),
}  # fmt: skip
"""Of the format: parameter, and the factor to its unit."""


def write_gcd(path: Path | str, curves: Sequence[GaitCurves], parameters: Mapping[str, Mapping[str, float]]) -> None:
    """Write mean curves and mean parameters, by side ("left", "right") and name.

    Raises:
        KinemarkError: the file cannot be written.
    """
    by_name = {one.name: one for one in curves}
    lines = ["#!DST-0.1 GCD"]
    for side in ("left", "right"):
        lines += _lines(side, by_name, parameters[side])
    with replacing(path) as beside:
        beside.write_text("\n".join(lines) + "\n", encoding="ascii")


def _lines(side: str, curves: Mapping[str, GaitCurves], parameters: Mapping[str, float]) -> Iterator[str]:
    for title, (name, factor) in PARAMETERS.items():
        if np.isfinite(value := parameters.get(name, np.nan)):
            yield from (f"!{side.title()}{title}", f"{value * factor:.6g}")
    for title, (name, axis) in CURVES.items():
        one = curves.get(side[0].upper() + name)
        if one is not None and np.isfinite(mean := one.mean[::2, axis]).all():
            yield from (f"!{side.title()}{title}", *(f"{value:.6g}" for value in mean))
