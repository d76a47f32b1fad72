"""Normal equations of which most unknowns appear in small blocks: the Schur complement.

Let δ be the Q unknowns that all residuals share, and ε those of n blocks, D of each, which meet no other block in a
residual. With r a residual and A and B its derivatives (with the sign of `levenberg_marquardt`) by δ and ε,

    [U  W ] [δ]   [g]      U = Σ AᵀA,  V = Σ BᵀB,  W = Σ AᵀB
    [Wᵀ V ] [ε] = [h]      g = Σ Aᵀr,  h = Σ Bᵀr                          (1)

V has one D × D block each, so that ε leaves (1) at little cost (Brown 1958; Triggs et al. 2000, "Bundle adjustment",
section 6.1):

    S δ = g − W V⁻¹ h,   S = U − W V⁻¹ Wᵀ,   ε = V⁻¹ (h − Wᵀ δ)           (2)

with U and V enlarged by λ times their diagonals, as (2) of `levenberg_marquardt` wants it. S is the Schur complement of
V, and its inverse the covariance of δ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from .scaled import scaled_solution

RIDGE = 1e-14
"""Added to the scaled diagonal of a block, without unit; conventional: some roundings, so that it can be inverted."""


class BlockEquations(NamedTuple):
    """(1): U (Q, Q), g (Q); for blocks of each size D, V (n, D, D), W (n, D, Q), transposed, and h (n, D)."""

    U: Floats
    g: Floats
    V: list[Floats]
    W: list[Floats]
    h: list[Floats]


def block_step(equations: BlockEquations, damping: float) -> tuple[Floats, list[Floats], float]:
    """δ (Q) and ε (n, D) of (2), and the decrease that (3) of `levenberg_marquardt` predicts."""
    U, g, V, W, h = equations
    inverses = [block_inverses(blocks, damping) for blocks in V]
    S, b = schur_complement(equations, inverses, damping)
    delta = scaled_solution(S, b) if len(b) else b
    epsilon = [
        (inverse @ (right - w @ delta)[..., None])[..., 0] for inverse, w, right in zip(inverses, W, h, strict=True)
    ]
    predicted = g @ delta + damping * delta @ (np.diag(U) * delta)
    for step, blocks, right in zip(epsilon, V, h, strict=True):
        predicted += ((right + damping * np.diagonal(blocks, axis1=-2, axis2=-1) * step) * step).sum()
    return delta, epsilon, float(predicted)


def schur_complement(equations: BlockEquations, inverses: list[Floats], damping: float = 0.0) -> tuple[Floats, Floats]:
    """S (Q, Q) and the right side (Q) of (2), from the blocks' inverses."""
    S, b = equations.U + damping * np.diag(np.diag(equations.U)), equations.g.copy()
    for inverse, W, h in zip(inverses, equations.W, equations.h, strict=True):
        if W.size:
            flat = W.reshape(-1, W.shape[2])
            half = (_roots(inverse) @ W).reshape(flat.shape)
            S -= half.T @ half
            b -= flat.T @ (inverse @ h[..., None]).ravel()
    return S, b


def block_inverses(V: Floats, damping: float = 0.0) -> Floats:
    """(V + λ diag V)⁻¹ (n, D, D); zero for blocks of which nothing is known."""
    diagonal = np.diagonal(V, axis1=-2, axis2=-1)
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    eye = np.eye(V.shape[-1])
    scaled = V * scale[:, None] * scale[..., None] + damping * eye
    known = np.asarray((diagonal > 0).all(-1) if V.shape[-1] else np.zeros(len(V), np.bool_))
    scaled = np.where(known[:, None, None], scaled + RIDGE * eye, eye)
    inverse = np.linalg.inv(scaled) * scale[:, None] * scale[..., None]
    return np.where(known[:, None, None], inverse, 0.0)


def _roots(inverse: Floats) -> Floats:
    """L with LᵀL = V⁻¹ (n, D, D): half the work of a product, as BLAS knows that it is symmetric."""
    lost = np.diagonal(inverse, axis1=-2, axis2=-1).min(-1) <= 0
    safe = np.where(lost[:, None, None], np.eye(inverse.shape[-1]), inverse)
    roots = np.linalg.cholesky(safe).transpose(0, 2, 1)
    return np.where(lost[:, None, None], 0.0, roots)
