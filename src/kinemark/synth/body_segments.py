"""The walking person's segments: how long they are, where markers sit on them, and the limbs that hide markers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from .subjects import Capsules

Leg = tuple[Floats, Floats, Floats]

SIDE = ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")
NAMES = ("SACR", "LASI", "RASI", *(f"L{name}" for name in SIDE), *(f"R{name}" for name in SIDE))
"""SACR sacrum; ASI anterior superior iliac spine; THI thigh wand; KNE lateral femoral epicondyle; TIB shank wand;
ANK lateral malleolus; HEE heel; TOE second metatarsal head."""

_LEG = (("ASI", "THI"), ("ASI", "KNE"), ("THI", "KNE"), ("KNE", "TIB"), ("KNE", "ANK"), ("TIB", "ANK"))
_FOOT = (("ANK", "HEE"), ("ANK", "TOE"), ("HEE", "TOE"))
LINKS = (
    ("SACR", "LASI"),
    ("SACR", "RASI"),
    ("LASI", "RASI"),
    *((side + a, side + b) for side in "LR" for a, b in _LEG + _FOOT),
)

GAP = 1.0
"""Between skin and marker, mm; chosen."""


class WalkingPose(NamedTuple):
    """F frames: pelvis (F, 3) mm, its turn (F, 3, 3), those of both legs' segments, swing (2, F) deg of both arms."""

    pelvis: Floats
    hips: Floats
    legs: tuple[Leg, Leg]
    arms: Floats


class BodySegments(NamedTuple):
    """Lengths and thicknesses of one person, mm; x forward, y left, z up, for the left side.

    The hip centre is relative to the pelvis's centre; heel and ball of the sole and the ends of the
    foot's limb to the ankle's centre.
    """

    scale: float
    marker: float
    thigh: float
    shank: float
    hip: Floats
    heel: Floats
    ball: Floats

    @classmethod
    def of(cls, height: float, marker: float) -> BodySegments:
        """In proportion to a body height, mm (Drillis and Contini)."""
        s, hip = height / 1730.0, np.array([0.0, 86.0, 0.0])
        heel, ball = np.array([-48.0, 0.0, -76.0]), np.array([122.0, 0.0, -76.0])
        return cls(s, marker, 0.245 * height, 0.246 * height, s * hip, s * heel, s * ball)

    def soles(self, pose: WalkingPose) -> Floats:
        """(4, F, 3) mm left heel and ball, right heel and ball."""
        points = []
        for joints, leg, mirror in zip(self.joints(pose), pose.legs, _MIRRORS, strict=True):
            points += [joints[2] + leg[2] @ (mirror * sole) for sole in (self.heel, self.ball)]
        return np.array(points)

    def joints(self, pose: WalkingPose) -> tuple[Leg, Leg]:
        """Centres (F, 3) mm of hip, knee and ankle, left and right."""
        sides = []
        for (thigh, shank, _), mirror in zip(pose.legs, _MIRRORS, strict=True):
            hip = pose.pelvis + pose.hips @ (mirror * self.hip)
            knee = hip - self.thigh * thigh[..., 2]
            sides.append((hip, knee, knee - self.shank * shank[..., 2]))
        return sides[0], sides[1]


_MIRRORS = (np.array([1.0, 1.0, 1.0]), np.array([1.0, -1.0, 1.0]))
"""Signs of the left and of the right side; by definition."""

THIGH, CALF, SHIN, FOOT, PELVIS, TRUNK, UPPER_ARM, FOREARM = 66.0, 50.0, 34.0, 24.0, 98.0, 112.0, 44.0, 36.0
"""Thicknesses of limbs, mm, as radii at 1730 mm height; chosen."""

WAND = 55.0
"""How far the wands hold their markers off the skin, mm; chosen."""


def build(body: BodySegments, pose: WalkingPose) -> tuple[Floats, Capsules]:
    """Markers (15, F, 3) mm in the order of `NAMES`, and the limbs."""
    sides = [
        _leg_markers(body, joints, leg, mirror)
        for joints, leg, mirror in zip(body.joints(pose), pose.legs, _MIRRORS, strict=True)
    ]
    return np.concatenate([_pelvis_markers(body, pose), *sides]), _limbs(body, pose)


def _pelvis_markers(body: BodySegments, pose: WalkingPose) -> Floats:
    """(3, F, 3) SACR, LASI, RASI: on the skin of the pelvis's capsule."""
    out = body.scale * PELVIS + body.marker + GAP
    centre = body.scale * _HIPS
    back = centre + out * _unit(-1.0, 0.0, 0.45)
    left = centre + body.scale * np.array([0.0, 70.0, 0.0]) + out * _unit(0.80, 0.42, 0.43)
    return np.array([pose.pelvis + pose.hips @ place for place in (back, left, left * _MIRRORS[1])])


