"""The linear equations of UM²AS for a million perturbed samples at once, and their first derivatives.

A camera's eleven parameters L see the point X at (u, v) when, with w = 1 + L9 X + L10 Y + L11 Z,

    u w = L1 X + L2 Y + L3 Z + L4,    v w = L5 X + L6 Y + L7 Z + L8      (1)  UM²AS eq. B.4, B.5

**Calibration** (UM²AS eq. 2.4). Write a = (L1 … L4), b = (L5 … L8), c = (L9, L10, L11), and let the N control points
be the rows of X (N, 3) and of X̄ = [X 1] (N, 4). Least squares over (1) is

    X̄ a − u ∘ (X c) ≈ u,    X̄ b − v ∘ (X c) ≈ v                          (2)

For any c the best a and b are a = X̄⁺ (u ∘ (1 + X c)) and b likewise (3). What they leave is the part of u ∘ (1 + X c)
that the columns of Q span, N − 4 directions at right angles to those of X̄, which never change:

    Qᵀ diag(u) X c ≈ −Qᵀ u,    Qᵀ diag(v) X c ≈ −Qᵀ v                    (4)

Three unknowns instead of eleven, and matrices linear in u and v: this is what makes a million calibrations a matter of
a second. The answer is that of (AᵀA)⁻¹Aᵀb, not an approximation of it (Golub and Pereyra 1973).

To first order, at points that fit, an error ε of u or v changes the right side of its row by w ε, and

    δL = A⁺ (w ∘ ε)                                                      (5)

with A the matrix of (2), 2 N × 11.

**A point** (UM²AS eq. 2.5). (1) read as equations of X is B X = D, and X_mn = (BᵀB)⁻¹ BᵀD over the four rows of
cameras m and n (6). Errors ε of the images and δL of the parameters move it, to first order, by

    δX_mn = (BᵀB)⁻¹ Σ_c B_cᵀ (w_c ε_c − A_c δL_c),    c = m, n           (7)

with A_c (2, 11) the rows of (2) at that point; the mean over pairs moves by the mean of (7).
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from kinemark.data import KinemarkError
from kinemark.data.array_types import Floats
from kinemark.numerics.small_matrices import inverse3

FEWEST = 6  # points that the eleven parameters of a DLT need; by definition
SINGULAR = 1e-14
"""Of the product of the diagonal, below which a determinant is rounding; conventional: some ten roundings."""
SYMMETRIC = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # rows and columns of the six entries; by definition


def fit_parameters(xyz: Floats, uv: Floats) -> Floats:
    """The eleven parameters (…, 11) of cameras that see control points (N, 3) at (…, N, 2) px, by (3) and (4).

    Raises:
        KinemarkError: fewer than six points, or points in one plane.
    """
    check_points(xyz)
    u, v = uv.reshape(-1, *uv.shape[-2:]).transpose(2, 1, 0).copy()  # (N, S) each
    full = np.column_stack([xyz, np.ones(len(xyz))])
    Q = np.linalg.qr(full, mode="complete")[0][:, 4:]
    by_image = np.einsum("ik,ij->jki", Q, xyz).reshape(-1, len(xyz))
    M = np.concatenate([(by_image @ each).reshape(3, -1, each.shape[1]) for each in (u, v)], 1)
    d = -np.concatenate([Q.T @ each for each in (u, v)])
    normal = [(M[i] * M[j]).sum(0) for i, j in SYMMETRIC]
    c = solve3_entries(normal, [(M[i] * d).sum(0) for i in range(3)], singular=SINGULAR)  # (4)
    w = 1 + xyz @ c
    back = np.linalg.pinv(full)
    return np.concatenate([back @ (u * w), back @ (v * w), c]).T.reshape(*uv.shape[:-2], 11)  # (3)


def check_points(xyz: Floats) -> None:
    """Refuse control points that determine no camera.

    Raises:
        KinemarkError: fewer than six points, one that is not finite, or points in one plane.
    """
    if xyz.ndim != 2 or xyz.shape[1] != 3 or len(xyz) < FEWEST or not np.isfinite(xyz).all():
        raise KinemarkError(
            f"The control points have shape {xyz.shape}; wanted are {FEWEST} or more with x, y and z, all known."
        )
    spread = np.linalg.svd(xyz - xyz.mean(0), compute_uv=False)
    if spread[2] < 1e-6 * spread[0]:
        raise KinemarkError("The control points lie in a plane, and no camera follows from that. Spread them out.")


def project(L: Floats, xyz: Floats) -> Floats:
    """Pixels (…, N, 2) of points (N, 3) by (1), from parameters (…, 11)."""
    first = xyz @ np.stack([L[..., :3], L[..., 4:7]], -2).swapaxes(-1, -2).reshape(*L.shape[:-1], 3, 2)
    return (first + L[..., None, [3, 7]]) / depth(L, xyz)[..., None]


def depth(L: Floats, xyz: Floats) -> Floats:
    """w (…, N) of (1): the depth of points (N, 3) in units of the depth of the world's origin."""
    return np.asarray(1 + (xyz @ L[..., 8:, None])[..., 0])


