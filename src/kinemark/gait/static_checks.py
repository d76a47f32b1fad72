"""Whether what a standing trial shows of the axes of knees and ankles can be true.

A marker on the wrong side, a bent device, a measure in other units and two ways that show different axes turn all that
follows, and look plausible there. Each is a number that should be small.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal, NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.model_markers import DEVICE
from ..data.subject_measures import LETTER, SIDES, Side, SubjectMeasures
from .estimated_measures import ACROSS
from .segments import mean_length, unit
from .static_axes import device_worn

Contradiction = Literal["knee_width", "ankle_width", "device", "axes", "turn"]
WIDTH_MM = 20.0
"""Difference of a width between markers from the measured one, mm; chosen: four times a marker's placement."""
RODS_SHARE = 0.1
"""Difference of a device's sides, of their mean; chosen: they are made alike, and seen to a millimetre of 140."""
AXES_DEG = 15.0
"""Between the axes of device and markers, deg; chosen: three times what a marker's placement turns."""
TURN_DEG = 45.0
"""Of a wand or a torsion; chosen: torsions of the shank beyond it are rare."""


class StaticDoubt(NamedTuple):
    """A number that should be small: of which side, of what, its value in mm, share or deg."""

    side: Side
    what: Contradiction
    value: float


def static_doubts(
    static: Mapping[str, Floats], stated: SubjectMeasures, shown: SubjectMeasures
) -> tuple[StaticDoubt, ...]:
    """What of a standing trial contradicts itself or the measures.

    Args:
        static: (F, 3) mm by the model's names, with the knees' markers. stated: measures without the trial's axes.
        shown: with them.
    """
    limits = {"knee_width": WIDTH_MM, "ankle_width": WIDTH_MM, "device": RODS_SHARE, "axes": AXES_DEG, "turn": TURN_DEG}
    found = [doubt for side in SIDES for doubt in _of_side(static, stated, shown, side)]
    return tuple(doubt for doubt in found if abs(doubt.value) > limits[doubt.what])


def _of_side(
    static: Mapping[str, Floats], stated: SubjectMeasures, shown: SubjectMeasures, side: Side
) -> Iterator[StaticDoubt]:
    letter, own, leg = LETTER[side], stated.leg(side), shown.leg(side)
    widths: tuple[tuple[Contradiction, str, str, float], ...] = (
        ("knee_width", *ACROSS["knee_mm"], own.knee_mm), ("ankle_width", *ACROSS["ankle_mm"], own.ankle_mm),
    )  # fmt: skip
    for what, outer, inner, width in widths:
        if {letter + outer, letter + inner} <= set(static):
            apart = mean_length(static[letter + outer] - static[letter + inner])
            yield StaticDoubt(side, what, apart - width - stated.marker_diameter_mm)
    if device_worn(static, letter):
        a, b, c = (static[letter + name] for name in DEVICE)
        sides = [mean_length(u - v) for u, v in ((a, b), (b, c), (c, a))]
        yield StaticDoubt(side, "device", float(np.ptp(sides) / np.mean(sides)))
        if letter + "KNM" in static:
            ways = unit(a - static[letter + "KNE"]), unit(static[letter + "KNE"] - static[letter + "KNM"])
            cosine = float(np.nanmean((ways[0] * ways[1]).sum(-1)))
            yield StaticDoubt(side, "axes", float(np.degrees(np.arccos(np.clip(cosine, -1, 1)))))
    yield StaticDoubt(side, "turn", max((leg.thigh_wand_deg, leg.shank_wand_deg, leg.torsion_deg), key=abs))
