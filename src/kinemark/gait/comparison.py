"""Two conditions of a subject: which differences exceed their own error.

At a point of the stride, with means aᵢ of nᵢ strides, their deviations between strides sᵢ and the standard
uncertainties of the measurement mᵢ, Δ = a₂ − a₁ exceeds its error where

    Δ² > t² Σ sᵢ² / nᵢ + z² Σ mᵢ²,   ν = (Σ sᵢ² / nᵢ)² / Σ [(sᵢ² / nᵢ)² / (nᵢ − 1)]                          (1)

with z and t for ν degrees of freedom (Welch 1947) of 95 %. A measurement's error is one for the whole curve; strides
differ in `SHAPES` ways, so that for curves t is of 1 − 0.05 / `SHAPES` (Bonferroni). Where the markers stayed on in
between, what is systematic is in both alike, and mᵢ holds the noise of the markers alone. A curve differs where it does
so for `LEAST_POINTS` or more in a row (2). With two or three strides the deviations of neighbouring points differ by
chance; each is drawn to the curve's mean as if that were known from `PRIOR` degrees of freedom, which count as well
(Smyth 2004) (3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Bools, Floats
from ..data.gait_curves import known_mean
from ..numerics.runs import true_runs

BEYOND = 0.05
"""Share of differences by chance that (1) takes for true ones; conventional."""
SHAPES = 10
"""Ways in which strides differ; chosen: gait has hardly any motion above its tenth harmonic."""
LEAST_POINTS = 5
"""(2), % of a stride; chosen: shorter ones come by chance where a curve is steep."""


PRIOR = 4.0
"""(3), degrees of freedom; chosen: with six strides a point's own deviation counts more."""


class Condition(NamedTuple):
    """A quantity in one condition.

    Attributes:
        mean, spread, sd: (101, …) of strides, between them, and of the measurement of one; or of one number alone.
        strides: how many.
    """

    mean: Floats
    spread: Floats
    sd: Floats
    strides: int


class Difference(NamedTuple):
    """Second less first condition.

    Attributes:
        value: (…) difference. error: (…) beyond which it is one, the root of the right of (1); NaN where
            it is not known.
        exceeds: (…) whether it does.
    """

    value: Floats
    error: Floats
    exceeds: Bools


def difference(first: Condition, second: Condition) -> Difference:
    """(1) at every point on its own.

    One stride alone is taken to vary as those of the other condition do; where neither varies, nothing is known.
    """
    spreads = [np.asarray(one.spread, np.float64) for one in (first, second)]
    spreads = [np.where(np.isfinite(a), a, b) for a, b in (spreads, spreads[::-1])]
    most = max(first.strides, second.strides)
    free = [float(max(one.strides - 1 if one.strides > 1 else most - 1, 1)) for one in (first, second)]
    if spreads[0].ndim:
        spreads = [_drawn(s, n) for s, n in zip(spreads, free, strict=True)]
        free = [n + PRIOR for n in free]
    each = [s**2 / max(one.strides, 1) for s, one in zip(spreads, (first, second), strict=True)]
    sampled, chance = each[0] + each[1], BEYOND / (SHAPES if spreads[0].ndim else 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        degrees = np.where(sampled > 0, sampled**2 / sum(e**2 / n for e, n in zip(each, free, strict=True)), np.inf)
    t, z = scipy.stats.t.ppf(1 - chance / 2, np.minimum(degrees, 1e6)), scipy.stats.norm.ppf(1 - BEYOND / 2)
    error = np.sqrt(t**2 * sampled + z**2 * (first.sd**2 + second.sd**2))
    value = np.asarray(second.mean - first.mean)
    return Difference(value, error, np.asarray(np.abs(value) > error))


def _drawn(spread: Floats, free: float) -> Floats:
    """(3): (101, …) towards the curve's own mean square."""
    mean = known_mean(spread**2, (0,))
    return np.asarray(np.sqrt((free * spread**2 + PRIOR * mean) / (free + PRIOR)))


def stretches(exceeds: Bools) -> list[tuple[int, int]]:
    """First and last point (2) of each stretch of a curve (101) that differs, both included."""
    return [(int(a), int(b) - 1) for a, b in true_runs(exceeds) if b - a >= LEAST_POINTS]
