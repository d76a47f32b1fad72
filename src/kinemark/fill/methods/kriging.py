"""Kriging in a local frame: the covariance of frames, how likely it is, what it leaves out, what it predicts.

A marker's local coordinates y (n, 3), less a mean, are known in n frames; φ says for every frame in which pose the
part about it is (`body`). With τ² in common the covariance of two frames t, t' of the sources s, s' (1: the mirrored
side) is

    k = λ P ρ^[s ≠ s'] + (M(|t − t'|/ℓ) + C) [s = s'] + ν δ                                               (1)
    P = κ φ·φ' + 1/(1 + η |φ − φ'|²/2),     φ = (pose, θ · turned) / √(1 + θ²)                            (2)

P lets f be linear and bend, in short and long waves (a rational quadratic, Rasmussen & Williams 2006, 4.19); θ says
how much it matters how the part is turned in space. M is Matérn's covariance (R & W 4.14) of order 3/2 or 7/2, once or
three times differentiable, which ties the fill to what is seen at the edges of the gap: smoothed data are smooth. C,
great, leaves the constant of each source free. With K over the frames learnt from and k of the frames wanted
(R & W 2.2, 2.7)

    τ² = yᵀK⁻¹y / n,     y* = kᵀK⁻¹y,     var y* = τ²(k* − kᵀK⁻¹k)                                        (3)

for each local coordinate, and ln p(y) = −½ n Σ ln τ² − ³⁄₂ ln|K| + const (R & W 5.8) (4). What a block b of the frames
learnt from would be missed by, were it predicted from the others, follows without solving again (R & W 5.12, for
blocks):

    y_b − y_b* = ([K⁻¹]_bb)⁻¹ [K⁻¹y]_b                                                                    (5)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ...data.array_types import Floats, Ints

ORDERS = (1.5, 3.5)  # ν of Matérn's covariance, without unit; chosen: once and three times differentiable


class Hyper(NamedTuple):
    """λ, ℓ in seconds, ν, ρ, κ, η and θ of (1) and (2), and the order of M."""

    lam: float = 50.0
    ell: float = 0.3
    nu: float = 0.01
    rho: float = 0.9
    kappa: float = 2.0
    eta: float = 3.0
    theta: float = 0.3
    order: float = 1.5


class FramePairs(NamedTuple):
    """What (1) asks of every pair of a frame (rows) and one learnt from (columns).

    Attributes:
        dot: (2, rows, columns) scalar products of the poses, and of how they are turned.
        rows, columns: (2, rows), (2, columns) the squares of both.
        apart: |t − t'|, s.
        own: how many rows and columns are of the marker's own source; they come first.
    """

    dot: Floats
    rows: Floats
    columns: Floats
    apart: Floats
    own: tuple[int, int]


class KrigingFit(NamedTuple):
    """What (3) needs: `Hyper`, log-likelihood (4), factor of K, K⁻¹y, τ² (3)."""

    hyper: Hyper
    likely: float
    factor: Floats
    weights: Floats
    tau2: Floats


def free(h: Hyper) -> float:
    """C of (1)."""
    return 10.0 * max(10.0, h.lam)


def parts(h: Hyper) -> Floats:
    """What the pose and how it is turned count for |φ|² (2)."""
    return np.array([1.0, h.theta**2]) / (1 + h.theta**2)


def covariance(pairs: FramePairs, h: Hyper) -> Floats:
    """(1), (2) without the noise."""
    share = parts(h)
    dot = share[0] * pairs.dot[0]
    dot += share[1] * pairs.dot[1]
    k = h.eta / 2 * np.add.outer(share @ pairs.rows, share @ pairs.columns)
    k -= h.eta * dot
    k += 1
    np.divide(h.lam, k, out=k)
    dot *= h.lam * h.kappa
    k += dot
    r, c = pairs.own
    k[:r, c:] *= h.rho
    k[r:, :c] *= h.rho
    for same in (np.s_[:r, :c], np.s_[r:, c:]):
        k[same] += matern(pairs.apart[same] / h.ell, h.order)
        k[same] += free(h)
    return k


def matern(r: Floats, order: float) -> Floats:
    """Matérn's covariance of one of `ORDERS` (R & W 4.16)."""
    x = np.sqrt(2 * order) * r
    out = np.exp(-x)
    out *= x + 1 if order == 1.5 else ((x / 15 + 0.4) * x + 1) * x + 1
    return out


def fit(pairs: FramePairs, y: Floats, h: Hyper) -> KrigingFit:
    """K⁻¹y, τ² and (4); the pairs are those of the n frames learnt from, y (n, 3)."""
    n = len(y)
    K = covariance(pairs, h)
    K.flat[:: n + 1] += h.nu
    factor, wrong = scipy.linalg.lapack.dpotrf(K, lower=True, clean=True)
    if wrong:
        raise np.linalg.LinAlgError("the covariance of the frames is not positive definite")
    weights = scipy.linalg.lapack.dpotrs(factor, y, lower=True)[0]
    tau2 = np.maximum((y * weights).sum(0) / n, 1e-8)  # (3)
    likely = -0.5 * n * np.log(tau2).sum() - 3 * np.log(np.diag(factor)).sum()  # (4)
    return KrigingFit(h, float(likely), factor, weights, tau2)


def left_out(found: KrigingFit, blocks: list[Ints]) -> float:
    """Mean distance, mm, by which frames are missed that are left out block by block (5).

    Args:
        found: the fit.
        blocks: the frames of each block.
    """
    half = scipy.linalg.lapack.dtrtri(found.factor, lower=True)[0]  # K⁻¹ is its square, of which blocks are needed
    apart: Floats = np.empty_like(found.weights)
    for size in {len(b) for b in blocks}:  # blocks of one size at once
        own = np.array([b for b in blocks if len(b) == size])
        columns = (half[b.min() :, b] for b in own)  # zero above
        apart[own] = np.linalg.solve(np.array([of.T @ of for of in columns]), found.weights[own])  # (5)
    return float(np.linalg.norm(apart[np.concatenate(blocks)], axis=1).mean())


def predict(pairs: FramePairs, found: KrigingFit) -> tuple[Floats, Floats]:
    """(3): what is expected (L, 3), and its variance (L, 3), in L frames."""
    h = found.hyper
    k = covariance(pairs, h)
    half = scipy.linalg.lapack.dtrtrs(found.factor, k.T, lower=True)[0]
    prior = h.lam * (h.kappa * parts(h) @ pairs.rows + 1) + 1 + free(h)
    left = np.maximum(prior - (half * half).sum(0), 1e-9)
    return k @ found.weights, left[:, None] * found.tau2
