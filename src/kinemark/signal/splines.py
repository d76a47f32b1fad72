"""Natural smoothing splines with the smoothing chosen by generalised cross-validation.

The spline of half order m is the f that minimises, over all functions,

    Σ_i (y_i − f(t_i))² + p ∫ (f⁽ᵐ⁾)² dt                                                               (1)

and m = 3 is Woltring's quintic (1986; his GCVSPL). `woltring` has the same spline for even samples in bands, in
time proportional to their number and without the error at t; this form takes any times. It has the form
f(t) = Σ c_i E(t − t_i) + Σ_{j<m} d_j tʲ with E(r) = (−1)ᵐ |r|²ᵐ⁻¹ / 2 (2m−1)! and Tᵀ c = 0, T_ij = t_iʲ (Wahba 1990,
chapter 2), so (1) becomes

    min |y − K c − T d|² + p cᵀ K c,    K_ij = E(t_i − t_j)                                              (2)

With T = [Q₁ Q₂] [R; 0], c = Q₂ γ and Q₂ᵀ K Q₂ = U diag(e) Uᵀ the solution is, for every p,

    z = Uᵀ Q₂ᵀ y,   γ = U z / (e + p),   d = R⁻¹ Q₁ᵀ (y − K c)                                           (3)
    residual sum of squares = Σ (p z / (e + p))²,   trace of I − A(p) = Σ p / (e + p)                     (4)

and generalised cross-validation takes the p of the least n RSS / trace² (5) (Craven & Wahba 1979), one p for all
coordinates, so that it turns with the laboratory. U and e depend on the times alone and are kept. The error at t is
that of kriging with the covariance σ²/p E and the noise σ² = RSS / trace (6), for weights w (t) of the samples:

    var(t) = σ² [ (wᵀ K w − 2 w · k(t)) / p + |w|² ]                                                     (7)
"""

from __future__ import annotations

from functools import lru_cache
from math import factorial
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats

CANDIDATES = np.geomspace(1e-12, 1e4, 97)
"""Candidates of p, in units of the greatest e; chosen."""


class Spline(NamedTuple):
    """A spline read at L times.

    Attributes:
        values: (L, k).
        variance: (L) of each coordinate.
        smoothing: p, in the time unit of half the range of all times.
        noise: σ of the samples.
    """

    values: Floats
    variance: Floats
    smoothing: float
    noise: float


class _Operator(NamedTuple):
    """What depends on the times alone, with the letters of the derivation; at new times the rows of K and T beside."""

    e: Floats
    Q2U: Floats
    rows: Floats  # (L, n − m): (k(t) − T(t) R⁻¹ Q₁ᵀ K) Q₂ U
    trend: Floats  # (L, n): T(t) R⁻¹ Q₁ᵀ
    k: Floats  # (L, n)
    K: Floats


def smoothing_spline(
    t: Floats, y: Floats, at: Floats, *, half_order: int = 3, smoothing: float | None = None
) -> Spline:
    """The spline through samples y (n, k) at times t (n), read at times `at` (L).

    Args:
        t: increasing.
        y: without NaN.
        at: any times; beyond the samples the spline goes on as a polynomial of degree m − 1.
        half_order: m.
        smoothing: p; None chooses it by generalised cross-validation.

    Raises:
        ValueError: fewer than m + 1 samples.
    """
    if len(t) <= half_order:
        raise ValueError(f"{len(t)} samples, wanted more than {half_order} for a spline of half order {half_order}")
    both = np.concatenate([t, at])
    centre, scale = (both.max() + both.min()) / 2, max((both.max() - both.min()) / 2, np.finfo(float).tiny)
    op = _operator(((t - centre) / scale).tobytes(), ((at - centre) / scale).tobytes(), half_order)
    offset = y.mean(0)
    z = op.Q2U.T @ (y - offset)
    p = _cross_validated(op.e, z) if smoothing is None else smoothing
    shrink = 1 / (op.e + p)
    w = (op.rows * shrink) @ op.Q2U.T + op.trend  # (3)
    noise2 = float(((p * shrink[:, None] * z) ** 2).sum() / (p * shrink).sum()) / y.shape[1]  # (6)
    spread = ((w @ op.K) * w).sum(1) - 2 * (w * op.k).sum(1)
    variance = noise2 * (np.maximum(spread, 0.0) / p + (w * w).sum(1))  # (7)
    return Spline(w @ (y - offset) + offset, variance, p, noise2**0.5)


def _cross_validated(e: Floats, z: Floats) -> float:
    """p of the least (5)."""
    p = CANDIDATES[:, None] * e.max()
    kept = p / (e + p)
    rss = (kept**2) @ (z * z).sum(1)
    return float(p[np.argmin(rss / kept.sum(1) ** 2), 0])


@lru_cache(maxsize=256)
def _operator(known: bytes, new: bytes, m: int) -> _Operator:
    t, s = np.frombuffer(known), np.frombuffer(new)
    constant = (-1) ** m / (2 * factorial(2 * m - 1))
    K, k = (constant * np.abs(a[:, None] - t) ** (2 * m - 1) for a in (t, s))
    T, T_new = (a[:, None] ** np.arange(m) for a in (t, s))
    Q, R = np.linalg.qr(T, mode="complete")
    trend = np.linalg.solve(R[:m].T, T_new.T).T @ Q[:, :m].T
    Q2 = Q[:, m:]
    e, U = np.linalg.eigh(Q2.T @ K @ Q2)
    e = np.maximum(e, 1e-15 * e.max())
    return _Operator(e, Q2 @ U, (k - trend @ K) @ Q2 @ U, trend, k, K)
