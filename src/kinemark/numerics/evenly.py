"""A few of many, evenly."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Ints


def evenly(n: int, most: int) -> Ints:
    """At most `most` of the places 0 … n − 1, evenly spaced and rising, with the first and the last; none for n ≤ 0."""
    return np.linspace(0, n - 1, max(min(n, most), 0)).astype(np.int64)
