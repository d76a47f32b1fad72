"""Delays of cameras fitted to the images of points in motion, beside what their calibration leaves.

Of N points seen by C cameras, `off` is by how much images lie off the projections of the points, J = ∂u/∂X, and D the
columns (N, C, 2, K) by which each of K unknowns of each camera moves its own image. The points move too, so with
H = Σ JᵀJ over the cameras of a point

    θ = (Σ w (DᵀD − DᵀJ H⁻¹ JᵀD) + Λ)⁻¹ Σ w (Dᵀ off − DᵀJ H⁻¹ Jᵀ off)                   (1)

The first columns are those that are looked for, the flow D₁ = J v and its multiples. The others are what a calibration
that is off does: an entry of the projection P, with X homogeneous from the middle of the points in units of their
spread, w̄ / w their mean depth over their own, and (x, y) from the middle of the image in half widths, moves it by

    δu = X w̄ / w,   δv = X w̄ / w,   δ(u, v) = −(x, y) X w̄ / w                             (2)

and a lens by (x, y) |(x, y)|² (3). Of these Λ knows that they are a few px (4), nothing of the delays. Points weigh

    w = 1 / (σ² + τ² |flow|²)                                                             (5)

as what moves fast is off by delays that are not yet known. σ is learned from slow points and τ from fast ones, in
rounds, and a point that is off by OUTLIER of these standard deviations belongs to something else.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints

PARTS = 10
"""Parts of the recording for standard errors; chosen (see benchmarks/tracking.py)."""

ROUNDS = 3
"""Of (5); chosen: a fourth changes σ and τ by some per cent."""

OUTLIER = 4.0
"""Standard deviations of (5); chosen."""

LOOSE = 2.0
"""Of OUTLIER; chosen: with one camera of uneven times, its standard deviation was found a third too small within it."""

SLOW, FAST = 0.33, 0.8
"""Quantiles of speed in px: below the first a point is slow, above the second fast; chosen."""

MEDIAN_OF_CHI2 = 0.6
"""Of χ² of 3 degrees of freedom over 3, the median, near to that of others; by definition: 2.366 / 3, and 0.455 of one,
between which points of three and of two cameras lie."""

USUAL_ERROR = 3.0
"""px, the standard deviation of (2) and (3) by (4); chosen: calibrations are 0.03 to 1.5 px off, and more at a side."""

MIN_TAU2 = 1e-6
"""Frames², the least of τ²; chosen: less moves nothing."""

MIN_SIGMA2 = 1e-4
"""px², the least of σ²; chosen: no centroid is better."""


class Moving(NamedTuple):
    """N points in motion, 0 where unseen: J (N, C, 2, 3) px/mm, off and flow (N, C, 2) px and px a frame; y (N, C) from
    −1 to 1 down the image; frame (N); seen (N, C); calibration (N, C, 2, 12), the columns (2) and (3), px."""

    J: Floats
    off: Floats
    flow: Floats
    y: Floats
    frame: Ints
    seen: Bools
    calibration: Floats

    @property
    def parts(self) -> list[slice]:
        """Their PARTS parts, equally long in time."""
        first = np.searchsorted(self.frame, np.linspace(0, self.frame[-1] + 1, PARTS + 1))
        return [slice(*pair) for pair in pairwise(first.tolist())]


class TimingFit(NamedTuple):
    """By (1).

    Attributes:
        theta: (C, n) of the n columns that were looked for; without: (PARTS, C, n) the same without one part.
        left: (N, C, 2) px, what images are off beside it, as seen from the points.
        weight: (N) of (5), 1/px², 0 for outliers; loose: (N) the same, 0 for those that are LOOSE times farther off, as
            uneven times have heavy tails in all points together.
        fast: px, the usual residual of points in fast motion.
    """

    theta: Floats
    without: Floats
    left: Floats
    weight: Floats
    loose: Floats
    fast: float


def calibration_columns(xyz: Floats, depth: Floats, uv: Floats, size: Floats) -> Floats:
    """(N, C, 2, 12) by (2) and (3) of points (N, 3) mm at depths (N, C) mm, seen at uv (N, C, 2) in images of sizes
    (C, 2) px."""
    from_middle = xyz - xyz.mean(0)
    spread = np.sqrt((from_middle**2).sum(1).mean()) + np.finfo(float).tiny
    X = np.column_stack([np.ones(len(xyz)), from_middle / spread])[:, None] * (depth.mean(0) / depth)[..., None]
    at = (uv - size / 2) / (size[:, :1] / 2)
    out = np.zeros((*uv.shape, 12))
    out[:, :, 0, 0:4] = out[:, :, 1, 4:8] = X
    out[..., 8:11] = -at[..., None] * X[:, :, None, 1:]
    out[..., 11] = at * (at**2).sum(-1, keepdims=True)
    return out


def timing_fit(moving: Moving, wanted: Floats) -> TimingFit:
    """The fit (1) of the columns wanted (N, C, 2, n)."""
    n = wanted.shape[-1]
    D = np.concatenate([wanted, moving.calibration], -1)
    count = moving.seen.sum(1)
    speed = np.sqrt((moving.flow**2).sum((1, 2)) / count)
    L = np.linalg.inv(np.linalg.cholesky((moving.J.swapaxes(2, 3) @ moving.J).sum(1)))
    LJ = moving.J @ L.swapaxes(1, 2)[:, None]  # H⁻¹ = LᵀL
    left = off_beside_points(moving.off, LJ)
    for _ in range(ROUNDS):
        squared = (left**2).sum((1, 2)) / (2 * count - 3)
        variance = _variance(squared, speed)
        weight = np.where(squared < OUTLIER**2 * variance, 1 / variance, 0.0)
        A, b = _normal_equations(moving, D, LJ, weight)
        theta = _solution(A.sum(0), b.sum(0), n)
        left = off_beside_points(moving.off - (D @ theta[..., None])[..., 0], LJ)
    without = np.array([_solution(A.sum(0) - A[j], b.sum(0) - b[j], n) for j in range(PARTS)])
    squared = (left**2).sum((1, 2)) / (2 * count - 3)
    loose = np.where(squared < (LOOSE * OUTLIER) ** 2 * variance, 1 / variance, 0.0)
    fast = float(np.sqrt(np.median(squared[speed >= np.quantile(speed, FAST)]) / MEDIAN_OF_CHI2))
    return TimingFit(theta[:, :n], without[..., :n], left, weight, loose, fast)


def off_beside_points(off: Floats, LJ: Floats) -> Floats:
    """(N, C, 2) px of what images are off (N, C, 2), less what a point of LJ (N, C, 2, 3) that moves takes away."""
    return np.asarray(off - np.einsum("ncij,nj->nci", LJ, np.einsum("ncij,nci->nj", LJ, off)))


def _variance(squared: Floats, speed: Floats) -> Floats:
    """(N) px², that of (5), from squared (N) px² a degree of freedom and speeds (N) px a frame."""
    slow, fast = (speed <= np.quantile(speed, SLOW)), (speed >= np.quantile(speed, FAST)) & (speed > 0)
    sigma2 = max(float(np.median(squared[slow])) / MEDIAN_OF_CHI2, MIN_SIGMA2)
    tau2 = float(np.median(squared[fast] / speed[fast] ** 2)) / MEDIAN_OF_CHI2 if fast.any() else 0.0
    return np.asarray(sigma2 + max(tau2, MIN_TAU2) * speed**2)


def _normal_equations(moving: Moving, D: Floats, LJ: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """The sums (PARTS, C K, C K) and (PARTS, C K) of (1) over each part of the recording."""
    N, C, _, K = D.shape
    root = np.sqrt(weight)
    own, off = D * root[:, None, None, None], moving.off * root[:, None, None]
    through = (LJ.swapaxes(2, 3) @ own).swapaxes(1, 2).reshape(N, 3, C * K)
    point = np.einsum("ncij,nci->nj", LJ, off)
    A, b = np.zeros((PARTS, C * K, C * K)), np.zeros((PARTS, C * K))
    for j, part in enumerate(moving.parts):
        some = through[part].reshape(-1, C * K)
        A[j], b[j] = -some.T @ some, -some.T @ point[part].ravel()
        for c in range(C):
            one, columns = own[part, c].reshape(-1, K), slice(c * K, (c + 1) * K)
            A[j, columns, columns] += one.T @ one
            b[j, columns] += one.T @ off[part, c].ravel()
    return A, b


def _solution(A: Floats, b: Floats, n: int) -> Floats:
    """(C, K) by (1), the first n columns of each camera without a prior; NaN of cameras that saw nothing move."""
    K = n + 12
    index = np.arange(len(b)).reshape(-1, K)
    t, rest = index[:, :n].T.ravel(), index[:, n:].ravel()
    known = A[np.ix_(rest, rest)] + np.eye(len(rest)) / USUAL_ERROR**2  # (4)
    through = np.linalg.solve(known, np.column_stack([A[np.ix_(rest, t)], b[rest]]))
    normal, pull = A[np.ix_(t, t)] - A[np.ix_(t, rest)] @ through[:, :-1], b[t] - A[np.ix_(t, rest)] @ through[:, -1]
    found = np.linalg.pinv(normal, rcond=1e-6, hermitian=True) @ pull
    theta = np.empty(len(b))
    theta[rest], theta[t] = through[:, -1] - through[:, :-1] @ found, found
    return theta.reshape(-1, K)
