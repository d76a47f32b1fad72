"""Filter and smoother of the three-state model (Kalman 1960; Rauch, Tung & Striebel 1965), for many sequences at once.

The model is that of `kalman`, one coordinate a sequence, in units of frames:

    x(k+1) = F x(k) + w(k),  F = [1 1 ½; 0 1 1; 0 0 1],  E[w wᵀ] = Q = diag(0, 0, U²)             (1)
    y(k) = C x(k) + v(k),    C = [1 0 0],                E[v²] = σ²                               (2)

Only the position is measured here. Velocity and acceleration by differences, which the thesis counts as measured too,
share the errors of the positions, so that a covariance that takes them for independent is too small. The filter is

    P⁻ = F P Fᵀ + Q,  x⁻ = F x                                                                    (3)
    K = P⁻ Cᵀ (C P⁻ Cᵀ + σ²)⁻¹,  x = x⁻ + K (y − C x⁻),  P = (I − K C) P⁻ (I − K C)ᵀ + σ² K Kᵀ        (4)

where nothing is measured K = 0. The smoother goes back from the last frame:

    J = P Fᵀ (P⁻₊)⁻¹,  x̂ = x + J (x̂₊ − x⁻₊),  P̂ = P + J (P̂₊ − P⁻₊) Jᵀ                               (5)

with ₊ the next frame. A sequence begins at its first sample, with velocity and acceleration all but unknown (6):
their standard deviation is ten times the sequence's greatest first and second difference; and 10⁻⁷ of that is the
least σ, for the sake of the numbers. The third difference of the positions of (1) is (w(k) + w(k+1)) / 2, the same
forwards and backwards, so the smoother is symmetric in time.

U and σ from the data. Δₕ³ is the third difference of samples h frames apart. For an acceleration that walks at random
it has the variance U² h⁵ ∫ B² with B the quadratic spline of unit knots, ∫ B² = 11/20, and errors of measurement add
(1 + 9 + 9 + 1) σ²:

    E[(Δₕ³ y)²] = 11/20 · h⁵ U² + 20 σ²                                                          (7)

The acceleration of a body does not walk at random: over long times it comes back, and U by (7) falls with h. The
state at the edge of a gap hangs on the short times; h of a twentieth of a second makes predictions of half a second
as far off as foretold (8). Over one and two frames motion is smooth, Δₕ³ ~ h³:

    20 σ² = (64 E[(Δ₁³ y)²] − E[(Δ₂³ y)²]) / 63                                                   (9)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .kalman import F

Floats = NDArray[np.float64]

LEAST_SD = 0.01
"""No position is known better than this, mm."""


class Smoothed(NamedTuple):
    """n sequences over W frames: x (n, W, 3) position, velocity a frame, acceleration a frame²; P (n, W, 3, 3)."""

    x: Floats
    P: Floats


class Filtered(NamedTuple):
    """What the filter knows of n sequences in W frames.

    x, P: with the sample of the frame, as in `Smoothed`; x_before, P_before: without it. NaN before a sequence begins.
    """

    x: Floats
    P: Floats
    x_before: Floats
    P_before: Floats


def filter_positions(y: Floats, *, sd: Floats, jump: Floats) -> Filtered:
    """(1) to (4), forwards.

    Args:
        y: (n, W) positions, mm; NaN where nothing was measured.
        sd: (n) σ, mm.
        jump: (n) U, mm/frame².

    Returns:
        One prediction a frame; for a sequence without any sample all NaN.
    """
    n, n_frames = y.shape
    x, P = np.full((n_frames, n, 3), np.nan), np.full((n_frames, n, 3, 3), np.nan)
    x_before, P_before = x.copy(), P.copy()
    seen = ~np.isnan(y)
    begin = np.where(seen.any(1), seen.argmax(1), n_frames)
    unknown = _unknown(y, sd)
    sd = np.maximum(sd, 1e-7 * unknown.max(1))
    for k in range(n_frames):
        if k:
            x_before[k] = x[k - 1] @ F.T  # (3)
            P_before[k] = F @ P[k - 1] @ F.T
            P_before[k, :, 2, 2] += jump**2
        x[k], P[k] = _measured(x_before[k], P_before[k], y[:, k], sd)
        new = begin == k
        x[k, new] = np.stack([y[new, k], 0 * y[new, k], 0 * y[new, k]], -1)
        P[k, new] = np.eye(3) * np.column_stack([sd, unknown])[new, None] ** 2  # (6)
    return Filtered(*(np.ascontiguousarray(a.swapaxes(0, 1)) for a in (x, P, x_before, P_before)))


def _unknown(y: Floats, sd: Floats) -> Floats:
    """(n, 2) of (6): what velocity and acceleration may be at the beginning."""
    steps = [np.abs(np.diff(y, k, axis=1)) for k in (1, 2)]
    most = [np.max(np.nan_to_num(step), axis=1, initial=0.0) for step in steps]
    return 10 * np.maximum(np.stack(most, -1), sd[:, None])


def _measured(x: Floats, P: Floats, y: Floats, sd: Floats) -> tuple[Floats, Floats]:
    """(4) for n sequences in one frame."""
    seen = ~np.isnan(y)
    K = np.where(seen[:, None], P[..., 0] / (P[:, 0, 0] + sd**2)[:, None], 0.0)
    x = x + K * np.where(seen, y - x[:, 0], 0.0)[:, None]
    keep = np.eye(3) - K[..., None] * np.array([1.0, 0.0, 0.0])
    P = keep @ P @ keep.swapaxes(1, 2) + (sd**2)[:, None, None] * K[..., None] * K[:, None]
    return x, (P + P.swapaxes(1, 2)) / 2


def smooth_positions(y: Floats, *, sd: Floats, jump: Floats) -> Smoothed:
    """(5): what all samples of a sequence say of each frame from its first sample on; arguments as
    `filter_positions`."""
    found = filter_positions(y, sd=sd, jump=jump)
    x, P = found.x.copy(), found.P.copy()
    for k in range(y.shape[1] - 2, -1, -1):
        on = ~np.isnan(found.P[:, k, 0, 0])
        P_next = found.P_before[on, k + 1]
        J = _gain(P_next, jump[on])
        x[on, k] += (J @ (x[on, k + 1] - found.x_before[on, k + 1])[..., None])[..., 0]
        P[on, k] += J @ (P[on, k + 1] - P_next) @ J.swapaxes(1, 2)
    return Smoothed(x, (P + P.swapaxes(2, 3)) / 2)


def _gain(P: Floats, jump: Floats) -> Floats:
    """J (n, 3, 3) of (5) from P⁻₊ (n, 3, 3): as P Fᵀ = F⁻¹ (P⁻₊ − Q), J = F⁻¹ (I − Q (P⁻₊)⁻¹), and of the inverse only
    the last row counts."""
    a, b, c, d, e = P[:, 0, 0], P[:, 0, 1], P[:, 0, 2], P[:, 1, 1], P[:, 1, 2]
    row = np.stack([b * e - c * d, b * c - a * e, a * d - b * b], -1)
    row *= (jump**2 / np.einsum("ni,ni->n", row, P[:, 2]))[:, None]
    rest = np.broadcast_to(np.eye(3), P.shape).copy()
    rest[:, 2] -= row
    return np.linalg.inv(F) @ rest


def third_difference(y: Floats, stride: int) -> Floats:
    """(n) the mean square of Δₕ³ of sequences y (n, W), NaN where no four samples h frames apart are there."""
    if y.shape[1] <= 3 * stride:
        return np.full(len(y), np.nan)
    a, b, c, d = (y[:, k * stride : y.shape[1] - (3 - k) * stride] for k in range(4))
    jumps = d - 3 * c + 3 * b - a
    there = ~np.isnan(jumps)
    total = np.where(there, jumps, 0.0)
    return np.where(there.any(1), (total**2).sum(1) / np.maximum(there.sum(1), 1), np.nan)


def noise_of(y: Floats) -> Floats:
    """(n) σ by (9), mm; `LEAST_SD` where it is less, or where there are too few samples to tell."""
    one, two = third_difference(y, 1), third_difference(y, 2)
    variance = (64 * one - two) / (63 * 20)
    return np.sqrt(np.fmax(np.nan_to_num(variance, nan=0.0), LEAST_SD**2))


def jump_of(y: Floats, stride: int, sd: Floats) -> Floats:
    """(n) U by (7) with h of `stride` frames, mm/frame²; with a shorter one where samples do not reach."""
    jump = np.full(len(y), np.nan)
    while stride >= 1 and np.isnan(jump).any():
        square = (third_difference(y, stride) - 20 * sd**2) * 20 / (11 * float(stride) ** 5)
        least = (0.01 * sd) ** 2 / float(stride) ** 5
        jump = np.where(np.isnan(jump), np.sqrt(np.maximum(square, least)), jump)
        stride //= 2
    return np.where(np.isnan(jump), sd, jump)
