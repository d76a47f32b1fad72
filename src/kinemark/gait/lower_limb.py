"""The conventional gait model: pelvis, thighs, shanks and feet from 15 or 16 markers.

Of KISS, Helen Hayes and Plug-in Gait (Kadaba et al. 1990; Davis et al. 1991). Segments have x forward, y to the left
and z up:

    pelvis   y from RASI to LASI; x from SACR (or the midpoint of the PSIs) to the midpoint of the ASIs, which is the
             origin, without its part along y                                                                    (1)
    thigh    z from knee to hip, y outwards through KNE on the left, inwards on the right                        (2)
    shank    z from ankle to knee, y through ANK likewise; the knee's end of it is turned back by the torsion      (3)
    foot     z from TOE to ankle, y of the shank; turned by Rᵧ(−plantar offset) Rₓ(∓rotation offset)             (4)

Hips lie in the pelvis by regression (`hip_centre`) or where a motion has shown them (`functional_hip`), knees and
ankles by the chord (`segments`). The offsets of (4) are those of the line from HEE to TOE in a static trial, which is
level with a flat foot.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.model_markers import LEG_MARKERS
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, Side, SubjectMeasures
from ..kinematics import turned
from .hip_centre import davis, hara, harrington
from .segments import Segment, joint_centre, mean_length, perpendicular, unit, upright

FOOT_SEQUENCE = "yxz"
"""Of (4) and of all angles of the model; conventional."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One leg over frames (…).

    Attributes:
        hip: (…, 3) mm; knee and ankle are the origins of thigh and shank.
        thigh, shank: with the axis of the knee and of the ankle as y; shank_at_knee: turned back by the torsion.
        foot: with the offsets (4); bare_foot: without.
    """

    hip: Floats
    thigh: Segment
    shank: Segment
    shank_at_knee: Segment
    foot: Segment
    bare_foot: Segment

    @property
    def knee(self) -> Floats:
        """(…, 3) mm."""
        return self.thigh.origin

    @property
    def ankle(self) -> Floats:
        """(…, 3) mm."""
        return self.shank.origin


@dataclass(frozen=True, slots=True, eq=False)
class LowerLimbs:
    """Pelvis and legs over frames (…)."""

    pelvis: Segment
    left: Leg
    right: Leg

    def leg(self, side: Side) -> Leg:
        """Of one side."""
        return self.left if side == "left" else self.right


def lower_limbs(
    points: Mapping[str, Floats],
    measures: SubjectMeasures,
    *,
    hip_centre: str = "davis",
    carried: Mapping[str, Segment] | None = None,
) -> LowerLimbs:
    """Segments (1) to (4) in every frame; NaN where a marker is missing.

    Args:
        points: (…, 3) mm by name: LASI, RASI, SACR or LPSI and RPSI, and L and R of `LEG_MARKERS`.
        measures: of the subject; feet whose offsets are None are left as the line from TOE to ankle.
        hip_centre: the regression.
        carried: segments that clusters show instead, by "left thigh", "right shank", "left foot" (without offsets), ….

    Raises:
        KinemarkError: a marker is not there.
    """
    check_markers(points)
    hips = hips_of(points, measures, hip_centre=hip_centre)
    left, right = (_leg(points, hips[side], measures, side, carried or {}) for side in SIDES)
    return LowerLimbs(pelvis_of(points)[0], left, right)


def absent_markers(points: Collection[str]) -> list[str]:
    """The model's markers that are not among these; the sacrum with what may stand for it, in words."""
    wanted = ["LASI", "RASI", *(LETTER[side] + name for side in SIDES for name in LEG_MARKERS)]
    absent = [name for name in wanted if name not in points]
    if not ("SACR" in points or {"LPSI", "RPSI"} <= set(points)):
        absent.append("SACR (or LPSI and RPSI)")
    return absent


def never_seen(points: Mapping[str, Floats]) -> tuple[str, ...]:
    """Markers of the legs and of the front of the pelvis that no frame shows, (F, 3) mm by the model's names; none of
    a leg without any, which is another matter."""
    wanted = ["LASI", "RASI", *(LETTER[s] + name for s in SIDES if leg_seen(points, s) for name in LEG_MARKERS)]
    return tuple(name for name in wanted if name in points and not np.isfinite(points[name]).any())


def leg_seen(points: Mapping[str, Floats], side: Side) -> bool:
    """Whether any frame shows a marker of a leg, (F, 3) mm by the model's names."""
    return any(np.isfinite(points[LETTER[side] + name]).any() for name in LEG_MARKERS if LETTER[side] + name in points)


