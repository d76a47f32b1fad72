"""A Butterworth filter without lag, and the cut-off that residual analysis gives it.

A filter of order n, run forwards and backwards, has no lag and the gain 1 / (1 + (f/f₀)²ⁿ). For the pair to fall to
1/√2 at the cut-off f_c, each is set to

    f₀ = f_c / (√2 − 1)^(1/2n)                                                                          (1)

before the bilinear transform. The noise that it lets through, white of variance σ² before, is σ² g with

    g = ∫₀^½ 2 |H(ν)|² dν                                                                               (2)

over frequencies ν in cycles a sample.

Residual analysis (Winter 2009): with r(f_c) the RMS of what the filter takes away, the cut-off is where r equals the
noise, so that about as much of the motion is lost as noise is let through. Of white noise the filter takes away

    r² = σ² ∫₀^½ 2 (1 − H)² dν                                                                          (3)

alone above some frequency; σ² is fitted to (3) over the upper half of the cut-offs, and the cut-off is where r² first
falls to σ² (4). Winter draws a straight line through r by eye; (3) is that line for white noise, worked out.

Files are resampled before they are exported, and then no noise is above what was half the rate. Cut-offs therefore end
at 40 Hz, and σ² is the sum of two variances that are fitted together, neither below 0: of noise in the band below
50 Hz, and of noise above it, each white (5). So the cut-off stays as it is where more samples are put between.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..data.array_types import Floats

CUTOFFS = 60  # that residual analysis tries; chosen
HIGHEST = 0.4
"""Of the rate; the highest cut-off that residual analysis looks at; chosen."""
HIGHEST_HZ = 40.0
"""The same where the rate allows more. Noise is fitted over its upper half, 20 to 40 Hz, where little motion is left:
99 % of the energy of gait is below 15 Hz (Antonsson and Mann 1985)."""
GRID = (np.arange(4000) + 0.5) / 8000
"""ν of the integrals; chosen."""


def butterworth(y: Floats, *, rate: float, cutoff_hz: float, order: int = 2) -> Floats:
    """y (F, k) without NaN, filtered forwards and backwards, so that the whole is of twice the order and has no lag.

    Raises:
        ValueError: the cut-off is not between 0 and half the rate, or there are too few samples.
    """
    return _both_ways(_extended(y, order), rate=rate, cutoff_hz=cutoff_hz, order=order)


def _extended(y: Floats, order: int) -> Floats:
    """y (F, k) with `edge_samples` turned about its first and its last, before and behind.

    Raises:
        ValueError: there are too few samples.
    """
    n = edge_samples(order)
    if len(y) <= n:
        raise ValueError(f"{len(y)} samples, wanted more than {n} for order {order}")
    return np.concatenate([2 * y[:1] - y[n:0:-1], y, 2 * y[-1:] - y[-2 : -(n + 2) : -1]])


def _both_ways(extended: Floats, *, rate: float, cutoff_hz: float, order: int) -> Floats:
    """(F, k) filtered forwards and backwards, of samples that were extended; as `scipy.signal.sosfiltfilt` does it,
    which extends them and computes the state of rest for every cut-off anew."""
    from scipy.signal import sosfilt  # a second to import, which no other command should wait for

    sections, rest = _sections(cutoff_hz, rate, order)
    state = rest.reshape(*rest.shape, *(1,) * (extended.ndim - 1))
    forwards, _ = sosfilt(sections, extended, axis=0, zi=state * extended[:1])
    backwards, _ = sosfilt(sections, forwards[::-1], axis=0, zi=state * forwards[-1:])
    n = edge_samples(order)
    return np.asarray(backwards[::-1][n:-n])


def moving_average(y: Floats, samples: int) -> Floats:
    """Means of y (F, k) without NaN over an odd number of samples about each; fewer towards the ends, on both sides
    alike, so that a straight line stays as it is.

    Raises:
        ValueError: the number is even or below 1.
    """
    if samples < 1 or samples % 2 == 0:
        raise ValueError(f"samples is {samples}, wanted an odd number")
    n = len(y)
    side = np.minimum(samples // 2, np.minimum(np.arange(n), np.arange(n)[::-1]))
    total = np.concatenate([np.zeros((1, *y.shape[1:])), np.cumsum(y - y[:1], axis=0)])
    mean = (total[np.arange(n) + side + 1] - total[np.arange(n) - side]) / (2 * side + 1)[:, None]
    return np.asarray(mean + y[:1])


def averaged_samples(*, rate: float, cutoff_hz: float) -> int:
    """The odd number of samples whose mean leaves 1/√2 nearest to the cut-off: sin(π n ν) = n sin(π ν) / √2, that is
    n = 0.443 / ν for small ν = cutoff / rate."""
    return 2 * round((0.443 * rate / cutoff_hz - 1) / 2) + 1


def edge_samples(order: int) -> int:
    """Samples mirrored at each end of the filter; a run must have more."""
    return 6 * order


@lru_cache(maxsize=8 * CUTOFFS)
def _sections(cutoff_hz: float, rate: float, order: int) -> tuple[Floats, Floats]:
    """Of one pass, (S, 6) of second order, and their states (S, 2) at rest at 1; residual analysis asks for the same
    ones for every marker, and designs take longer than filtering."""
    from scipy.signal import butter, sosfilt_zi

    sections = np.asarray(butter(order, _each_pass(cutoff_hz, rate, order), fs=rate, output="sos"))
    return sections, np.asarray(sosfilt_zi(sections))


@lru_cache(maxsize=16)
def _taken_of_noise(rate: float, order: int) -> Floats:
    """(CUTOFFS, 1 or 2) of white noise of variance 1 in each band (5), what the filter takes away (3) at the cut-offs
    of residual analysis."""
    taken = np.array([(1 - _response(rate, f, order)) ** 2 for f in _cutoffs(rate)])
    low = GRID * rate < HIGHEST_HZ / (2 * HIGHEST)
    return np.stack([taken[:, band].mean(1) for band in (low, ~low) if band.any()], -1)


def _cutoffs(rate: float) -> Floats:
    """(CUTOFFS) Hz that residual analysis tries."""
    return np.linspace(1, CUTOFFS, CUTOFFS) / CUTOFFS * HIGHEST * min(rate, HIGHEST_HZ / HIGHEST)


def _each_pass(cutoff_hz: float, rate: float, order: int) -> float:
    if order < 1 or not 0 < cutoff_hz < rate / 2:
        raise ValueError(f"cutoff_hz is {cutoff_hz:g} and order {order}, wanted 0 to {rate / 2:g} Hz and 1 or more")
    tangent = np.tan(np.pi * cutoff_hz / rate) / (np.sqrt(2) - 1) ** (1 / (2 * order))  # (1)
    return float(min(np.arctan(tangent) * rate / np.pi, 0.4999 * rate))


def butterworth_gain(*, rate: float, cutoff_hz: float, order: int = 2) -> float:
    """g (2): how many times the variance of white noise is left."""
    return float(np.mean(_response(rate, cutoff_hz, order) ** 2))  # (2)


def _response(rate: float, cutoff_hz: float, order: int) -> Floats:
    """H of both passes over `GRID`."""
    f0 = _each_pass(cutoff_hz, rate, order)
    ratio = np.tan(np.pi * GRID) / np.tan(np.pi * f0 / rate)
    return 1 / (1 + ratio ** (2 * order))


def residual_analysis(y: Floats, *, rate: float, order: int = 2) -> tuple[float, float]:
    """Cut-off in Hz (4) and noise σ (3) of samples y (F, k) without NaN; the k channels are taken together.

    Where the motion reaches up to the highest cut-off looked at, 0.4 of the rate or 40 Hz, that is the answer.

    Raises:
        ValueError: fewer than 30 samples.
    """
    if len(y) < 30:
        raise ValueError(f"{len(y)} samples, wanted 30 or more for residual analysis")
    from scipy.optimize import nnls

    cutoffs, extended = _cutoffs(rate), _extended(y, order)
    r2 = np.array([np.mean((_both_ways(extended, rate=rate, cutoff_hz=f, order=order) - y) ** 2) for f in cutoffs])
    noise = _taken_of_noise(rate, order)
    upper = cutoffs > cutoffs[-1] / 2
    sigma2 = float(nnls(noise[upper], r2[upper])[0].sum())  # (3), (5)
    below = np.flatnonzero(r2 <= sigma2)
    if not below.size:
        return float(cutoffs[-1]), sigma2**0.5
    i = int(below[0])
    if i == 0:
        return float(cutoffs[0]), sigma2**0.5
    share = (r2[i - 1] - sigma2) / max(r2[i - 1] - r2[i], np.finfo(float).tiny)
    return float(cutoffs[i - 1] + share * (cutoffs[i] - cutoffs[i - 1])), sigma2**0.5  # (4)
