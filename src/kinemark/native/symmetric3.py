"""Many symmetric 3 × 3 matrices, along the last axis: (3, 3, T)."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats


def cofactors(A: Floats) -> tuple[Floats, Floats]:
    """The adjugates (3, 3, T) and determinants (T) of A (3, 3, T)."""
    a, b, c, d, e, f = A[0, 0], A[0, 1], A[0, 2], A[1, 1], A[1, 2], A[2, 2]
    out = np.empty_like(A)
    out[0, 0], out[1, 1], out[2, 2] = d * f - e * e, a * f - c * c, a * d - b * b
    out[0, 1] = out[1, 0] = c * e - b * f
    out[0, 2] = out[2, 0] = b * e - c * d
    out[1, 2] = out[2, 1] = b * c - a * e
    return out, a * out[0, 0] + b * out[0, 1] + c * out[0, 2]


def inverse(A: Floats) -> Floats:
    """Inverses of A (3, 3, T); not finite where singular."""
    out, determinant = cofactors(A)
    out *= 1 / determinant
    return out


def solve(A: Floats, b: Floats) -> Floats:
    """x (3, T) of A x = b for A (3, 3, T) and b (3, T); NaN where singular."""
    adjugate, determinant = cofactors(A)
    regular = np.abs(determinant) > 1e-13 * (np.abs(A[0, 0] * A[1, 1] * A[2, 2]) + 1e-300)
    return np.einsum("ijt,jt->it", adjugate, b) / np.where(regular, determinant, np.nan)
