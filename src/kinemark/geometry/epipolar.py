"""Epipolar lines: where the second camera may see what the first one sees.

For projections P1 = [M1 | m1], P2 = [M2 | m2] of ideal lenses, two pixels of one point satisfy

    (u2, v2, 1) F (u1, v1, 1)ᵀ = 0,   F = [e2]× M2 M1⁻¹,   e2 = m2 − M2 M1⁻¹ m1        (1)

(Hartley & Zisserman 2004, eq. 9.2), where e2 is the image of the first camera's centre. The same line from
the DLT equations of both cameras: the four planes through the two pixels meet in a point, so

    det [B(u1, v1), D(u1, v1); B(u2, v2), D(u2, v2)] = 0                              (2)

with the rows of KISS eq. 7. Being bilinear in (u1, v1) and (u2, v2), (2) is KISS eq. 8 with nine constants,

    (u1 m1 + v1 m2 + m3) u2 + (u1 m4 + v1 m5 + m6) v2 + u1 m7 + v1 m8 + m9 = 0         (3)
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from .dlt import from_dlt


def fundamental(P1: Floats, P2: Floats) -> Floats:
    """F (3, 3) of (1), of unit norm, for two projections (3, 4)."""
    turn = P2[:, :3] @ np.linalg.inv(P1[:, :3])
    ex, ey, ez = P2[:, 3] - turn @ P1[:, 3]
    F = np.array([[0, -ez, ey], [ez, 0, -ex], [-ey, ex, 0]]) @ turn  # (1)
    size = np.linalg.norm(F)
    return np.asarray(F / (size if size > 0 else np.nan))  # NaN: cameras in one place share no epipolar lines


def epipolar_constants(L1: Floats, L2: Floats) -> Floats:
    """m1 … m9 (9,) of KISS eq. 8 from the eleven DLT parameters of two cameras, of unit norm.

    Each constant multiplies one product of {u1, v1, 1} and {u2, v2, 1}. A row of KISS eq. 7 for u is
    P[0] − u P[2], so the determinant (2) falls into nine determinants of rows of P alone.
    """
    P1, P2 = from_dlt(L1), from_dlt(L2)

    def part(first: str, second: str) -> float:
        """The determinant that multiplies `first` (u, v or 1) of camera 1 and `second` of camera 2."""
        rows = {"u": (-1, 2, 1), "v": (-1, 0, 2), "1": (1, 0, 1)}
        s1, a1, b1 = rows[first]
        s2, a2, b2 = rows[second]
        return s1 * s2 * float(np.linalg.det(np.array([P1[a1], P1[b1], P2[a2], P2[b2]])))

    m = np.array([part(first, second) for second in "uv1" for first in "uv1"])
    return m / np.linalg.norm(m)


def epipolar_lines(F: Floats, uv: Floats) -> Floats:
    """Lines (…, 3) a u2 + b v2 + c = 0 in camera 2 of pixels (…, 2) in camera 1, with a² + b² = 1.

    So a pixel's product with the line is its distance in px.
    """
    line = uv @ F[:, :2].T + F[:, 2]
    return np.asarray(line / np.linalg.norm(line[..., :2], axis=-1, keepdims=True))


def line_distance(lines: Floats, uv: Floats) -> Floats:
    """Signed distance (…), px, of pixels (…, 2) from lines (…, 3)."""
    return (lines[..., :2] * uv).sum(-1) + lines[..., 2]