_HIPS = np.array([-8.0, 0.0, 45.0])
"""Centre of the pelvis's capsule, relative to the midpoint of the hips, mm; chosen."""


def _leg_markers(body: BodySegments, joints: Leg, leg: Leg, mirror: Floats) -> Floats:
    """(6, F, 3) of one leg, in the order of `SIDE`; knee and ankle markers lie on the hinges' axes."""
    s, skin = body.scale, body.marker + GAP
    wand = np.array([0.0, s * (THIGH + WAND) + skin, -0.55 * body.thigh])
    knee = np.array([0.0, s * (THIGH - 6.0) + skin, -body.thigh])
    shin = np.array([0.0, s * (CALF + WAND) + skin, -0.55 * body.shank])
    ankle = np.array([0.0, s * SHIN + skin, -body.shank])
    heel = s * _SOLE[0] + (s * FOOT + skin) * _unit(-1.0, 0.0, 0.25)
    toe = s * _SOLE[1] + (s * FOOT + skin) * _unit(0.15, 0.0, 1.0)
    places = ((0, 0, wand), (0, 0, knee), (1, 1, shin), (1, 1, ankle), (2, 2, heel), (2, 2, toe))
    return np.array([joints[joint] + leg[segment] @ (mirror * place) for joint, segment, place in places])


_SOLE = np.array([[-24.0, 0.0, -50.0], [112.0, 0.0, -56.0]])
"""Ends of the foot's limb, seen from the ankle, mm; chosen."""


def _unit(*xyz: float) -> Floats:
    return np.array(xyz) / np.linalg.norm(xyz)


def _limbs(body: BodySegments, pose: WalkingPose) -> Capsules:
    """Legs, pelvis, trunk, head and swinging arms."""
    rows = [*_trunk_limbs(body, pose)]
    for k, side in enumerate(("left", "right")):
        rows += _leg_limbs(body, side, body.joints(pose)[k], pose.legs[k][2])
        rows += _arm_limbs(body, side, pose, _MIRRORS[k], np.radians(pose.arms[k]))
    names, a, b, radius = zip(*rows, strict=True)
    return Capsules(names, np.array(a), np.array(b), body.scale * np.array(radius))


Limb = tuple[str, Floats, Floats, float]


def _trunk_limbs(body: BodySegments, pose: WalkingPose) -> list[Limb]:
    """Pelvis, trunk and head."""
    s, p = body.scale, pose.pelvis
    ends = [p + pose.hips @ (s * (_HIPS + np.array([0.0, y, 0.0]))) for y in (70.0, -70.0)]
    trunk = [
        (f"{side} trunk", p + s * np.array([0.0, y, 215.0]), p + s * np.array([0.0, y, 430.0]), TRUNK)
        for side, y in (("left", 65.0), ("right", -65.0))
    ]
    neck, crown = (p + s * np.array([22.0, 0.0, z]) for z in (690.0, 745.0))
    return [("pelvis", ends[0], ends[1], PELVIS), *trunk, ("head", neck, crown, 85.0)]


def _leg_limbs(body: BodySegments, side: str, joints: Leg, foot: Floats) -> list[Limb]:
    """Thigh, calf, shin and foot; thigh and calf stop short of the joints, which are thinner."""
    hip, knee, ankle = joints
    heel, ball = (ankle + foot @ (body.scale * end) for end in _SOLE)
    return [
        (f"{side} thigh", hip + 0.05 * (knee - hip), hip + 0.9 * (knee - hip), THIGH),
        (f"{side} calf", knee, knee + 0.7 * (ankle - knee), CALF),
        (f"{side} shin", knee + 0.5 * (ankle - knee), ankle, SHIN),
        (f"{side} foot", heel, ball, FOOT),
    ]


def _arm_limbs(body: BodySegments, side: str, pose: WalkingPose, mirror: Floats, swing: Floats) -> list[Limb]:
    """Upper arm and forearm, the elbow bent by 25 deg, hanging a little away from the body."""
    s = body.scale
    shoulder = pose.pelvis + s * mirror * np.array([0.0, 190.0, 470.0])
    elbow = shoulder + 285.0 * s * _hang(swing, 0.22, mirror)
    wrist = elbow + 330.0 * s * _hang(swing + 0.44, 0.10, mirror)
    return [(f"{side} upper arm", shoulder, elbow, UPPER_ARM), (f"{side} forearm", elbow, wrist, FOREARM)]


def _hang(swing: Floats, spread: float, mirror: Floats) -> Floats:
    """(F, 3) directions of something that hangs, swung forward and spread sideways, rad."""
    side = np.full_like(swing, np.sin(spread))
    return mirror * np.stack([np.cos(spread) * np.sin(swing), side, -np.cos(spread) * np.cos(swing)], -1)
