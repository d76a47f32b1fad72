"""Head, trunk and arms of the conventional whole-body model, as Plug-in Gait has them.

With x forward, y to the left, z upwards, W the middle of the wrist's markers and r a marker's radius:

    thorax   z from (STRN + T10)/2 to (CLAV + C7)/2, x from (C7 + T10)/2 to (CLAV + STRN)/2; origin CLAV − r x    (1)
    head     x from the back to the front pair, y from the right to the left pair; turned by the head's offset    (2)
    shoulder chord of SHO below the thorax's origin, in the plane square to x of the thorax                          (3)
    elbow    chord of ELB, in the plane square to (shoulder − ELB) × (W − ELB)                                       (4)
    wrist    W ∓ half the wrist's width and r along (WRB − WRA) × (elbow − W)                                        (5)
    hand     chord of FIN below the wrist, in the plane with W                                                       (6)

    upper arm z elbow → shoulder, x wrist → elbow;   forearm z wrist → elbow, y of the upper arm;
    hand z to the wrist, y from WRB to WRA on the right, back on the left                                            (7)

The chord is that of knees and ankles (`segments`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..data.array_types import Floats
from ..data.model_markers import ARM_MARKERS, HEAD_MARKERS, THORAX_MARKERS
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, ArmMeasures, Side, SubjectMeasures
from ..kinematics import principal, turned
from .segments import Segment, joint_centre, perpendicular, relative, unit, upright, within_half_turn

UPPER_BODY_AXES = {
    "Thorax": ("tilt", "obliquity", "rotation"),
    "Spine": ("flexion", "lateral flexion", "rotation"),
    "Head": ("tilt", "obliquity", "rotation"),
    "Neck": ("flexion", "lateral flexion", "rotation"),
    "Shoulder": ("flexion", "abduction", "rotation"),
    "Elbow": ("flexion", "adduction", "rotation"),
    "Wrist": ("flexion", "deviation", "rotation"),
}
"""What each angle is, by part."""
FAR_MM = 100.0
"""How far off the point is that states the plane of a chord, mm; chosen, of no effect."""


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """Shoulder (…, 3) mm, and segments whose origins are elbow, wrist and hand."""

    shoulder: Floats
    upper_arm: Segment
    forearm: Segment
    hand: Segment


def thorax_of(points: Mapping[str, Floats], measures: SubjectMeasures) -> Segment:
    """(1)."""
    clavicle, sternum, c7, t10 = (points[name] for name in THORAX_MARKERS)
    z = unit(clavicle + c7 - sternum - t10)
    x = perpendicular(clavicle + sternum - c7 - t10, z)
    return Segment(np.stack([x, np.cross(z, x), z], -1), clavicle - measures.marker_diameter_mm / 2 * x)


def head_of(points: Mapping[str, Floats], measures: SubjectMeasures) -> Segment:
    """(2)."""
    lf, rf, lb, rb = (points[name] for name in HEAD_MARKERS)
    x = unit(lf + rf - lb - rb)
    y = perpendicular(lf + lb - rf - rb, x)
    R = np.stack([x, y, np.cross(x, y)], -1)
    return Segment(R @ turned(np.array([measures.head_offset_deg, 0.0, 0.0]), "yxz"), (lf + rf) / 2)


def arm_of(points: Mapping[str, Floats], thorax: Segment, measures: ArmMeasures, radius: float, side: Side) -> Arm:
    """(3) to (7); radius of a marker, mm."""
    left = TO_THE_LEFT[side]
    sho, elb, wra, wrb, fin = (points[LETTER[side] + name] for name in ARM_MARKERS)
    beside = np.cross(unit(sho - thorax.origin), thorax.R[..., 0])
    shoulder = joint_centre(
        thorax.origin, sho, thorax.origin - left * FAR_MM * beside, half_width_mm=measures.shoulder_mm + radius
    )  # (3)
    wrist_middle = (wra + wrb) / 2
    square = unit(np.cross(shoulder - elb, wrist_middle - elb))
    elbow = joint_centre(
        shoulder, elb, elb + left * FAR_MM * square, half_width_mm=measures.elbow_mm / 2 + radius
    )  # (4)
    into = unit(np.cross(wrb - wra, elbow - wrist_middle))
    wrist = wrist_middle - left * (measures.wrist_mm / 2 + radius) * into  # (5)
    knuckles = joint_centre(wrist, fin, wrist_middle, half_width_mm=measures.hand_mm / 2 + radius)  # (6)
    z = unit(shoulder - elbow)
    x = perpendicular(elbow - wrist, z)
    upper_arm = Segment(np.stack([x, np.cross(z, x), z], -1), elbow)
    forearm = upright(wrist, elbow - wrist, upper_arm.R[..., 1])
    hand = upright(knuckles, wrist - knuckles, left * (wrb - wra))  # (7)
    return Arm(shoulder, upper_arm, forearm, hand)


def upper_body_angles(
    points: Mapping[str, Floats], measures: SubjectMeasures, pelvis: Segment, progression: Floats
) -> dict[str, Floats]:
    """(…, 3) deg by name, as LThoraxAngles, of all parts whose markers and measures are there.

    Args:
        points: (…, 3) mm by name. measures: of the subject. pelvis: over the same frames.
        progression: (3, 3) or (…, 3, 3) forward, left and up.
    """
    found: dict[str, Floats] = {}
    if not set(THORAX_MARKERS) <= set(points):
        return found
    thorax, seen = thorax_of(points, measures), np.swapaxes(progression, -1, -2)
    down = thorax.R * np.array([1.0, -1.0, -1.0])  # Plug-in Gait's thorax has z downwards
    head = head_of(points, measures) if set(HEAD_MARKERS) <= set(points) else None
    for side in SIDES:
        letter, mirror = LETTER[side], np.array([1.0, TO_THE_LEFT[side], TO_THE_LEFT[side]])
        found[f"{letter}ThoraxAngles"] = _read(seen @ down, (1, -1, 1) * mirror, (180, 0, 180))
        found[f"{letter}SpineAngles"] = _read(relative(down, pelvis.R), (1, -1, -1) * mirror, (180, 0, 180))
        if head is not None:
            found[f"{letter}HeadAngles"] = _read(seen @ head.R, (-1, 1, -1) * mirror)
            found[f"{letter}NeckAngles"] = _read(relative(head.R, down), (-1, -1, 1) * mirror, (180, 0, 180))
        arm = _arm_where_known(points, thorax, measures, side)
        if arm is not None:
            upper, lower = arm.upper_arm.R, arm.forearm.R
            zyx = principal(relative(upper, down), "zyx")[..., [1, 2, 0]] * ((1, -1, 1) * mirror) + (0, 180, 180)
            found[f"{letter}ShoulderAngles"] = within_half_turn(zyx)
            found[f"{letter}ElbowAngles"] = _read(relative(lower, upper), (-1, 1, 1) * mirror)
            found[f"{letter}WristAngles"] = _read(relative(lower, arm.hand.R), (1, -1, -1) * mirror)
    return found


def _arm_where_known(
    points: Mapping[str, Floats], thorax: Segment, measures: SubjectMeasures, side: Side
) -> Arm | None:
    own = measures.arm(side)
    if own is None or not {LETTER[side] + name for name in ARM_MARKERS} <= set(points):
        return None
    return arm_of(points, thorax, own, measures.marker_diameter_mm / 2, side)


def _read(R: Floats, sign: ArrayLike, plus: tuple[int, int, int] = (0, 0, 0)) -> Floats:
    """(…, 3) deg of Rᵧ Rₓ R_z with signs and offsets."""
    return within_half_turn(principal(R, "yxz") * np.asarray(sign) + plus)
