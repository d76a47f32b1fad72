"""Inverses and solutions of 2 × 2 and 3 × 3 systems, very many at once.

By cofactors, Cramer's rule: without pivots, which systems of points, of unknowns of one kind, do not need. For matrices
this small, that is many times faster than LAPACK, which is called once for each.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats

SINGULAR = 1e-13
"""Of the product of the diagonal, below which a determinant is rounding; conventional: some hundred roundings."""


def inverse2(A: Floats) -> Floats:
    """Inverses of many 2 × 2 matrices (…, 2, 2)."""
    a, b, c, d = A[..., 0, 0], A[..., 0, 1], A[..., 1, 0], A[..., 1, 1]
    adjugate = np.stack([np.stack([d, -b], -1), np.stack([-c, a], -1)], -2)
    return np.asarray(adjugate / (a * d - b * c)[..., None, None])


def inverse3(A: Floats) -> Floats:
    """Inverses of many symmetric 3 × 3 matrices (…, 3, 3); NaN where singular."""
    a, b, c, d, e, f = (A[..., i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    out = np.empty_like(A)
    out[..., 0, 0], out[..., 1, 1], out[..., 2, 2] = d * f - e * e, a * f - c * c, a * d - b * b
    out[..., 0, 1] = out[..., 1, 0] = c * e - b * f
    out[..., 0, 2] = out[..., 2, 0] = b * e - c * d
    out[..., 1, 2] = out[..., 2, 1] = b * c - a * e
    det = a * out[..., 0, 0] + b * out[..., 0, 1] + c * out[..., 0, 2]
    det = np.where(np.abs(det) > SINGULAR * (np.abs(a * d * f) + 1e-300), det, np.nan)
    return np.asarray(out / det[..., None, None])


def solve3(A: Floats, b: Floats) -> Floats:
    """x (…, 3) of A x = b for many symmetric 3 × 3 systems; NaN where singular."""
    return np.asarray((inverse3(A) @ b[..., None])[..., 0])
