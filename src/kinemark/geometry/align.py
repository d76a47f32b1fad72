"""The rigid motion that best lays one set of points on another (Kabsch 1976; Söderkvist & Wedin 1993).

With a (N, 3) and b (N, 3) less their centres, R maximises tr(Rᵀ H), H = Σ b aᵀ = U S Vᵀ, so R = U diag(1, 1, ±1) Vᵀ
with the sign that makes it a rotation (1). For many small H at once V comes from the symmetric Hᵀ H = V S² Vᵀ, u₁ and
u₂ from H v₁ and H v₂, and the third directions from cross products, which makes R a rotation whatever the rank, as long
as two singular values stand out (2).

Where det H > 0, R is the polar factor of H as well, which Newton's method finds in few steps from X = H (Higham 1986),

    X ← (X / γ + γ X⁻ᵀ) / 2,   γ = det(X)^⅓,   X⁻ᵀ = cofactors(X) / det X                          (3)
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from ..numerics.vectors import cross

LEAST_DET = 1e-14
"""det H as a share of |H|³, below which rounding may decide its sign, and (2) is used; chosen."""
ROUNDS = 20
"""Of (3) at most; five to seven are usual; chosen."""


def rigid_align(source: Floats, target: Floats) -> tuple[Floats, Floats]:
    """R (3, 3), t (3,) that minimise Σ |R source + t − target|² over pairs (N, 3) without NaN.

    Raises:
        ValueError: fewer than three pairs are complete.
    """
    both = np.isfinite(source).all(1) & np.isfinite(target).all(1)
    if both.sum() < 3:
        raise ValueError(f"{both.sum()} complete pairs, wanted at least 3")
    a, b = source[both], target[both]
    ca, cb = a.mean(0), b.mean(0)
    R = best_rotations((b - cb).T @ (a - ca))
    return R, cb - R @ ca


def best_rotations(H: Floats) -> Floats:
    """The rotations (…, 3, 3) that maximise tr(Rᵀ H), for H (…, 3, 3) without NaN of any rank; exact, by SVD."""
    U, _, Vt = np.linalg.svd(H)
    side = np.ones((*H.shape[:-2], 1, 3))
    side[..., 0, 2] = np.sign(np.linalg.det(U @ Vt))
    return (U * side) @ Vt  # (1)


def nearest_rotations(H: Floats) -> Floats:
    """The rotations (…, 3, 3) that maximise tr(Rᵀ H), for H (…, 3, 3) without NaN; NaN where its rank is below 2."""
    _, V = np.linalg.eigh(H.mT @ H)  # (2)
    v1, v2 = V[..., 2], V[..., 1]
    u1 = _unit((H @ v1[..., None])[..., 0])
    u2 = (H @ v2[..., None])[..., 0]
    u2 = _unit(u2 - (u1 * u2).sum(-1, keepdims=True) * u1)
    left = np.stack([u1, u2, cross(u1, u2)], -1)
    return left @ np.stack([v1, v2, cross(v1, v2)], -1).mT


def polar_rotations(H: Floats) -> Floats:
    """`nearest_rotations` of many H (N, 3, 3) at once by (3), in a third of the time."""
    X = np.moveaxis(H, 0, -1).copy()
    det = _determinant(X, _cofactors(X))
    far = ~(det > LEAST_DET * (X**2).sum((0, 1)) ** 1.5)
    X[..., far] = np.eye(3)[..., None]
    for _ in range(ROUNDS):
        cofactors = _cofactors(X)
        det = _determinant(X, cofactors)
        scale = np.cbrt(det)
        new = 0.5 * (X / scale + cofactors * (scale / det))  # (3)
        step, X = np.abs(new - X).max(initial=0.0), new
        if step < 1e-8:
            break
    R = np.ascontiguousarray(np.moveaxis(X, -1, 0))
    if far.any():
        R[far] = nearest_rotations(H[far])
    return R


def _cofactors(X: Floats) -> Floats:
    """Of (3, 3, N)."""
    round_it = [0, 1, 2, 0, 1]
    Y = X[round_it][:, round_it]
    return Y[1:4, 1:4] * Y[2:, 2:] - Y[1:4, 2:] * Y[2:, 1:4]


def _determinant(X: Floats, cofactors: Floats) -> Floats:
    return np.asarray(X[0, 0] * cofactors[0, 0] + X[0, 1] * cofactors[0, 1] + X[0, 2] * cofactors[0, 2])


def rigid_poses(shape: Floats, points: Floats) -> tuple[Floats, Floats]:
    """R (F, 3, 3) and the centres (F, 3) that lay a shape (N, 3) on points (F, N, 3) without NaN.

    A point p of the body then lies at R (p − mean of the shape) + centre.
    """
    centre = points.mean(-2)
    H = (points - centre[..., None, :]).mT @ (shape - shape.mean(0))
    return nearest_rotations(H), centre


def _unit(v: Floats) -> Floats:
    length = np.sqrt((v * v).sum(-1, keepdims=True))
    return np.divide(v, length, out=np.full_like(v, np.nan), where=length > 0)
