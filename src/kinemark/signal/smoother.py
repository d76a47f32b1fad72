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
as far off as predicted (8). Over one and two frames motion is smooth, Δₕ³ ~ h³:

    20 σ² = (64 E[(Δ₁³ y)²] − E[(Δ₂³ y)²]) / 63                                                   (9)

Across a gap (3) has a closed form, and so has (5). From the last sample before it, t frames on,

    x⁻(t) = Fᵗ x,  P⁻(t) = Fᵗ P Fᵗᵀ + U² Σ_j v(j) v(j)ᵀ,   v(j) = (j²/2, j, 1),  j = 0 … t − 1     (10)
    x̂(t) = x⁻(t) + J (x̂₊ − x⁻₊),   P̂(t) = P⁻(t) + J (P̂₊ − P⁻₊) Jᵀ,   J = P⁻(t) Fˢᵀ (P⁻₊)⁻¹        (11)

where ₊ is now the first frame after the gap, s frames after t.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints
from .kalman import F

State = tuple[Floats, Floats]

LEAST_SD = 0.01
"""No position is known better than this, mm; chosen."""


class SmoothedStates(NamedTuple):
    """n sequences over W frames: x (n, W, 3) position, velocity a frame, acceleration a frame²; P (n, W, 3, 3)."""

    x: Floats
    P: Floats


class FilteredStates(NamedTuple):
    """What the filter knows of n sequences in W frames.

    x, P: with the sample of the frame, as in `SmoothedStates`; x_before, P_before: without it. NaN before a sequence
    begins.
    """

    x: Floats
    P: Floats
    x_before: Floats
    P_before: Floats


class GapPositions(NamedTuple):
    """Of the frames of one gap: x (L) mm and its variance (L) mm²."""

    x: Floats
    variance: Floats


def filter_positions(y: Floats, *, sd: Floats, process_sd: Floats) -> FilteredStates:
    """(1) to (4), forwards.

    Args:
        y: (n, W) positions, mm; NaN where nothing was measured.
        sd: (n) σ, mm.
        process_sd: (n) U, mm/frame².

    Returns:
        One prediction a frame; for a sequence without any sample all NaN.
    """
    unknown = _initial_sd(y, sd)
    return _filter(y, np.maximum(sd, 1e-7 * unknown.max(1)), process_sd, unknown)


def _filter(y: Floats, sd: Floats, process_sd: Floats, unknown: Floats, before: State | None = None) -> FilteredStates:
    """(1) to (4) from the first sample on; from the first frame where it is known what is `before` its sample."""
    n, n_frames = y.shape
    x, P = np.full((n_frames, n, 3), np.nan), np.full((n_frames, n, 3, 3), np.nan)
    x_before, P_before = x.copy(), P.copy()
    seen = ~np.isnan(y)
    begin = np.where(seen.any(1), seen.argmax(1), n_frames)
    if before is not None:
        (x_before[0], P_before[0]), begin = before, np.full(n, -1)
    for k in range(n_frames):
        if k:
            x_before[k] = x[k - 1] @ F.T  # (3)
            P_before[k] = F @ P[k - 1] @ F.T
            P_before[k, :, 2, 2] += process_sd**2
        x[k], P[k] = _updated(x_before[k], P_before[k], y[:, k], sd)
        new = begin == k
        x[k, new] = np.stack([y[new, k], 0 * y[new, k], 0 * y[new, k]], -1)
        P[k, new] = np.eye(3) * np.column_stack([sd, unknown])[new, None] ** 2  # (6)
    return FilteredStates(*(np.ascontiguousarray(a.swapaxes(0, 1)) for a in (x, P, x_before, P_before)))


def _initial_sd(y: Floats, sd: Floats) -> Floats:
    """(n, 2) of (6): what velocity and acceleration may be at the beginning."""
    steps = [np.abs(np.diff(y, k, axis=1)) for k in (1, 2)]
    most = [np.max(np.nan_to_num(step), axis=1, initial=0.0) for step in steps]
    return 10 * np.maximum(np.stack(most, -1), sd[:, None])