def rows(xyz: Floats, uv: Floats) -> Floats:
    """A of (2): (N, 2, 11) for points (N, 3) seen at (N, 2)."""
    full = np.column_stack([xyz, np.ones(len(xyz))])
    zero = np.zeros_like(full)
    u, v = (-uv[:, k : k + 1] * xyz for k in (0, 1))
    return np.stack([np.hstack([full, zero, u]), np.hstack([zero, full, v])], 1)


def parameter_gain(xyz: Floats, uv: Floats) -> Floats:
    """d L / d (u1, v1, u2, v2, …), (11, 2 N), by (5), for control points (N, 3) that a camera sees at (N, 2) px."""
    L = fit_parameters(xyz, uv)
    A = rows(xyz, uv)
    return np.asarray(np.linalg.pinv(A.reshape(-1, 11)) * np.repeat(depth(L, xyz), 2))


def pair_points(L: Floats, uv: Floats) -> Floats:
    """(S, Q, 3) the point of every pair of cameras (6), in the order of `itertools.combinations`.

    Args:
        L: (C, 11), or (S, C, 11) where every sample has parameters of its own.
        uv: (S, C, 2) px; NaN where a camera does not see the point.
    """
    u, v = uv[..., 0].T.copy(), uv[..., 1].T.copy()  # (C, S): long rows are quick
    P = np.moveaxis(L, -1, 0).swapaxes(-1, -2).copy() if L.ndim == 3 else L.T[..., None]  # (11, C, S or 1)
    B = [P[k] - u * P[8 + k] for k in range(3)], [P[4 + k] - v * P[8 + k] for k in range(3)]
    D = u - P[3], v - P[7]
    normal = [B[0][i] * B[0][j] + B[1][i] * B[1][j] for i, j in SYMMETRIC]
    pull = [B[0][i] * D[0] + B[1][i] * D[1] for i in range(3)]
    pairs = list(combinations(range(len(u)), 2))
    a, b = (np.array([pair[k] for pair in pairs], np.int64) for k in (0, 1))
    right = [p[a] + p[b] for p in pull]
    return solve3_entries([n[a] + n[b] for n in normal], right, singular=SINGULAR).transpose(2, 1, 0)  # (6)


def _equations(L: Floats, uv: Floats) -> tuple[Floats, Floats]:
    """B (…, C, 2, 3) and D (…, C, 2) of (6)."""
    B = np.stack([L[..., :3], L[..., 4:7]], -2) - uv[..., None] * L[..., None, 8:]
    return B, uv - L[..., [3, 7]]


def point_gains(L: Floats, xyz: Floats) -> tuple[Floats, Floats]:
    """How the mean of pairs moves, by (7): with the images, (N, 3, C, 2), and with the parameters, (N, 3, C, 11).

    Args:
        L: (C, 11) parameters.
        xyz: (N, 3) points.
    """
    uv = np.stack([project(each, xyz) for each in L], 1)
    B, _ = _equations(L, uv)
    normal = B.swapaxes(-1, -2) @ B
    pairs = list(combinations(range(len(L)), 2))
    H = np.zeros((len(xyz), len(L), 3, 2))
    for m, n in pairs:
        inverse = inverse3(normal[:, m] + normal[:, n])
        for c in (m, n):
            H[:, c] += inverse @ B[:, c].swapaxes(-1, -2) / len(pairs)
    w = np.stack([depth(each, xyz) for each in L], 1)
    A = np.stack([rows(xyz, uv[:, c]) for c in range(len(L))], 1)
    return (H * w[..., None, None]).transpose(0, 2, 1, 3), -(H @ A).transpose(0, 2, 1, 3)


def solve3_entries(A: list[Floats], b: list[Floats], *, singular: float = SINGULAR) -> Floats:
    """x (3, …) of many symmetric 3 × 3 systems A x = b, given entry by entry; NaN where singular.

    Args:
        A: xx, xy, xz, yy, yz and zz, (…) each.
        b: x, y and z, (…) each.
        singular: the share of the product of the diagonal below which a determinant counts as zero.
    """
    xx, xy, xz, yy, yz, zz = A
    first, second, third = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    det = xx * first + xy * second + xz * third
    det = np.where(np.abs(det) > singular * np.abs(xx * yy * zz), det, np.nan)
    cross = xy * xz - xx * yz
    x = first * b[0] + second * b[1] + third * b[2]
    y = second * b[0] + (xx * zz - xz * xz) * b[1] + cross * b[2]
    z = third * b[0] + cross * b[1] + (xx * yy - xy * xy) * b[2]
    return np.asarray(np.stack([x, y, z]) / det)
