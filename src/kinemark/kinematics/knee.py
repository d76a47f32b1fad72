"""The knee's motion in the joint coordinate system of Grood and Suntay (1983), as in Swamidas (1997, 2.14–2.15).

Femur and tibia have axes X to the right, Y forward and Z upward. The joint's axes are one of the femur, a floating one,
and one of the tibia:

    e₁ = X_femur,   e₃ = Z_tibia,   e₂ = e₃ × e₁ / |e₃ × e₁|                                                 (1)
    flexion = atan2(−e₂ · Z_femur, e₂ · Y_femur)
    adduction = ± (90° − β), cos β = e₁ · e₃;   internal rotation = ± atan2(e₂ · X_tibia, e₂ · Y_tibia)        (2)
                + on the right, − on the left
    lateral shift, drawer, distraction: the tibia's origin from the femur's along e₁, e₂ and −e₃              (3)

The angles do not hang on an order of turns, and are those of the sequence flexion, adduction, rotation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import Side


class KneeMotion(NamedTuple):
    """Over frames (F).

    Attributes:
        deg: (F, 3) flexion, adduction and internal rotation. mm: (F, 3) of the tibia to the lateral side, forward and
            away from the femur. axes: (F, 3, 3) of (1) in the laboratory, a row an axis.
    """

    deg: Floats
    mm: Floats
    axes: Floats


def knee_motion(femur: Floats, femur_at: Floats, tibia: Floats, tibia_at: Floats, *, side: Side) -> KneeMotion:
    """Angles (2) and shifts (3) of the tibia in the femur.

    Args:
        femur, tibia: (F, 3, 3) their axes as columns: x forward, y to the left, z up. femur_at, tibia_at: (F, 3) mm of
            their origins. side: of the knee.
    """
    (Xf, Yf, Zf), (Xt, Yt, Zt) = ((-R[..., 1], R[..., 0], R[..., 2]) for R in (femur, tibia))
    floating = np.cross(Zt, Xf)
    e2 = floating / np.linalg.norm(floating, axis=-1, keepdims=True)  # (1)
    lateral = 1.0 if side == "right" else -1.0
    flexion = np.arctan2(-_dot(e2, Zf), _dot(e2, Yf))
    adduction = lateral * (np.pi / 2 - np.arccos(np.clip(_dot(Xf, Zt), -1, 1)))
    rotation = lateral * np.arctan2(_dot(e2, Xt), _dot(e2, Yt))
    away = tibia_at - femur_at
    mm = np.stack([lateral * _dot(away, Xf), _dot(away, e2), -_dot(away, Zt)], -1)
    return KneeMotion(np.degrees(np.stack([flexion, adduction, rotation], -1)), mm, np.stack([Xf, e2, Zt], -2))


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray((a * b).sum(-1))