def _updated(x: Floats, P: Floats, y: Floats, sd: Floats) -> tuple[Floats, Floats]:
    """(4) for n sequences in one frame."""
    seen = ~np.isnan(y)
    K = np.where(seen[:, None], P[..., 0] / (P[:, 0, 0] + sd**2)[:, None], 0.0)
    x = x + K * np.where(seen, y - x[:, 0], 0.0)[:, None]
    keep = np.eye(3) - K[..., None] * np.array([1.0, 0.0, 0.0])
    P = keep @ P @ keep.swapaxes(1, 2) + (sd**2)[:, None, None] * K[..., None] * K[:, None]
    return x, (P + P.swapaxes(1, 2)) / 2


def smooth_positions(y: Floats, *, sd: Floats, process_sd: Floats) -> SmoothedStates:
    """(5): what all samples of a sequence say of each frame from its first sample on; arguments as
    `filter_positions`."""
    return _smooth(filter_positions(y, sd=sd, process_sd=process_sd), process_sd)


def _smooth(found: FilteredStates, process_sd: Floats) -> SmoothedStates:
    """(5) for what the filter found."""
    x, P = found.x.copy(), found.P.copy()
    for k in range(x.shape[1] - 2, -1, -1):
        on = ~np.isnan(found.P[:, k, 0, 0])
        P_next = found.P_before[on, k + 1]
        J = _gain(P_next, process_sd[on])
        x[on, k] += (J @ (x[on, k + 1] - found.x_before[on, k + 1])[..., None])[..., 0]
        P[on, k] += J @ (P[on, k + 1] - P_next) @ J.swapaxes(1, 2)
    return SmoothedStates(x, (P + P.swapaxes(2, 3)) / 2)


def predict_gaps(before: Floats, length: Ints, *, sd: Floats, process_sd: Floats) -> list[GapPositions]:
    """(10): what the samples before a gap say of the frames in it.

    Args:
        before: (n, W) positions up to the gap, mm; NaN where nothing was measured.
        length: (n) frames of the gap.
        sd, process_sd: as in `filter_positions`.

    Returns:
        Position mm and its variance mm², (length) each, a sequence; NaN for one without samples.
    """
    last = filter_positions(before, sd=sd, process_sd=process_sd)
    known = zip(last.x[:, -1], last.P[:, -1], process_sd, length, strict=True)
    return [
        GapPositions(_transition_rows(n) @ x, _covariance_row(P, u, _transition_rows(n))[:, 0]) for x, P, u, n in known
    ]


def smooth_gaps(before: Floats, after: Floats, length: Ints, *, sd: Floats, process_sd: Floats) -> list[GapPositions]:
    """(11): what the samples on both sides of a gap say of the frames in it, as `smooth_positions` does it.

    Args:
        before: (n, W) positions up to the gap, mm; NaN where nothing was measured.
        after: (n, W') positions from the gap on.
        length, sd, process_sd: as in `predict_gaps`.

    Returns:
        As `predict_gaps`; NaN for a sequence without samples before the gap.
    """
    unknown = np.maximum(_initial_sd(before, sd), _initial_sd(after, sd))
    sd = np.maximum(sd, 1e-7 * unknown.max(1))
    last = _filter(before, sd, process_sd, unknown)
    x, P = last.x[:, -1], last.P[:, -1]
    x_first, P_first = _after_gaps(x, P, process_sd, length)
    found = _smooth(_filter(after, sd, process_sd, unknown, (x_first, P_first)), process_sd)
    scale = np.sqrt(np.diagonal(P_first, axis1=1, axis2=2))
    scale = scale[:, :, None] * scale[:, None, :]
    inverse = np.linalg.inv(P_first / scale) / scale
    difference, less = found.x[:, 0] - x_first, found.P[:, 0] - P_first
    out = []
    for k, n in enumerate(length):
        row = _transition_rows(n)
        r = _covariance_row(P[k], process_sd[k], row)
        J = _by_transition(r, row[::-1]) @ inverse[k]
        out.append(
            GapPositions(row @ x[k] + J @ difference[k], np.maximum(r[:, 0] + ((J @ less[k]) * J) @ np.ones(3), 0.0))
        )
    return out


def _transition_rows(n: int) -> Floats:
    """(n, 3) the first row of Fᵗ for t = 1 … n."""
    return np.arange(1.0, n + 1)[:, None] ** np.arange(3) / np.array([1, 1, 2])


