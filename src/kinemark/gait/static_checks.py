"""Whether what a standing trial shows of the axes of knees and ankles can be true, and how its feet were taken before.

A marker on the wrong side, a bent device, a measure in other units and two ways that show different axes turn all that
follows, and look plausible there. Each is a number that should be small.

A file that Plug-in Gait has processed states the offsets of the feet that it found in the standing trial. They follow
from its markers in two ways, with the sole flat on the floor or as the foot stood, and are those of one of both.
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
from .static_axes import axes_shown, device_worn
from .static_trial import with_static_offsets

Contradiction = Literal["knee_width", "ankle_width", "device", "axes", "turn"]
WIDTH_MM = 20.0
"""Difference of a width between markers from the measured one, mm; chosen: four times a marker's placement."""
RODS_SHARE = 0.1
"""Difference of a device's sides, of their mean; chosen: they are made alike, and seen to a millimetre of 140."""
AXES_DEG = 15.0
"""Between the axes of device and markers, deg; chosen: three times what a marker's placement turns."""
STATED_DEG = 0.1
"""Between an offset of a foot that a file states and the same from its markers; chosen: 0.01 of eight subjects."""
TOLD_DEG = 0.5
"""Between both ways to take the feet, above which it is told; chosen: a tenth of what a marker's placement turns."""
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


class FeetTaken(NamedTuple):
    """How a file's program took the feet of a standing trial.

    Attributes:
        flat: with the sole flat on the floor, else as they stood. by_deg: greatest difference of both ways.
    """

    flat: bool
    by_deg: float


def feet_taken(stated: SubjectMeasures, static: Mapping[str, Floats]) -> FeetTaken | None:
    """How the feet were taken whose offsets a standing trial's file states; None where they are of neither way.

    Args:
        stated: of the file. static: (F, 3) mm by the model's names.
    """
    axes = axes_shown(static) == "devices"
    flat, stood = (_offsets(with_static_offsets(stated, static, flat_foot=one, axes=axes)) for one in (True, False))
    own, by_deg = _offsets(stated), float(np.abs(flat - stood).max())
    like = [bool((np.abs(one - own) < STATED_DEG).all()) for one in (flat, stood)]
    return FeetTaken(like[0], by_deg) if any(like) and by_deg > TOLD_DEG else None


def _offsets(measures: SubjectMeasures) -> Floats:
    """(4) deg; NaN where there is none."""
    legs = (measures.left, measures.right)
    return np.array([deg for leg in legs for deg in (leg.plantar_offset_deg, leg.rotation_offset_deg)], float)
