"""Delays that cameras of a calibrated rig still have, from what its points leave in images that move.

An image that moves by u̇ px an image, and is taken late by τ images, lies off its point by τ u̇, of which the point and
the cameras' parameters take up what they can. With D the columns u̇ and ∂u/∂θ of each camera, J = ∂u/∂X of a point
in the cameras that see it and Q = 1 − J (JᵀJ)⁻¹ Jᵀ, residuals r give

    (τ, θ) = (Σ DᵀQ D)⁻¹ Σ DᵀQ r                                         (1)

τ less what all cameras have in common, which no image shows. The recording is cut into blocks with scores
s_b = Σ DᵀQ (r − D (τ, θ)), and N⁻¹ (Σ s_b s_bᵀ) N⁻¹, N = Σ DᵀQ D, is the covariance (2) (White 1980).
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...geometry.camera import parameter_jacobian, point_jacobian
from ...numerics.evenly import evenly
from ..bundle import BundleFit

BLOCKS = 24
"""Of the points in time; chosen: in each the wand moves in all directions."""
SURE = 5.0
"""Standard deviations of a delay; chosen, as of trials (`track.simultaneous.times.time_offsets`)."""
MOST = 2000
"""Points that are looked at, evenly; chosen for memory: they tell delays to some ten thousandths of an image."""
LEAST_PX = 0.1
"""By which a delay moves images on the median; chosen: centroids are as good."""
FAINT = 1e-9
"""Of unknowns that nothing tells, added to N after scaling; chosen for rounding."""


def left_delays(fit: BundleFit, flow: Floats) -> Floats:
    """By how many images (C) cameras are late still, by (1); 0 where by (2) that is chance, or moves nothing.

    Args:
        fit: with N points.
        flow: (C, N, 2) px by which the images of the points move from image to image, NaN where not known.
    """
    C = len(fit.rig)
    used = fit.kept & np.isfinite(flow).all(-1) & np.isfinite(fit.residual).all(-1)
    at = np.flatnonzero(used.sum(0) >= 2)
    if len(at) < BLOCKS * C:
        return np.zeros(C)
    at = at[evenly(len(at), MOST)]
    used = used[:, at]
    D, r, scale = _columns(fit, flow, used, at)
    N = D.T @ D + FAINT * np.eye(D.shape[1])
    own = np.arange(C) * (D.shape[1] // C)
    N[np.ix_(own, own)] += 1.0 / np.outer(scale[own], scale[own]) * (scale[own] ** 2).mean()  # in common they are 0
    inverse = np.linalg.inv(N)
    found = inverse @ (D.T @ r)
    by_image = (D * (r - D @ found)[:, None]).reshape(C, len(at), 2, -1)
    scores = np.add.reduceat(by_image.sum((0, 2)), np.arange(BLOCKS) * len(at) // BLOCKS)  # (2)
    sd = np.sqrt(np.diag(inverse @ scores.T @ scores @ inverse))[own] / scale[own]
    late = found[own] / scale[own]
    late = late - np.sort(late)[(C - 1) // 2]
    speed = np.array([np.median(np.linalg.norm(flow[c, at[seen]], axis=1)) for c, seen in enumerate(used)])
    return np.where((np.abs(late) > SURE * sd) & (np.abs(late) * speed > LEAST_PX), late, 0.0)


def _columns(fit: BundleFit, flow: Floats, used: Bools, at: Ints) -> tuple[Floats, Floats, Floats]:
    """√Q D (2 C n, C K), its columns of unit length, √Q r, and the lengths, of images `used` (C, n) of `at` (n)."""
    C, n, free = len(fit.rig), len(at), [np.flatnonzero(np.diag(camera.cov) > 0) for camera in fit.rig]
    K = 1 + max(map(len, free))
    D, J = np.zeros((C, n, 2, C, K)), np.zeros((C, n, 2, 3))
    for c, camera in enumerate(fit.rig):
        seen, xyz = used[c], fit.xyz[at[used[c]]]
        D[c, seen, :, c, 0] = flow[c, at[seen]]
        D[c, seen, :, c, 1 : 1 + len(free[c])] = parameter_jacobian(camera, xyz)[..., free[c]]
        J[c, seen] = point_jacobian(camera, xyz)
    residual = np.where(used[..., None], fit.residual[:, at], 0.0)
    rows = _by_point(np.concatenate([D.reshape(C, n, 2, C * K), residual[..., None]], -1))
    taken = np.linalg.qr(_by_point(J))[0]
    rows -= taken @ (np.swapaxes(taken, 1, 2) @ rows)  # Q is its own square
    rows = rows.reshape(n, C, 2, -1).transpose(1, 0, 2, 3).reshape(2 * C * n, -1)
    scale = np.maximum(np.linalg.norm(rows[:, :-1], axis=0), FAINT)
    return rows[:, :-1] / scale, rows[:, -1], scale


def _by_point(each: Floats) -> Floats:
    """(n, 2 C, …) of (C, n, 2, …)."""
    return np.ascontiguousarray(np.moveaxis(each, 0, 1)).reshape(each.shape[1], 2 * len(each), -1)
