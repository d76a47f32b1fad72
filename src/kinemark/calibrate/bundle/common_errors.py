"""What the errors of all cameras have in common, by a few modes.

The covariance Σ of all cameras' parameters has the block Σ_c = L_c L_cᵀ of camera c. In units of each camera's own
errors, with L of all L_c,

    R = L⁻¹ Σ L⁻ᵀ = U Λ Uᵀ                                               (1)

has ones on its diagonal, and what cameras have in common beside it. Its greatest eigenvalues λ belong to what the most
cameras share most strongly (MAXVAR, Kettenring 1971); λ is 1 of what a camera has to itself. With k of them

    F = L U_k Λ_k^½,    Σ ≈ F Fᵀ + diag(Σ_c − F_c F_cᵀ)                   (2)

keeps each camera's covariance as it is, and takes for independent what other modes share.
"""

from __future__ import annotations

import numpy as np
import scipy

from ...data import PARAMETERS
from ...data.array_types import Floats

MOST = 10  # modes; chosen on 14 corridors: as many ellipsoids hold as by all of Σ, within .2 % (5 modes: .5 %)
RANK = 1e-10  # of the greatest eigenvalue of a camera's correlations; less is rounding; chosen
SHARED = 1 + 1e-6  # least λ; chosen: above rounding


def common_errors(joint: Floats) -> Floats:
    """F (C, 15, k) of (2), of the covariance (15 C, 15 C) of all cameras' `data.PARAMETERS`; k is `MOST` or less."""
    p = len(PARAMETERS)
    roots, inverses = zip(*[_root(joint[at : at + p, at : at + p]) for at in range(0, len(joint), p)], strict=True)
    L, inverse = scipy.linalg.block_diag(*roots), scipy.linalg.block_diag(*inverses)
    size, U = np.linalg.eigh(inverse @ joint @ inverse.T)  # (1)
    kept = np.flatnonzero(size > SHARED)[-MOST:]
    return np.asarray(L @ (U[:, kept] * np.sqrt(size[kept]))).reshape(len(joint) // p, p, len(kept))  # (2)


def _root(cov: Floats) -> tuple[Floats, Floats]:
    """L (15, r) with L Lᵀ = cov (15, 15) of rank r, and its inverse (r, 15) from the left."""
    sd = np.sqrt(np.maximum(np.diag(cov), 0.0))
    scale = np.where(sd > 0, sd, 1.0)
    size, V = np.linalg.eigh(cov / scale / scale[:, None])
    kept = size > RANK * size[-1]
    root = V[:, kept] * np.sqrt(size[kept])
    return root * scale[:, None], (root / size[kept]).T / scale
