"""Two views of the same points: the fundamental and the essential matrix, and the pose that follows from them.

Pixels of one point in two ideal cameras satisfy x₂ᵀ F x₁ = 0 with x = (u, v, 1) (1), linear in the nine entries of
F, so that eight points determine it. Both images are first moved and scaled to zero mean and unit spread (Hartley
1997), and the nearest matrix of rank 2 is taken (2). How far a pair is from (1) is measured by Sampson's distance,
the first-order distance in px to the nearest pair that satisfies it (Hartley & Zisserman 2004, eq. 11.9),

    d = x₂ᵀ F x₁ / √((F x₁)₁² + (F x₁)₂² + (Fᵀ x₂)₁² + (Fᵀ x₂)₂²)        (3)

Wrong pairs: F from many samples of eight, the one whose median |d| is least (4), refitted to the pairs within 3
standard deviations, that of a normal distribution being 1.4826 times the median of |d| (5) (Rousseeuw 1984).

With known inner parameters E = K₂ᵀ F K₁ = [t]× R = U diag(1, 1, 0) Vᵀ (6) gives four poses,

    R = U W Vᵀ or U Wᵀ Vᵀ,  t = ± u₃,  W a quarter turn about z          (7)

of which the right one has most points in front of both cameras. There x₂ ~ R x₁ + t, |t| = 1.
"""

from __future__ import annotations

import numpy as np

from ..data import KinemarkError
from ..data.array_types import Bools, Floats
from ..numerics.robust import SD_PER_MEDIAN
from ..numerics.vectors import homogeneous

