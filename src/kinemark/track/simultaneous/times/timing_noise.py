"""By how much the times of a camera's images are uncertain, from the disagreement of images in motion.

An image that is taken at a time of standard deviation τ about its own lies off by a length along the flow f, the
velocity of the marker in the image, of variance τ² |f|², while centroids are off by σ² in any direction. Beside the
delays and what the calibration leaves (`timing_fit`), images are off by e = Q off, Q = 1 − J H⁻¹ Jᵀ what a point
leaves. With Q_ck its part of cameras c and k and u the direction of f,

    E (u_cᵀ e_c)² = Σ_k τ_k² (u_cᵀ Q_ck f_k)² + Σ_k σ_k² |u_cᵀ Q_ck|²
    E |e_c|²      = Σ_k τ_k² |Q_ck f_k|²      + Σ_k σ_k² |Q_ck|²                           (1)

are two equations a camera that are linear in τ² and σ², summed over the points with the squares of their weights
(MINQUE; Rao 1971), and standard
errors by the jackknife. Flickering frame times, lost and repeated images, and motion within an exposure are such.
"""

from __future__ import annotations

import numpy as np

from ....data.array_types import Bools, Floats
from .timing_fit import PARTS, Moving, TimingFit


def timing_noise(moving: Moving, fit: TimingFit) -> tuple[Floats, Floats]:
    """τ² (C) by (1), frames², and its standard error; below 0 where there is none, NaN of cameras without motion."""
    A, b = _equations(moving, fit)
    C = moving.off.shape[1]
    seen = np.diag(A.sum(0))[:C] > 0
    both = np.tile(seen, 2)
    sums = [(A.sum(0), b.sum(0))] + [(A.sum(0) - A[j], b.sum(0) - b[j]) for j in range(PARTS)]
    found = np.full((1 + PARTS, C), np.nan)
    for row, (left, right) in zip(found, sums, strict=True):
        row[seen] = np.linalg.lstsq(left[np.ix_(both, both)], right[both], rcond=1e-8)[0][: seen.sum()]
    return found[0], found[1:].std(0) * np.sqrt(PARTS - 1)


def _equations(moving: Moving, fit: TimingFit) -> tuple[Floats, Floats]:
    """Both sides (PARTS, 2 C, 2 C) and (PARTS, 2 C) of (1)."""
    C = moving.off.shape[1]
    A, b = np.zeros((PARTS, 2 * C, 2 * C)), np.zeros((PARTS, 2 * C))
    for j, part in enumerate(moving.parts):
        own = part.start + np.flatnonzero(fit.loose[part] > 0)
        J, f, e, weight = moving.J[own], moving.flow[own], fit.left[own], fit.loose[own] ** 2
        Q = _what_a_point_leaves(J, moving.seen[own])
        speed = np.linalg.norm(f, axis=-1, keepdims=True)
        u = np.divide(f, speed, out=np.zeros_like(f), where=speed > 0)
        along, moved = np.einsum("nci,ncikj->nckj", u, Q), np.einsum("ncikj,nkj->ncik", Q, f)
        A[j] = np.block(
            [
                [_sum(weight, np.einsum("nckj,nkj->nck", along, f) ** 2), _sum(weight, (along**2).sum(-1))],
                [_sum(weight, (moved**2).sum(2)), _sum(weight, (Q**2).sum((2, 4)))],
            ]
        )
        b[j] = np.concatenate([weight @ (u * e).sum(-1) ** 2, weight @ (e**2).sum(-1)])
    return A, b


def _what_a_point_leaves(J: Floats, seen: Bools) -> Floats:
    """Q (N, C, 2, C, 2) of (1), 0 where unseen."""
    N, C = seen.shape
    flat = J.reshape(N, 2 * C, 3)
    through = flat @ np.linalg.solve(flat.swapaxes(1, 2) @ flat, flat.swapaxes(1, 2))
    unit = np.eye(2 * C) * np.repeat(seen, 2, axis=1)[..., None]
    return np.asarray((unit - through).reshape(N, C, 2, C, 2))


def _sum(weight: Floats, terms: Floats) -> Floats:
    """(C, C) the weighted sum of terms (N, C, C)."""
    return np.asarray(np.tensordot(weight, terms, 1))
