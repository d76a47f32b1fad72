"""What a joint's angles are called, and whether they are within the range of normal motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .angles import Angles
from .array_types import Bools
from .models import JointMotion, Model


class NamedAngle(NamedTuple):
    """One angle that a model gives a name to: its joint, its place in the sequence, and its words."""

    joint: int
    turn: int
    motion: JointMotion


def named_angles(model: Model) -> tuple[NamedAngle, ...]:
    """The degrees of freedom of a model, in the order of its joints."""
    return tuple(
        NamedAngle(j, t, motion)
        for j, joint in enumerate(model.joints)
        for t, motion in enumerate(joint.motions)
        if motion is not None
    )


def outside(angles: Angles, model: Model) -> Bools:
    """(J, F, 3) whether an angle is beyond its normal range; False where the range or the angle is unknown."""
    out = np.zeros(angles.deg.shape, np.bool_)
    for j, t, motion in named_angles(model):
        if motion.normal is not None:
            low, high = motion.normal
            with np.errstate(invalid="ignore"):
                out[j, :, t] = (angles.deg[j, :, t] < low) | (angles.deg[j, :, t] > high)
    return out
