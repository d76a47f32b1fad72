"""Frequency and harmonics of a gait curve (recommended by Swamidas 1997, 5.2, as marks of motion and disease).

A curve y over the stride of the time T has, at its points t_n = n / N from 0 to just before 100 %,

    y(t) = c₀ + Σ_h a_h cos(2π h t + φ_h),   h = 1 … H, of frequency h / T                                   (1)

exactly as many as there are for H = N / 2, so that amplitudes are those of its discrete Fourier transform. The share of
a harmonic is that of the power of all, a_h² / Σ a² (2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..numerics.runs import true_runs

HARMONICS = 6
"""That are told; chosen: of walkers' joint angles they hold more than 0.99 of the power."""
LONGEST_GAP = 10
"""Points of a curve that a line may bridge, % of the stride; chosen: harmonics above the sixth are shorter."""


class CurveHarmonics(NamedTuple):
    """Of one curve.

    Attributes:
        amplitude: (H) in the curve's unit. phase_deg: (H) at which each begins. share: (H) of the power.
    """

    amplitude: Floats
    phase_deg: Floats
    share: Floats


def curve_harmonics(curve: Floats) -> CurveHarmonics:
    """The first `HARMONICS` of a curve; NaN where too much of it is missing, and shares where it does not move.

    Args:
        curve: (101) from one foot strike to the next.
    """
    unknown = np.full(HARMONICS, np.nan)
    missing = ~np.isfinite(curve)
    if missing[[0, -1]].any() or any(stop - first > LONGEST_GAP for first, stop in true_runs(missing)):
        return CurveHarmonics(unknown, unknown, unknown)
    x = np.arange(len(curve))
    y = np.interp(x, x[~missing], curve[~missing])[:-1]
    spectrum = 2 * np.fft.rfft(y)[1:] / len(y)  # (1)
    power = np.abs(spectrum) ** 2
    first = spectrum[:HARMONICS]
    total = power.sum()
    share = power[:HARMONICS] / total if total > 1e-18 * max(float((y**2).mean()), 1e-300) else unknown
    return CurveHarmonics(np.abs(first), np.degrees(np.angle(first)), np.asarray(share))
