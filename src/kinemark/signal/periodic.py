"""How long the cycle of a periodic motion is, and its frequency and harmonics (recommended by Swamidas 1997, 5.2).

**Cycle length.** For sequences y_j(t), NaN where missing, the mean squared difference of samples τ frames apart is

    D(τ) = mean over j and t of [y_j(t + τ) − y_j(t)]² / (2 · mean over j of var y_j)             (1)

over the pairs of which both are there, so that what moves most counts most (the sequences have one unit): about 1 for
what is unrelated and near 0 where τ is a cycle. Its minima lie at the cycle and at its multiples. The cycle is the
first minimum nearly as low as the lowest, D ≤ D_min + 0.1 (D_max − D_min) (2), refined by the parabola through three
values. It is one only if D there is below a limit: a motion that does not come back has none. Walking has two steps a
stride; sequences of both legs differ by a half cycle, so that a stride is found, no step. The sums of (1) are
correlations of the samples and of their masks, done by FFT.

**Harmonics.** With the period T, each sequence is fitted by least squares over its samples with

    y(t) = c₀ + Σ_h a_h cos(2π h t / T) + b_h sin(2π h t / T),  h = 1 … H                         (3)

amplitude √(a² + b²), phase atan2(b, a) (the harmonic is greatest at that angle), power (a² + b²) / 2 as a share of
the variance of the samples. T is the one with the least residual of all sequences together near the T given (4): all
cycles of the recording count for it, where (2) compares neighbours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Bools, Floats

FEWEST_PAIRS = 0.25
"""Share of the samples that must have a partner, for (1) to be known; chosen."""
REPEATS = 0.3
"""D below which a motion repeats: 0 where it does so exactly, 1 where it never does; chosen."""
TOLERANCE = 0.1
"""Of the way from the shallowest to the deepest D, the tolerance of (2); chosen."""


class Harmonics(NamedTuple):
    """Of K sequences.

    frequency: of the fundamental, Hz; mean (K); amplitude, phase_deg, power (K, H) of harmonics 1 … H, power as a
        share of the variance; residual (K) RMS of what is left.
    """

    frequency: float
    mean: Floats
    amplitude: Floats
    phase_deg: Floats
    power: Floats
    residual: Floats

    @property
    def distortion(self) -> Floats:
        """(K) power of the harmonics above the first over that of the first: 0 for a pure sine."""
        return self.power[:, 1:].sum(1) / np.maximum(self.power[:, 0], np.finfo(float).tiny)


def mean_differences(y: Floats, most: int | None = None) -> Floats:
    """D (W,) of (1) for sequences y (K, W) and τ = 0 … W − 1, or below `most`; NaN where too few samples have a
    partner."""
    n = y.shape[1]
    most = n if most is None else min(most, n)
    seen: Bools = ~np.isnan(y)
    y = np.where(seen, y, 0.0)
    scale = float((y**2).mean()) if y.size else 0.0
    y = np.where(seen, y - (y.sum(1) / np.maximum(seen.sum(1), 1))[:, None], 0.0)
    total = float((y**2).sum() / max(seen.sum(), 1))
    if not total > 1e-18 * scale:  # constant but for rounding
        return np.full(most, np.nan)
    y /= np.sqrt(total)
    keys = [row.tobytes() for row in seen]
    masks = dict(zip(keys, seen.astype(float), strict=True))  # few: the axes of a marker have the same
    same = np.array([[float(key == mask) for key in keys] for mask in masks])
    size = scipy.fft.next_fast_len(n + most, real=True)  # so that the ends of τ < most do not meet
    one, square, mask = (scipy.fft.rfft(a, size) for a in (y, same @ y**2, np.array(list(masks.values()))))
    pairs, squares, products = (
        scipy.fft.irfft(spectrum, size)[:most]
        for spectrum in (same.sum(1) @ _power(mask), (square * mask.conj()).real.sum(0), _power(one).sum(0))
    )
    enough = pairs > FEWEST_PAIRS * seen.sum()
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(enough, np.maximum(squares - products, 0.0) / pairs, np.nan)


def _power(spectrum: NDArray[np.complex128]) -> Floats:
    return spectrum.real**2 + spectrum.imag**2


def cycle_length(y: Floats, *, shortest: float, longest: float) -> float:
    """Frames of a cycle of sequences y (K, W) by (2); NaN where they do not repeat.

    Args:
        y: NaN where missing.
        shortest, longest: of cycles looked for, frames.
    """
    first, last = max(int(shortest), 2), min(int(longest) + 1, y.shape[1] - 1)
    D = mean_differences(y, last + 1)
    tau = np.arange(first, last)
    if len(tau) < 1 or not np.isfinite(D[first - 1 : last + 1]).any():
        return float("nan")
    with np.errstate(invalid="ignore"):
        minimum = tau[(D[tau] <= D[tau - 1]) & (D[tau] < D[tau + 1]) & (D[tau] < REPEATS)]
    if not len(minimum):
        return float("nan")
    low, high = D[minimum].min(), np.nanmax(D[: last + 1])
    k = int(minimum[D[minimum] <= low + TOLERANCE * (high - low)][0])  # (2)
    left, here, right = D[k - 1 : k + 2]
    return float(k + 0.5 * (left - right) / max(left - 2 * here + right, 1e-12))


def find_harmonics(y: Floats, *, rate: float, period: float, n_harmonics: int = 10) -> Harmonics:
    """(3) and (4) for sequences y (K, W), NaN where missing.

    Args:
        y: samples.
        rate: Hz.
        period: of the cycle, s, good to a tenth of itself over the length of the recording.
        n_harmonics: H; fewer where the rate does not reach.

    Raises:
        ValueError: the period is not above two frames, or no sample is there.
    """
    if not period * rate > 2:
        raise ValueError(f"period is {period} s at {rate} Hz, wanted more than two frames")
    there = ~np.isnan(y)
    if not there.any():
        raise ValueError("y holds no sample")
    H = max(min(n_harmonics, int(np.ceil(period * rate / 2)) - 1, (int(there.sum(1).max()) - 1) // 2), 1)
    t = np.arange(y.shape[1]) / rate
    T = _best_period(y, there, t, period, min(H, 3))
    fits = _fits(y, there, t, T, H)
    c = np.array([coefficients for coefficients, _ in fits])
    a, b = c[:, 1 : H + 1], c[:, H + 1 :]
    square = np.array([np.var(row[own]) if own.any() else np.nan for row, own in zip(y, there, strict=True)])
    return Harmonics(
        frequency=1 / T,
        mean=c[:, 0],
        amplitude=np.hypot(a, b),
        phase_deg=np.degrees(np.arctan2(b, a)),
        power=(a**2 + b**2) / 2 / np.maximum(square, np.finfo(float).tiny)[:, None],
        residual=np.array([np.sqrt((r**2).mean()) if len(r) else np.nan for _, r in fits]),
    )


def _best_period(y: Floats, there: Bools, t: Floats, period: float, H: int) -> float:
    """(4), s."""

    def left(share: float) -> float:
        return float(sum((r**2).sum() for _, r in _fits(y, there, t, period * (1 + share), H)))

    reach = min(0.1, 0.25 * period / max(t[-1], period))
    best = scipy.optimize.minimize_scalar(left, bounds=(-reach, reach), method="bounded", options={"xatol": 1e-7})
    return period * (1 + float(best.x))


def _fits(y: Floats, there: Bools, t: Floats, period: float, H: int) -> list[tuple[Floats, Floats]]:
    """(3): coefficients (1 + 2 H) and residuals of each sequence."""
    angle = 2 * np.pi / period * np.arange(1, H + 1) * t[:, None]
    A = np.concatenate([np.ones((len(t), 1)), np.cos(angle), np.sin(angle)], 1)
    found = []
    for row, own in zip(y, there, strict=True):
        c = np.linalg.lstsq(A[own], row[own], rcond=None)[0] if own.any() else np.full(2 * H + 1, np.nan)
        found.append((c, row[own] - A[own] @ c))
    return found
