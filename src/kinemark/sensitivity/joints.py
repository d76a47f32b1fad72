"""The joint angles of a model as a function of its markers, for `chain`."""

from __future__ import annotations

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Floats
from ..data.nearest_word import some_names
from ..kinematics import Model, joint_matrices, principal
from .propagation import Kinematics


def kinematics_of(model: Model, names: tuple[str, ...]) -> tuple[tuple[str, ...], Kinematics]:
    """Names (A) of a model's angles, and what gives them (F, A) deg from the markers `names` (M, F, 3) mm.

    Principal values, without continuity over turns, as only their small changes are wanted.

    Raises:
        KinemarkError: a marker of the model is not among the names.
    """
    called = {wanted: _find(names, (wanted, *model.aliases.get(wanted, ()))) for wanted in model.markers}
    if absent := [wanted for wanted, name in called.items() if name is None]:
        raise KinemarkError(
            f"The model {model.name!r} wants the markers {', '.join(absent)}; there are {some_names(names)}. "
            "Name a file with these markers by --markers, or another model."
        )
    rows = {wanted: names.index(name) for wanted, name in called.items() if name is not None}
    asked = [(j, k) for j, joint in enumerate(model.joints) for k, motion in enumerate(joint.motions) if motion]
    words = tuple(f"{model.joints[j].name} {motion.name}" for j, k in asked if (motion := model.joints[j].motions[k]))

    def angles(xyz: Floats) -> Floats:
        R = joint_matrices({name: xyz[m] for name, m in rows.items()}, model)
        turned = [
            principal(R[j], joint.sequence, negative_middle=joint.middle == "negative")
            for j, joint in enumerate(model.joints)
        ]
        return np.stack([turned[j][..., k] for j, k in asked], -1)

    return words, angles


def _find(names: tuple[str, ...], wanted: tuple[str, ...]) -> str | None:
    """The first name that is there, whole or after a subject's name and a colon."""
    for want in wanted:
        for name in names:
            if want in (name, name.rsplit(":", 1)[-1]):
                return name
    return None
