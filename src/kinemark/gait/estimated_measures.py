"""Measures of a subject that were not taken, estimated from the markers and plates of a trial.

leg     from the front of the pelvis to the ankle's marker, as long as it gets: its 85 % quantile              (1)
knee, ankle   as wide as their outer and inner markers are apart, less a marker; where there are no inner ones,
        a share of the leg                                                                                     (2)
mass    2 J / (g T), J the impulse of the vertical force of one contact, T the median stride: each foot carries the
        body for half of a stride, where feet carry alike                                                      (3)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LEAST_KG, LENGTHS_MM, LETTER, MOST_KG, SIDES, LegMeasures, Side, SubjectMeasures
from .inverse_dynamics import GRAVITY
from .lower_limb import leg_seen
from .plate_contacts import Contact
from .reaction import Reaction
from .segments import Z_UP, mean_length

STRAIGHT = 0.85
"""Quantile (1); measured on 36 legs of eight subjects, walking and standing: off by 14 mm (RMS), others by more."""
KNEE_SHARE, ANKLE_SHARE = 0.125, 0.08
"""(2), of the leg; measured on people: medians of eight subjects from 1.33 to 1.76 m whose files state both."""
WIDTH_SD_MM = 10.0
"""Standard uncertainty of (2), mm; measured on the same subjects, of the shares. Of markers 5 mm off each it is 7."""
ACROSS = {"knee_mm": ("KNE", "KNM"), "ankle_mm": ("ANK", "MED")}
"""Markers outside and inside of a joint, after L or R, by its width; conventional (CGM2)."""


def estimated_measures(
    points: Mapping[str, Floats], *, mass_kg: float | None = None, marker_diameter_mm: float = 14.0
) -> SubjectMeasures:
    """Legs by (1) and (2).

    Args:
        points: (F, 3) mm by the model's names, of a standing trial or a walk.
        mass_kg: of the body by the plates (3), where they show it.
        marker_diameter_mm: from the skin to the middle of a marker is half of it.

    Raises:
        KinemarkError: no frame has a pelvis and both ankles, or a leg or the mass is none of a person's.
    """
    if mass_kg is not None and not LEAST_KG <= mass_kg <= MOST_KG:
        raise KinemarkError(
            f"By the force plates the body weighs {mass_kg:.1f} kg, wanted {LEAST_KG:g} to {MOST_KG:g}. Check the unit "
            "of their channels, or state the subject's measures."
        )
    legs = [_leg(points, side, marker_diameter_mm) for side in SIDES if leg_seen(points, side)]
    if not legs:
        raise KinemarkError("No leg can be measured: no frame shows a marker of one. State the subject's measures.")
    left, right = legs[0], legs[-1]  # a leg without markers counts as the other
    return SubjectMeasures(left, right, mass_kg=mass_kg, marker_diameter_mm=marker_diameter_mm)


def joints_by_share(points: Mapping[str, Floats], *, marker_diameter_mm: float = 14.0) -> tuple[str, ...]:
    """Of "knees" and "ankles" those whose width `estimated_measures` has as a share of the leg, on a side at least.

    Args:
        points: (F, 3) mm by the model's names. marker_diameter_mm: as there.
    """
    shown = {name: [_width(points, side, name, marker_diameter_mm) for side in SIDES] for name in ACROSS}
    return tuple(joint for name, joint in (("knee_mm", "knees"), ("ankle_mm", "ankles")) if None in shown[name])


def mass_on_plates(
    reactions: Sequence[Reaction], contacts: Sequence[Contact], events: Sequence[FootEvent], *, rate: float,
) -> float | None:  # fmt: skip
    """kg by (3) over contacts of a whole foot; None where there are none, or no strides.

    The mean of both sides' medians, as who spares a leg loads the other one more; of one, where the other has none.

    Args:
        reactions: of the plates over F frames. contacts: on them. events: of the feet. rate: frames a second.
    """
    strides = [b.time - a.time for side in SIDES
               for a, b in pairwise(e for e in events if e.side == side and e.strike)]  # fmt: skip
    impulses: dict[str, list[float]] = {}
    for one in contacts:
        if one.side is not None and not one.reason:
            newton = _bridged(reactions[one.plate].force[one.first : one.stop] @ Z_UP)
            impulses.setdefault(one.side, []).append(abs(float(newton.sum())) / rate)
    if not strides or not impulses:
        return None
    impulse = np.mean([np.median(own) for own in impulses.values()])
    return float(impulse / (GRAVITY * np.median(strides) / 2))


def _bridged(newton: Floats) -> Floats:
    """(n) of a contact, unknown samples between the known ones beside them."""
    known = np.isfinite(newton)
    return np.interp(np.arange(len(newton)), np.flatnonzero(known), newton[known])


def check_legs(points: Mapping[str, Floats]) -> None:
    """A walk's legs by (1), whoever states the measures: the unit of length of a file may be wrong.

    Args:
        points: (F, 3) mm by the model's names; legs that no frame shows are not looked at.

    Raises:
        KinemarkError: a leg is none of a person's.
    """
    for side in SIDES:
        _length(points, side)


def _leg(points: Mapping[str, Floats], side: Side, marker_diameter_mm: float) -> LegMeasures:
    leg = _length(points, side)
    if leg is None:
        raise KinemarkError(
            f"The {side} leg cannot be measured: no frame shows the front of the pelvis and the ankle. State the "
            "subject's measures."
        )
    widths = [_width(points, side, name, marker_diameter_mm) for name in ACROSS]
    return LegMeasures(leg, widths[0] or KNEE_SHARE * leg, widths[1] or ANKLE_SHARE * leg)


def _length(points: Mapping[str, Floats], side: Side) -> float | None:
    """mm by (1); None where no frame shows it."""
    front, ankle = (points.get(LETTER[side] + name) for name in ("ASI", "ANK"))
    length = np.zeros(0) if front is None or ankle is None else np.linalg.norm(front - ankle, axis=-1)
    length = length[np.isfinite(length)]
    if not len(length):
        return None
    leg = float(np.quantile(length, STRAIGHT))
    low, high = LENGTHS_MM["leg_mm"]
    if not low <= leg <= high:
        raise KinemarkError(f"By its markers the {side} leg is {leg:.0f} mm long, wanted {low:g} to {high:g}. Check "
                            "the unit of length of the file, and which marker is which.")  # fmt: skip
    return leg


def _width(points: Mapping[str, Floats], side: Side, name: str, marker_diameter_mm: float) -> float | None:
    """mm by (2), of a joint that has a marker on either side; None where it has not, or none that a person can have."""
    outer, inner = (points.get(LETTER[side] + marker) for marker in ACROSS[name])
    if outer is None or inner is None:
        return None
    apart, (low, high) = mean_length(outer - inner) - marker_diameter_mm, LENGTHS_MM[name]
    return apart if low <= apart <= high else None