FEWEST = 8  # pairs that the eight-point method needs; by definition
TRIALS = 150  # samples of eight; with 30 % wrong pairs one in 17 is right: chosen
SCORED = 400  # pairs by which a sample is scored; chosen for speed
SPREAD = 3.0  # standard deviations within which pairs fit; conventional
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""W of (7), a quarter turn about z; by definition."""


def fit_fundamental(uv1: Floats, uv2: Floats) -> Floats:
    """F (3, 3) of unit norm and rank 2 from N ≥ 8 pairs of ideal pixels (N, 2), by (1) and (2).

    Raises:
        KinemarkError: fewer than eight complete pairs.
    """
    both = np.isfinite(uv1).all(-1) & np.isfinite(uv2).all(-1)
    if both.sum() < FEWEST:
        raise KinemarkError(
            f"Two cameras have {both.sum()} points in common, and their epipolar geometry needs {FEWEST}. "
            "Show them more points at the same time."
        )
    return fundamentals(uv1[both][None], uv2[both][None])[0]


def fundamentals(uv1: Floats, uv2: Floats) -> Floats:
    """F (T, 3, 3) of T sets of n ≥ 8 pairs (T, n, 2), each of unit norm and rank 2, by (1) and (2)."""
    x1, T1 = _scaled(uv1)
    x2, T2 = _scaled(uv2)
    rows = (x2[..., :, None] * x1[..., None, :]).reshape(*x1.shape[:-1], 9)  # (1)
    if rows.shape[-2] > 4 * FEWEST:
        F = np.linalg.eigh(np.swapaxes(rows, -1, -2) @ rows)[1][..., :, 0].reshape(-1, 3, 3)
    else:
        F = np.linalg.svd(rows)[2][..., -1, :].reshape(-1, 3, 3)
    U, s, Vt = np.linalg.svd(F)
    F = (U[..., :2] * s[..., None, :2]) @ Vt[..., :2, :]  # (2)
    F = np.swapaxes(T2, -1, -2) @ F @ T1
    return np.asarray(F / np.maximum(np.linalg.norm(F, axis=(-2, -1), keepdims=True), 1e-300))


def robust_fundamental(uv1: Floats, uv2: Floats, *, seed: int = 0, trials: int = TRIALS) -> tuple[Floats, Bools]:
    """F (3, 3) from pairs (N, 2) of which less than half are wrong, and which ones (N) fit it.

    Args:
        uv1: (N, 2) ideal pixels in the first camera; NaN where not seen.
        uv2: (N, 2) in the second.
        seed: of the samples.
        trials: how many samples of eight.

    Raises:
        KinemarkError: fewer than eight complete pairs.
    """
    both = np.flatnonzero(np.isfinite(uv1).all(-1) & np.isfinite(uv2).all(-1))
    if len(both) < FEWEST:
        return fit_fundamental(uv1, uv2), np.isfinite(uv1[..., 0])
    rng = np.random.default_rng(seed)
    sample = both[rng.random((trials, len(both))).argpartition(FEWEST - 1, axis=1)[:, :FEWEST]]
    scored = both if len(both) <= SCORED else rng.choice(both, SCORED, replace=False)
    F = fundamentals(uv1[sample], uv2[sample])
    d = np.abs(sampson_distance(F[:, None], uv1[scored], uv2[scored]))
    best, inliers = F[np.median(d, axis=1).argmin()], np.zeros(len(uv1), np.bool_)  # (4)
    for _ in range(5):
        d = np.abs(sampson_distance(best, uv1[both], uv2[both]))
        near = d <= max(SPREAD * SD_PER_MEDIAN * float(np.median(d)), 1e-9)  # (5)
        if near.sum() < FEWEST or (near == inliers[both]).all():
            break
        inliers[both] = near
        best = fundamentals(uv1[inliers][None], uv2[inliers][None])[0]
    return best, inliers


def sampson_distance(F: Floats, uv1: Floats, uv2: Floats) -> Floats:
    """(3), signed, px (…), for F (…, 3, 3) and pixels (…, 2) in both cameras."""
    (u1, v1), (u2, v2) = (np.moveaxis(uv, -1, 0) for uv in (uv1, uv2))
    a, b, c = (F[..., i, 0] * u1 + F[..., i, 1] * v1 + F[..., i, 2] for i in range(3))  # F x₁
    d, e = (F[..., 0, i] * u2 + F[..., 1, i] * v2 + F[..., 2, i] for i in range(2))  # Fᵀ x₂
    return np.asarray((u2 * a + v2 * b + c) / np.maximum(np.sqrt(a**2 + b**2 + d**2 + e**2), 1e-300))  # (3)


def essential(F: Floats, K1: Floats, K2: Floats) -> Floats:
    """E (…, 3, 3) of (6), of unit norm."""
    E = np.swapaxes(K2, -1, -2) @ F @ K1
    return np.asarray(E / np.linalg.norm(E, axis=(-2, -1), keepdims=True))


def poses(E: Floats) -> tuple[Floats, Floats]:
    """The four poses (7) of essential matrices (…, 3, 3): R (…, 4, 3, 3), t (…, 4, 3) of unit length."""
    U, _, Vt = np.linalg.svd(E)
    U = U * np.linalg.det(U)[..., None, None]
    Vt = Vt * np.linalg.det(Vt)[..., None, None]
    R1, R2, t = U @ QUARTER @ Vt, U @ QUARTER.T @ Vt, U[..., 2]  # (7)
    return np.stack([R1, R1, R2, R2], -3), np.stack([t, -t, t, -t], -2)


def relative_pose(E: Floats, xy1: Floats, xy2: Floats) -> tuple[Floats, Floats]:
    """R (…, 3, 3), t (…, 3) of the second camera from the first, from points (N, 2) or (…, N, 2) on both image planes.

    The points are normalised and ideal; of the four poses of each E (…, 3, 3) the one with most points before both
    cameras is taken.
    """
    R, t = poses(E)
    _, depth1, depth2 = midpoints(R, t, xy1[..., None, :, :], xy2[..., None, :, :])
    best = ((depth1 > 0) & (depth2 > 0)).sum(-1).argmax(-1)[..., None]
    return (
        np.take_along_axis(R, best[..., None, None], -3)[..., 0, :, :],
        np.take_along_axis(t, best[..., None], -2)[..., 0, :],
    )


def midpoints(R: Floats, t: Floats, xy1: Floats, xy2: Floats) -> tuple[Floats, Floats, Floats]:
    """The points half-way between two rays (…, N, 3) in the first camera's frame, and their depths (…, N) in both.

    R (…, 3, 3), t (…, 3) take the first camera's frame to the second's; xy (…, N, 2) are normalised and ideal.
    """
    a = homogeneous(xy1)
    b = homogeneous(xy2) @ R  # the second ray in the first frame, from −Rᵀ t
    origin = -(t[..., None, :] @ R)
    aa, bb, ab = (a * a).sum(-1), (b * b).sum(-1), (a * b).sum(-1)
    ao, bo = (a * origin).sum(-1), (b * origin).sum(-1)
    det = np.maximum(aa * bb - ab * ab, 1e-300)
    depth1, depth2 = (bb * ao - ab * bo) / det, (ab * ao - aa * bo) / det
    return (depth1[..., None] * a + origin + depth2[..., None] * b) / 2, depth1, depth2


def _scaled(uv: Floats) -> tuple[Floats, Floats]:
    """Pixels (T, n, 2) at zero mean and unit spread, (T, n, 3), and the transform (T, 3, 3) that did it."""
    mean = uv.mean(-2, keepdims=True)
    scale = 1 / np.maximum(np.sqrt(((uv - mean) ** 2).mean((-2, -1), keepdims=True)), 1e-300)
    T = np.zeros((len(uv), 3, 3))
    T[:, 0, 0] = T[:, 1, 1] = scale[:, 0, 0]
    T[:, :2, 2] = -scale[:, 0] * mean[:, 0]
    T[:, 2, 2] = 1.0
    return homogeneous((uv - mean) * scale), T
