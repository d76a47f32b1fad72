"""Moments and forces of joints as clinicians read them: in the axes of the distal segment, with clinical signs.

With x forward, y to the left and z up the distal segment, on the left

    ankle   (M_y, −M_z, M_x),   knee (−M_y, M_x, M_z),   hip (M_y, M_x, M_z)                          (1)

are the moments that muscles and ligaments give; on the right the second and third change their sign. Extension (of the
ankle plantar flexion), abduction and external rotation are positive, as where one leg holds the body up. Each is per kg
of body mass.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import TO_THE_LEFT, Side
from .inverse_dynamics import JointLoad

MOMENT_AXES = {"Ankle": ((1, 1.0), (2, -1.0), (0, 1.0)), "Knee": ((1, -1.0), (0, 1.0), (2, 1.0)),
               "Hip": ((1, 1.0), (0, 1.0), (2, 1.0))}  # fmt: skip
"""(1): axis and sign of each component on the left. As Plug-in Gait has them."""
FORCE_SIGN = {"Ankle": (-1.0, 1.0, -1.0), "Knee": (1.0, 1.0, 1.0), "Hip": (1.0, 1.0, 1.0)}
"""Of the joint's force along x, y and z of the distal segment. As Plug-in Gait has them."""


def clinical_moment(load: JointLoad, joint: str, side: Side, mass_kg: float) -> Floats:
    """(F, 3) N·m/kg by (1)."""
    local = np.einsum("fji,fj->fi", load.distal.R, load.moment) / mass_kg
    mirror = (1.0, TO_THE_LEFT[side], TO_THE_LEFT[side])
    return np.stack([sign * m * local[:, k] for (k, sign), m in zip(MOMENT_AXES[joint], mirror, strict=True)], -1)


def clinical_force(load: JointLoad, joint: str, mass_kg: float) -> Floats:
    """(F, 3) N/kg along the axes of the distal segment."""
    return np.einsum("fji,fj->fi", load.distal.R, load.force) / mass_kg * FORCE_SIGN[joint]
