"""Angles of the gait model as clinicians read them.

Each is the rotation of a segment in another, taken apart as Rᵧ(a) Rₓ(b) R_z(c):

    pelvis, hip, knee            flexion a, adduction b, rotation c                                             (1)
    ankle, foot progression      a, c, b                                                                        (2)

with signs such that flexion, dorsiflexion, adduction and internal rotation are positive on both sides, forward tilt and
the side's own pelvis upwards and forwards too (3); the ankle is at 0° where the foot stands square to the shank (4).
Pelvis and foot are seen from the direction of progression (`progression`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import LETTER, SIDES, TO_THE_LEFT, Side
from ..kinematics import principal
from .lower_limb import FOOT_SEQUENCE, LowerLimbs
from .progression import progression
from .segments import relative, within_half_turn


class Reading(NamedTuple):
    """How an angle follows from a, b, c: which of them, with which sign on the left, and plus what in deg."""

    name: str
    axes: tuple[str, str, str]
    of: tuple[int, int, int]
    sign: tuple[float, float, float]
    plus: float = 0.0


READINGS = (
    Reading("Pelvis", ("tilt", "obliquity", "rotation"), (0, 1, 2), (1, 1, -1)),
    Reading("Hip", ("flexion", "adduction", "rotation"), (0, 1, 2), (-1, -1, -1)),
    Reading("Knee", ("flexion", "adduction", "rotation"), (0, 1, 2), (1, -1, -1)),
    Reading("Ankle", ("dorsiflexion", "adduction", "rotation"), (0, 2, 1), (-1, -1, -1), -90.0),
    Reading("FootProgress", ("pitch", "progression", "roll"), (0, 2, 1), (1, 1, -1)),
)
"""(1) to (4), of the left leg; on the right the second and third change their sign (3). As Plug-in Gait has them."""


def clinical_angles(limbs: LowerLimbs, *, lab: Floats | None = None) -> dict[str, Floats]:
    """(…, F, 3) deg by name: LPelvisAngles, LHipAngles, … RFootProgressAngles.

    Args:
        limbs: over frames.
        lab: (3, 3) or (F, 3, 3) forward, left and up, from which pelvis and foot are seen; Plug-in Gait's where None.
    """
    lab = progression(limbs) if lab is None else lab
    return {
        f"{LETTER[side]}{reading.name}Angles": read(reading, rotation, side)
        for side in SIDES
        for reading, rotation in zip(READINGS, _rotations(limbs, side, lab), strict=True)
    }


def read(reading: Reading, R: Floats, side: Side) -> Floats:
    """(…, 3) deg of rotations R (…, 3, 3)."""
    deg = principal(R, FOOT_SEQUENCE)[..., list(reading.of)]
    mirror = TO_THE_LEFT[side]
    deg = deg * np.array(reading.sign) * (1.0, mirror, mirror)
    deg[..., 0] += reading.plus
    return within_half_turn(deg)


def _rotations(limbs: LowerLimbs, side: Side, lab: Floats) -> tuple[Floats, ...]:
    """Of pelvis, hip, knee, ankle and foot, in the order of `READINGS`."""
    leg, pelvis = limbs.leg(side), limbs.pelvis.R
    seen = np.swapaxes(lab, -1, -2)
    return (
        seen @ pelvis,
        relative(pelvis, leg.thigh.R),
        relative(leg.thigh.R, leg.shank_at_knee.R),
        relative(leg.shank.R, leg.foot.R),
        seen @ leg.foot.R,
    )
