"""Assignment of rows to columns: at the least total cost, or the cheapest pair first."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray


def assign(cost: NDArray[np.float64], limit: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns that go together, with cost (n, m) at most limit (n), as many and as cheap as can be.

    A pair beyond its limit costs more than all allowed ones together, so it is only taken where nothing else is left,
    and then given back.
    """
    allowed = cost <= limit[:, None]
    if not allowed.any():
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    forbidden = 1.0 + cost[allowed].sum()
    rows, columns = scipy.optimize.linear_sum_assignment(np.where(allowed, cost, forbidden))
    good = allowed[rows, columns]
    return rows[good], columns[good]


def assign_nearest(
    cost: NDArray[np.float64], limit: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns that go together, the cheapest of all first, with cost (n, m) at most limit (n)."""
    row, column = np.nonzero(cost <= limit[:, None])
    return cheapest_first(row, column, cost[row, column])


def cheapest_first(
    row: NDArray[np.int64], column: NDArray[np.int64], cost: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of possible pairs (K) those taken where the cheapest goes first and each row and column once; ties: the first."""
    order = np.argsort(cost, kind="stable")
    rows: dict[int, int] = {}
    taken: set[int] = set()
    for i, j in zip(row[order].tolist(), column[order].tolist(), strict=True):
        if i not in rows and j not in taken:
            rows[i] = j
            taken.add(j)
    return np.array(list(rows), np.int64), np.array(list(rows.values()), np.int64)
