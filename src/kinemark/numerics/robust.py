"""Weights for observations of which some are wrong, from d, the length of a residual in its own standard deviations.

Cauchy's loss instead of d² lets an observation pull the less the farther off it is:

    ρ = c² ln(1 + d²/c²),   ρ' = ∂ρ / ∂d² = 1 / (1 + d²/c²)               (1)

Least squares of residuals multiplied by √ρ' have the minimum of Σ ρ, if the weights follow the residuals (Holland &
Welsch 1977, "Robust regression using iteratively reweighted least-squares").

Where the error of an observation of k dimensions follows Student's t with ν degrees of freedom in place of a normal
distribution, it counts as one whose covariance is (Lange, Little & Taylor 1989, "Robust statistical modeling using the
t distribution")

    C (ν + d²) / (ν + k)                                                  (2)

and its log-likelihood is, but for what does not depend on d,

    −(ν + k)/2 ln(1 + d²/ν)                                               (3)

The median of d² is 2 ln 2 where errors of two dimensions are normally distributed, so that an unknown common scale s of
all standard deviations is

    s² = median(d²) / (2 ln 2)                                            (4)

The median |d| of normally distributed errors is 0.6745 standard deviations (5), a measure of their spread that half
of the errors may not spoil.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats

MEDIAN_OF_NORMAL = 0.6745
"""(5), in standard deviations; the normal distribution's, to the four digits that are usual; by definition."""

SD_PER_MEDIAN = 1.4826
"""Standard deviation of a normal distribution over its median |d|, without unit: 1 / 0.67449 (Rousseeuw 1984)."""


def plane_scale(d: Floats) -> float:
    """s of (4) from lengths d of residuals of two dimensions."""
    return float(np.sqrt(np.median(d**2) / (2 * np.log(2))))


def cauchy_loss(squared: Floats, c: float) -> Floats:
    """ρ of (1) from d², as c is in standard deviations."""
    return np.asarray(c**2 * np.log1p(squared / c**2))


def cauchy_weight(squared: Floats, c: float) -> Floats:
    """ρ' of (1) from d²: the weight of an observation's square."""
    return np.asarray(1 / (1 + squared / c**2))


def student_widening(squared: Floats, degrees_of_freedom: float, dimensions: int = 2) -> Floats:
    """(2) over C, from d² and ν = `degrees_of_freedom`."""
    return np.asarray((degrees_of_freedom + squared) / (degrees_of_freedom + dimensions))


def student_log_likelihood(squared: Floats, degrees_of_freedom: float, dimensions: Floats) -> Floats:
    """(3), from d², ν = `degrees_of_freedom` and k."""
    return np.asarray(-(degrees_of_freedom + dimensions) / 2 * np.log1p(squared / degrees_of_freedom))
