"""The white noise of a path, whatever its movement.

Differences of order k through time, Δᵏx = Σ (−1)ʲ (k j) x[f − j] with the binomial coefficients (k j), leave of a
movement of frequency ν, at the frame rate r, (2 sin πν/r)ᵏ of its amplitude, and of white noise of standard deviation σ
the variance (2k k) σ². So with the median, which single jumps cannot move,

    σ = median |Δᵏx| / (0.6745 √(2k k))                                                       (1)

(after Lanshammar 1982). 0.6745 is the median of |normal deviates| of standard deviation 1. Low orders take movement for
noise: at a tenth of the frame rate (5 Hz at 50 Hz), k = 3 leaves a nineteenth of its amplitude in σ, k = 4 a
fifty-seventh, and k = 12 less than a hundred-thousandth. (1) looks at the noise near half the frame rate: of a path
that was filtered it finds too little, and nothing of errors that change slowly.
"""

from __future__ import annotations

import math

import numpy as np

from ..data.array_types import Floats
from ..numerics.robust import MEDIAN_OF_NORMAL

ORDER = 12
"""k, frames less one; chosen: of running at 25 Hz it leaves 0.01 mm, of walking 0.003; higher ones need longer runs."""

FEWEST = 20
"""Differences that a median is taken of, a number; chosen."""


def white_noise_sd(xyz: Floats) -> float:
    """σ along one axis by (1), in the unit of a path (F, n) that is NaN where it is missing; NaN where it is too short.

    At least 20 differences are wanted. Each difference takes 13 samples in a row. The axes' variances are averaged.
    """
    change = np.diff(xyz, n=ORDER, axis=0)
    known = change[np.isfinite(change).all(1)]
    if len(known) < FEWEST:
        return math.nan
    sd = np.median(np.abs(known), axis=0) / (MEDIAN_OF_NORMAL * math.sqrt(math.comb(2 * ORDER, ORDER)))  # (1)
    return float(np.sqrt(np.mean(sd**2)))
