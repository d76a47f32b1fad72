"""A few of many, evenly."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Ints


def evenly(n: int, most: int) -> Ints:
    """At most `most` of the places 0 … n − 1, evenly spaced and rising, with the first and the last; none for n ≤ 0."""
    return np.linspace(0, n - 1, max(min(n, most), 0)).astype(np.int64)


def evenly_rounded(n: int, most: int) -> Ints:
    """As `evenly`, each at the place that is nearest; `evenly` has the one before."""
    return np.linspace(0, n - 1, max(min(n, most), 0)).round().astype(np.int64)


def scattered(n: int, most: int) -> Ints:
    """At most `most` of the places 0 … n − 1, rising, one in each of as many equal parts, at none of a period.

    Evenly spaced ones are all odd or all even where their step is: of a camera with every second image none is met.
    Where in its part each lies follows the golden ratio, whose multiples are the farthest from any period (Weyl 1916).
    """
    k = np.arange(max(min(n, most), 0))
    return np.floor((k + k * (np.sqrt(5) - 1) / 2 % 1) * n / max(len(k), 1)).astype(np.int64)