def _covariance_row(P: Floats, process_sd: float, row: Floats) -> Floats:
    """(n, 3) the first row of P⁻(t) of (10), from the first row of Fᵗ."""
    return _by_transition(row @ P, row) + process_sd**2 * _process_cov(row[:, 1])[:, 0]


def _after_gaps(x: Floats, P: Floats, process_sd: Floats, length: Ints) -> State:
    """(10) in the first frame after gaps: (n, 3) and (n, 3, 3)."""
    t = np.asarray(length, np.float64) + 1
    row = np.stack([np.ones(len(t)), t, t * t / 2], -1)
    P = _by_transition(_by_transition(P, row[:, None]).mT, row[:, None])
    return _by_transition(x, row), P + process_sd[:, None, None] ** 2 * _process_cov(t)


def _by_transition(a: Floats, row: Floats) -> Floats:
    """a Fᵗᵀ for rows a (…, 3), from the first row (…, 3) of Fᵗ."""
    out = np.array(np.broadcast_to(a, np.broadcast_shapes(a.shape, row.shape)))
    out[..., 0] += row[..., 1] * a[..., 1] + row[..., 2] * a[..., 2]
    out[..., 1] += row[..., 1] * a[..., 2]
    return out


def _process_cov(t: Floats) -> Floats:
    """Σ_j v(j) vᵀ(j) of (10): (…, 3, 3)."""
    n = t - 1
    one, two = n * t / 2, n * t * (2 * n + 1) / 6
    three, four = one**2, two * (3 * n * n + 3 * n - 1) / 5
    return np.stack([four / 4, three / 2, two / 2, three / 2, two, one, two / 2, one, t], -1).reshape(*t.shape, 3, 3)


def _gain(P: Floats, process_sd: Floats) -> Floats:
    """J (n, 3, 3) of (5) from P⁻₊ (n, 3, 3): as P Fᵀ = F⁻¹ (P⁻₊ − Q), J = F⁻¹ (I − Q (P⁻₊)⁻¹), and of the inverse only
    the last row counts."""
    a, b, c, d, e = P[:, 0, 0], P[:, 0, 1], P[:, 0, 2], P[:, 1, 1], P[:, 1, 2]
    row = np.stack([b * e - c * d, b * c - a * e, a * d - b * b], -1)
    row *= (process_sd**2 / np.einsum("ni,ni->n", row, P[:, 2]))[:, None]
    rest = np.broadcast_to(np.eye(3), P.shape).copy()
    rest[:, 2] -= row
    return np.linalg.inv(F) @ rest


def third_difference(y: Floats, stride: int) -> Floats:
    """(n) the mean square of Δₕ³ of sequences y (n, W), NaN where no four samples h frames apart are there."""
    if y.shape[1] <= 3 * stride:
        return np.full(len(y), np.nan)
    a, b, c, d = (y[:, k * stride : y.shape[1] - (3 - k) * stride] for k in range(4))
    third = d - 3 * c + 3 * b - a
    there = ~np.isnan(third)
    total = np.where(there, third, 0.0)
    return np.where(there.any(1), (total**2).sum(1) / np.maximum(there.sum(1), 1), np.nan)


def measurement_sd_of(y: Floats) -> Floats:
    """(n) σ by (9), mm; `LEAST_SD` where it is less, or where there are too few samples to tell."""
    one, two = third_difference(y, 1), third_difference(y, 2)
    variance = (64 * one - two) / (63 * 20)
    return np.sqrt(np.fmax(np.nan_to_num(variance, nan=0.0), LEAST_SD**2))


def process_sd_of(y: Floats, stride: int, sd: Floats) -> Floats:
    """(n) U by (7) with h of `stride` frames, mm/frame²; with a shorter one where samples do not reach."""
    process_sd = np.full(len(y), np.nan)
    while stride >= 1 and np.isnan(process_sd).any():
        square = (third_difference(y, stride) - 20 * sd**2) * 20 / (11 * float(stride) ** 5)
        least = (0.01 * sd) ** 2 / float(stride) ** 5
        process_sd = np.where(np.isnan(process_sd), np.sqrt(np.maximum(square, least)), process_sd)
        stride //= 2
    return np.where(np.isnan(process_sd), sd, process_sd)
