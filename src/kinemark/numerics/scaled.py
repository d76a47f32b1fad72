"""Normal matrices whose unknowns differ by many powers of ten in size, as a focal length and a lens term do.

With d = (diag A)^(−1/2), the matrix d A d has ones along its diagonal whatever the unknowns' units are, so that what is
singular can be distinguished from what is only small:

    A⁻¹ = d (d A d)⁻¹ d                                                   (1)
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats

RANK = 1e-15
"""Of the largest singular value of a scaled matrix, below which there is none; conventional: a few roundings."""


def scaled_solution(A: Floats, b: Floats) -> Floats:
    """x (p) of A x = b for a normal matrix (p, p); the shortest in the scale of (1) where A is singular."""
    d = _scale(A)
    return np.asarray(d * np.linalg.lstsq(A * d * d[:, None], b * d, rcond=RANK)[0], np.float64)


def scaled_inverse(A: Floats) -> Floats:
    """Inverse of a normal matrix (p, p) by (1); of the null space, zero."""
    d = _scale(A)
    return np.asarray(d[:, None] * np.linalg.pinv(A * d * d[:, None], hermitian=True) * d)


def _scale(A: Floats) -> Floats:
    """d (p) of (1); 1 where nothing is known of an unknown."""
    diagonal = np.diag(A)
    return np.asarray(1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)))
