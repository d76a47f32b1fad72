"""How far the lenses of a rig are from what is usual, and from each other, learned from all its cameras.

Terms with a prior (`lens_prior`), but those that images are to tell, are fitted with the others, to v with covariance
P, both in units of the prior's σ. It is wide enough for all kinds of cameras. Those of one rig are mostly of one make,
and may be nearer to what was taken: by a factor τ ≤ 1, one for each kind of terms (`KINDS`), of which the fit tells. Or
they are so near to each other, and their mean is as far from what was taken as is usual. One camera may be of another
make, with τ = 1. With the terms S z, z of unit covariance,

    S = (τ),   or   S = (τ, √(1 − τ²) E)                                 (1)

where τ is diagonal and E has a column of ones for all cameras' values of a term. What images alone say is a normal
matrix F = P⁻¹ − 1 and a right side b = P⁻¹ v, so that

    A = 1 + Sᵀ F S,   P_τ = S A⁻¹ Sᵀ,   v_τ = P_τ b,   p(S) ∝ |A|^(−1/2) exp(bᵀ v_τ / 2)      (2)

are the fit that S would have given and its probability (the evidence of MacKay 1992), where all of `SIZES`, both of
(1), and no camera or any as the odd one, are as likely beforehand. Over all of them

    v̄ = Σ p v_τ,   M = Σ p (P_τ + (v_τ − v̄)(v_τ − v̄)ᵀ)                   (3)

(Bayesian model averaging, Hoeting et al. 1999). The other parameters are fitted anew to v̄, and all have the covariance

    C + K (M − P) Kᵀ,   K = C Dᵀ P⁻¹                                      (4)

of C, as if v was free, D the derivatives of v and P = D C Dᵀ. So terms that no camera shows cost little accuracy, and
are uncertain only as far as all cameras together leave them open.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import scipy

from ...data import Camera
from ...data.array_types import Bools, Floats
from ...numerics.blas_threads import one_blas_thread
from .lens_prior import directions_of, values_of, with_values
from .parameter_covariance import joint_covariance
from .robust_adjustment import degrees_of_freedom
from .solver import BundleState, Freedom, ImageObservations, cost, normal_equations, solve

KINDS = np.array([0, 1, 1, 2, 2, 1])
"""Of `lens_prior` (1): the pixels' shape, radial terms, tangential terms; by definition."""
SIZES = 4.0 ** np.arange(-3, 1)
"""τ, without unit; chosen: from lenses that move images by less than their noise to all that is usual."""
UNLIKELY = 1e-6  # of the most probable τ; chosen: what is less does not count
NEAR = 1e-5  # share of the cost that the last fit may still fall by; chosen: far less than one standard deviation


def with_learned_terms(
    state: BundleState, seen: ImageObservations, freedoms: tuple[Freedom, ...], kept: Bools
) -> tuple[BundleState, Floats]:
    """The state with v̄ of (3), fitted to the points `kept` (C, N) again; and M, for images of unit variance."""
    seen = seen._replace(used=kept)
    covariance, gauge = joint_covariance(
        state, normal_equations(state, seen, freedoms), freedoms, np.asarray(kept.any(0))
    )
    s = np.sqrt(cost(state, seen, freedoms) / max(degrees_of_freedom(state, freedoms, kept) + gauge, 1))
    values = np.array([values_of(camera) for camera in state.cameras])
    usual = np.array([f.prior.usual if f.prior else x for f, x in zip(freedoms, values, strict=True)])
    precision = _precision(freedoms)
    known, D = precision > 0, _directions(state.cameras, freedoms)
    unit = s / np.sqrt(precision[known])
    mean, M = averaged((values - usual)[known] / unit, D @ covariance @ D.T, known)
    values[known] = usual[known] + mean * unit
    cameras = tuple(with_values(camera, x) for camera, x in zip(state.cameras, values, strict=True))
    held = tuple(freedom.held() for freedom in freedoms)
    return solve(state._replace(cameras=cameras), seen, held, tolerance=NEAR), M


@one_blas_thread()
def averaged(v: Floats, P: Floats, known: Bools) -> tuple[Floats, Floats]:
    """v̄ (n) and M (n, n) of (3), from v (n) and P (n, n) of those of all cameras' terms (C, 6) that are `known`."""
    F, b = np.linalg.inv(P) - np.eye(len(P)), np.linalg.solve(P, v).astype(np.float64)
    term = np.nonzero(known)[1]
    E = (term[:, None] == np.unique(term)).astype(np.float64)
    choices = list(product(possible_sizes(known), (E, E[:, :0])))
    p = scipy.special.softmax([_log_probability(F, b, _root(*choice)) for choice in choices])
    likely = np.flatnonzero(p > UNLIKELY * p.max())
    mean, square = np.zeros_like(v), np.zeros_like(P)
    for share, i in zip(p[likely] / p[likely].sum(), likely, strict=True):
        P_tau = _covariance(F, _root(*choices[i]))
        off = P_tau @ b - v
        mean, square = mean + share * off, square + share * (P_tau + np.outer(off, off))
    return v + mean, square - np.outer(mean, mean)


def possible_sizes(known: Bools) -> Floats:
    """(H, n) all that τ may be of the known terms, of cameras (C, 6): by kinds, and 1 in no camera or any one."""
    camera, term = np.nonzero(known)
    sizes = np.array(list(product(SIZES, repeat=int(KINDS.max()) + 1)))[:, KINDS[term]]
    odd = camera == np.arange(-1, len(known))[:, None]
    return np.where(odd[:, None], 1.0, sizes).reshape(-1, len(term))


def _root(size: Floats, E: Floats) -> Floats:
    """S (n, m) of (1)."""
    return np.column_stack([np.diag(size), np.sqrt(1 - size**2)[:, None] * E])


def _log_probability(F: Floats, b: Floats, S: Floats) -> float:
    """ln p of (2)."""
    L = np.linalg.cholesky(np.eye(S.shape[1]) + S.T @ F @ S)
    y = scipy.linalg.solve_triangular(L, S.T @ b, lower=True)
    return float(y @ y / 2 - np.log(np.diag(L)).sum())


def _covariance(F: Floats, S: Floats) -> Floats:
    """P_τ of (2)."""
    L = np.linalg.cholesky(np.eye(S.shape[1]) + S.T @ F @ S)
    B = scipy.linalg.solve_triangular(L, S.T, lower=True)
    return np.asarray(B.T @ B)


def covariance_with(
    covariance: Floats, M: Floats, cameras: tuple[Camera, ...], freedoms: tuple[Freedom, ...]
) -> Floats:
    """(4), from C (15 C, 15 C) and M (n, n)."""
    D = _directions(cameras, freedoms)
    P = D @ covariance @ D.T
    K = np.linalg.solve(P, D @ covariance).T
    return np.asarray(covariance + K @ (M - P) @ K.T)


def _precision(freedoms: tuple[Freedom, ...]) -> Floats:
    """(C, 6) of all cameras' terms to learn about, 0 of others."""
    return np.array([f.prior.precision * f.prior.learned if f.prior else np.zeros(6) for f in freedoms])


def _directions(cameras: tuple[Camera, ...], freedoms: tuple[Freedom, ...]) -> Floats:
    """D (n, 15 C): derivatives of all v."""
    root = np.sqrt(_precision(freedoms).ravel())
    D = scipy.linalg.block_diag(*[directions_of(camera) for camera in cameras])
    return np.asarray((root[:, None] * D)[root > 0])
