"""The hip joint centre in the pelvis, by regression equations.

Axes of the pelvis: x forward, y to the left, z up, from the midpoint of the front points (ASIS). With L the mean length
of the legs, D the distance of the front points, P the depth of the pelvis, t from front point to trochanter, r the
marker's radius, all in mm, and s = 1 on the left, −1 on the right:

    Davis     C = 0.115 L − 15.3,  θ = 0.5 rad,  β = 0.314 rad
              x = C cos θ sin β − (t + r) cos β,   y = −s (C sin θ − D / 2),
              z = −C cos θ cos β − (t + r) sin β                                                              (1)
    Harrington x = −0.24 P − 9.9 − r,  y = s (0.33 D + 7.3),   z = −0.30 D − 10.9                              (2)
    Hara      x = 11 − 0.063 L,        y = s (8 + 0.086 L),    z = −9 − 0.078 L                                (3)

(2) and (3) are of the skin's points; (2) has the marker's radius in x, as its pelvis is measured from the bone.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import TO_THE_LEFT, Side, SubjectMeasures

HipCentre = Literal["davis", "harrington", "hara"]
THETA, BETA = 0.5, 0.314
"""Angles of the pelvis in (1), rad (Davis et al. 1991)."""


def davis(measures: SubjectMeasures, side: Side, asis_mm: float) -> Floats:
    """(3) mm by (1)."""
    s, r = TO_THE_LEFT[side], measures.marker_diameter_mm / 2
    C = 0.115 * measures.mean_leg_mm - 15.3
    t = measures.leg(side).hip_to_trochanter_mm + r
    x = C * np.cos(THETA) * np.sin(BETA) - t * np.cos(BETA)
    z = -C * np.cos(THETA) * np.cos(BETA) - t * np.sin(BETA)
    return np.array([x, -s * (C * np.sin(THETA) - asis_mm / 2), z])


def harrington(measures: SubjectMeasures, side: Side, asis_mm: float, depth_mm: float) -> Floats:
    """(3) mm by (2)."""
    s, r = TO_THE_LEFT[side], measures.marker_diameter_mm / 2
    return np.array([-0.24 * depth_mm - 9.9 - r, s * (0.33 * asis_mm + 7.3), -0.30 * asis_mm - 10.9])


def hara(measures: SubjectMeasures, side: Side) -> Floats:
    """(3) mm by (3)."""
    s, L = TO_THE_LEFT[side], measures.mean_leg_mm
    return np.array([11 - 0.063 * L, s * (8 + 0.086 * L), -9 - 0.078 * L])
