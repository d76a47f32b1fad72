"""By how much a variance that few residuals tell must be enlarged.

An error divided by its standard deviation, which ν residuals more than parameters tell, is distributed as t with ν
degrees of freedom. Its variance is

    ν / (ν − 2)                                                          (1)

from three on. For one and two it has none, and the factor is that with which 95 % intervals hold,

    (t₀.₉₇₅(ν) / z₀.₉₇₅)²                                                (2)

42 and 4.8. From four on both are the same within 5 %.
"""

from __future__ import annotations

import scipy

LEAST = 3
"""Degrees of freedom from which (1) exists; by definition."""
UPPER = 0.975
"""Share below the upper end of a 95 % interval; by definition."""


def variance_factor(nu: float) -> float:
    """(1), or (2) below `LEAST`; fewer than one count as one."""
    if nu >= LEAST:
        return float(nu / (nu - 2))
    return float((scipy.stats.t.ppf(UPPER, max(nu, 1)) / scipy.stats.norm.ppf(UPPER)) ** 2)