def check_markers(points: Mapping[str, Floats]) -> None:
    """Whether all markers are there.

    Raises:
        KinemarkError: one is not.
    """
    absent = absent_markers(points)
    if absent:
        raise KinemarkError(
            f"The gait model wants the markers {', '.join(absent)}, which are not in the trial; there are "
            f"{', '.join(list(points)[:40]) or 'none'}. Label the trial first, or say how it "
            f"calls them: --marker {absent[0][:4]}=NAME, in a session under [gait.markers]."
            f"{_instead(absent)}"
        )


def _instead(absent: list[str]) -> str:
    """What a laboratory without the model's wands can do."""
    of = {"LTHI": "left thigh", "LTIB": "left shank", "RTHI": "right thigh", "RTIB": "right shank"}
    wands = [of[name] for name in absent if name in of]
    if not wands:
        return ""
    return (
        f" Three or more markers on the same segment stand for a wand, with a standing trial: --cluster "
        f'"{wands[0]}=A,B,C"' + (f", and likewise for the {' and the '.join(wands[1:])}." if wands[1:] else ".")
    )


def pelvis_of(points: Mapping[str, Floats]) -> tuple[Segment, Floats]:
    """The pelvis (1), and the (…, 3) mm point at its back."""
    left, right = points["LASI"], points["RASI"]
    back = _back(points)
    centre = (left + right) / 2
    y = unit(left - right)
    x = perpendicular(centre - back, y)
    return Segment(np.stack([x, y, np.cross(x, y)], -1), centre), back


def _back(points: Mapping[str, Floats]) -> Floats:
    """SACR, or the midpoint of the PSIs where SACR is never seen."""
    sacrum = points.get("SACR")
    if sacrum is not None and np.isfinite(sacrum).any():
        return sacrum
    if not {"LPSI", "RPSI"} <= set(points):
        raise KinemarkError("SACR is never seen in this trial, and there are no LPSI and RPSI in its place.")
    return (points["LPSI"] + points["RPSI"]) / 2


def _leg(
    points: Mapping[str, Floats], hip: Floats, measures: SubjectMeasures, side: Side, carried: Mapping[str, Segment]
) -> Leg:
    own, left, r = measures.leg(side), TO_THE_LEFT[side], measures.marker_diameter_mm / 2
    thi, kne, tib, ank, _, toe = (points[LETTER[side] + name] for name in LEG_MARKERS)
    knee = joint_centre(hip, kne, thi, half_width_mm=own.knee_mm / 2 + r, wand_deg=own.thigh_wand_deg, outwards=left)
    thigh = carried.get(f"{side} thigh") or upright(knee, hip - knee, left * (kne - knee))  # (2)
    knee = thigh.origin
    ankle = joint_centre(knee, ank, tib, half_width_mm=own.ankle_mm / 2 + r, wand_deg=own.shank_wand_deg, outwards=left)
    shank = carried.get(f"{side} shank") or upright(ankle, knee - ankle, left * (ank - ankle))  # (3)
    bare = carried.get(f"{side} foot") or upright(toe, shank.origin - toe, shank.R[..., 1])  # (4)
    offsets = (own.plantar_offset_deg or 0.0, own.rotation_offset_deg or 0.0)
    foot = Segment(bare.R @ foot_offsets(*offsets, side), bare.origin)
    return Leg(hip, thigh, shank, shank.turned_about_z(-left * own.torsion_deg), foot, bare)


def hips_of(
    points: Mapping[str, Floats], measures: SubjectMeasures, *, hip_centre: str = "davis"
) -> dict[Side, Floats]:
    """(…, 3) mm of both hips.

    Args:
        points: (…, 3) mm by name, of the pelvis. measures: of the subject. hip_centre: the regression.
    """
    pelvis, back = pelvis_of(points)
    asis = measures.asis_mm or mean_length(points["LASI"] - points["RASI"])
    depth = mean_length(pelvis.origin - back)
    return {side: pelvis.at(_hip(measures, side, hip_centre, asis, depth)) for side in SIDES}


def _hip(measures: SubjectMeasures, side: Side, how: str, asis: float, depth: float) -> Floats:
    """(3) mm in the pelvis: as known, else by regression."""
    own = measures.leg(side)
    if own.hip_mm is not None:
        return np.array(own.hip_mm) + own.hip_shift_mm
    local = {
        "davis": lambda: davis(measures, side, asis),
        "harrington": lambda: harrington(measures, side, asis, depth),
        "hara": lambda: hara(measures, side),
    }[how]()
    return np.asarray(local + np.array(own.hip_shift_mm))


def foot_offsets(plantar_deg: float, rotation_deg: float, side: Side) -> Floats:
    """(3, 3) of (4)."""
    return turned(np.array([-plantar_deg, -TO_THE_LEFT[side] * rotation_deg, 0.0]), FOOT_SEQUENCE)
