"""Who belongs to whom: the assignment with the least total cost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment


def assign(cost: NDArray[np.float64], limit: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns that go together, with cost (n, m) at most limit (n), as many and as cheap as can be.

    A pair beyond its limit costs more than all allowed ones together, so it is only taken where nothing else is left,
    and then given back.
    """
    allowed = cost <= limit[:, None]
    if not allowed.any():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    forbidden = 1.0 + cost[allowed].sum()
    rows, columns = linear_sum_assignment(np.where(allowed, cost, forbidden))
    good = allowed[rows, columns]
    return rows[good], columns[good]
