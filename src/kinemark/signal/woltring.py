"""Woltring's smoothing spline in time proportional to the number of samples (`splines`: for any times, with errors).

Of all functions, the natural spline of degree 2m − 1 minimises

    Σ w_i (y_i − f(i))² + p ∫ (f⁽ᵐ⁾)²                                                                   (1)

with w = 1 where a sample is known and 0 in a gap (Woltring 1986: m = 3). It is a sum of B-splines of that degree with
knots at the samples, f = Σ c_j B_j. The m-th derivative has the m-th differences of c on B-splines of degree m − 1, so

    (BᵀWB + p Ω) c = BᵀW y,   Ω = Dᵀ G D                                                                (2)

with G their Gram matrix: all banded. For a long signal it is the filter H = 1 / (1 + p ω²ᵐ) (3), ω in radians a sample,
so that p = (2π ν_c)⁻²ᵐ (√2 − 1) has its 1/√2 at ν_c cycles a sample. Generalised cross-validation (Craven and Wahba
1979) takes the p of the least

    n Σ w (y − f)² / (n − tr A)²,   tr A = tr[(BᵀWB + p Ω)⁻¹ BᵀWB]                                       (4)

whose trace needs no more of the inverse Z than its band. With L D Lᵀ the matrix, column by column from the last
(Hutchinson and de Hoog 1985):

    Z_ij = δ_ij / d_i − Σ_{k>i} l_ki Z_kj                                                               (5)
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Bools, Floats

CANDIDATES = np.geomspace(0.005, 0.45, 40)
"""ν_c of the p that are tried, cycles a sample; chosen."""


class SmoothedSpline(NamedTuple):
    """values (F, k), in gaps as well; cutoff ν_c, cycles a sample, of (3); gain: share of noise variance left."""

    values: Floats
    cutoff: float
    gain: float


def woltring(y: Floats, *, half_order: int = 3, cutoff: float | None = None) -> SmoothedSpline:
    """The spline through y (F, k), sampled evenly, where rows with NaN are gaps.

    Args:
        y: all columns get the same p.
        half_order: m; 2 is cubic, 3 quintic.
        cutoff: ν_c, cycles a sample; None chooses it by (4).

    Raises:
        ValueError: fewer than 2 m + 1 samples are known, or the cut-off is not between 0 and 0.5.
    """
    m, seen = half_order, np.asarray(np.isfinite(y).all(1))
    if seen.sum() <= 2 * m:
        raise ValueError(f"{seen.sum()} known samples, wanted more than {2 * m} for half order {m}")
    if cutoff is not None and not 0 < cutoff < 0.5:
        raise ValueError(f"cutoff is {cutoff:g} cycles a sample, wanted 0 to 0.5")
    B, omega = _operators(len(y), m)
    data = _band(scipy.sparse.csr_array(B.T @ scipy.sparse.diags_array(seen.astype(float)) @ B), 2 * m - 1)
    centre = y[seen].mean(0)
    target = B.T @ np.where(seen[:, None], y - centre, 0.0)
    if cutoff is None:
        cutoff = _cross_validated(B, data, omega, target, y - centre, seen, m)
    c = scipy.linalg.cho_solve_banded((_factor(data, omega, cutoff, m), True), target)
    return SmoothedSpline(B @ c + centre, cutoff, spline_gain(cutoff, half_order=m))


def spline_gain(cutoff: float, *, half_order: int = 3) -> float:
    """How many times the variance of white noise (3) leaves."""
    nu = (np.arange(4000) + 0.5) / 8000
    return float(np.mean((1 + (np.sqrt(2) - 1) * (nu / cutoff) ** (2 * half_order)) ** -2.0))


@lru_cache(maxsize=16)
def _operators(n: int, m: int) -> tuple[scipy.sparse.csr_array, Floats]:
    """B (n, n + 2m − 2) and the lower band of Ω, for unit spacing."""
    degree, size = 2 * m - 1, n + 2 * m - 2
    B = scipy.sparse.csr_array(
        scipy.interpolate.BSpline.design_matrix(
            np.arange(n, dtype=float), np.arange(-degree, n + degree, dtype=float), degree
        )
    )
    node, weight = np.polynomial.legendre.leggauss(m)
    at = (np.arange(n - 1)[:, None] + (node + 1) / 2).ravel()
    low = scipy.sparse.csr_array(
        scipy.interpolate.BSpline.design_matrix(at, np.arange(-(m - 1), n + m - 1, dtype=float), m - 1)
    )
    D: scipy.sparse.csr_array = scipy.sparse.csr_array(scipy.sparse.diags_array(np.ones(size)))
    for k in range(m):
        rows = size - k - 1
        D = scipy.sparse.csr_array(scipy.sparse.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(rows, rows + 1)) @ D)
    W = scipy.sparse.diags_array(np.tile(weight / 2, n - 1))
    return B, _band(scipy.sparse.csr_array(D.T @ (low.T @ W @ low) @ D), degree)


def _band(matrix: scipy.sparse.csr_array, width: int) -> Floats:
    """The lower band (width + 1, n) of a symmetric matrix."""
    n = matrix.shape[0]
    band = np.zeros((width + 1, n))
    for k in range(width + 1):
        band[k, : n - k] = matrix.diagonal(-k)
    return band


def _factor(data: Floats, omega: Floats, cutoff: float, m: int) -> Floats:
    p = (np.sqrt(2) - 1) * (2 * np.pi * cutoff) ** (-2.0 * m)  # (3)
    return scipy.linalg.cholesky_banded(data + p * omega, lower=True)  # (2)


def _cross_validated(
    B: scipy.sparse.csr_array, data: Floats, omega: Floats, target: Floats, y: Floats, seen: Bools, m: int
) -> float:
    """ν_c of the least (4) on the ladder, and between its neighbours by a parabola."""
    factors = np.array([_factor(data, omega, cutoff, m) for cutoff in CANDIDATES])
    fits = [B @ scipy.linalg.cho_solve_banded((factor, True), target) for factor in factors]
    rss = np.array([np.sum((fit[seen] - y[seen]) ** 2) for fit in fits])
    n = seen.sum()
    score = np.log(np.maximum(rss, np.finfo(float).tiny)) - 2 * np.log(np.maximum(n - _traces(factors, data), 1e-9))
    i = int(np.argmin(score))  # (4)
    if not 0 < i < len(CANDIDATES) - 1:
        return float(CANDIDATES[i])
    a, b, c = score[i - 1 : i + 2]
    shift = 0.5 * (a - c) / (a - 2 * b + c)
    return float(np.exp(np.log(CANDIDATES[i]) + shift * np.log(CANDIDATES[1] / CANDIDATES[0])))


def _traces(factors: Floats, data: Floats) -> Floats:
    """tr A (P) of (4) by (5), for Cholesky factors (P, w + 1, n) all at once."""
    P, width, n = factors.shape[0], factors.shape[1] - 1, factors.shape[2]
    d = factors[:, 0] ** 2
    low = factors[:, 1:] / factors[:, :1]
    Z = np.zeros((P, width, width))
    trace = np.zeros(P)
    for i in range(n - 1, -1, -1):
        row = -np.einsum("pk,pkj->pj", low[:, :, i], Z)  # (5)
        corner = 1 / d[:, i] - np.einsum("pk,pk->p", low[:, :, i], row)
        trace += corner * data[0, i] + 2 * row @ data[1:, i]
        Z[:, 1:, 1:] = Z[:, :-1, :-1].copy()
        Z[:, 0, 0], Z[:, 0, 1:], Z[:, 1:, 0] = corner, row[:, :-1], row[:, :-1]
    return trace
