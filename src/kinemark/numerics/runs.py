"""Runs: where a mask is true, or a value stays the same, without a break."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Bools, Ints


def true_runs(mask: Bools) -> Ints:
    """(n, 2) first and last-plus-one index of each run of true values in `mask` (F)."""
    step = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=np.int8(0), append=np.int8(0)))
    return np.asarray(step.reshape(-1, 2), np.int64)


def true_runs_of_rows(mask: Bools) -> Ints:
    """(n, 3) row, first and last-plus-one column of each run in the rows of `mask` (R, F), row by row."""
    row, step = np.nonzero(np.diff(mask.astype(np.int8), axis=1, prepend=np.int8(0), append=np.int8(0)))
    return np.column_stack([row[::2], step[::2], step[1::2]]).astype(np.int64)


def begins(*columns: NDArray[np.generic]) -> Bools:
    """(N) where a run begins in which no column (N) changes; the first entry begins one."""
    fresh = np.ones(len(columns[0]), np.bool_)
    if len(fresh):
        fresh[1:] = columns[0][1:] != columns[0][:-1]
    for column in columns[1:]:
        fresh[1:] |= column[1:] != column[:-1]
    return fresh


def equal_runs(*columns: NDArray[np.generic]) -> Ints:
    """(n + 1) ends of the runs in which no column (N) changes: run k is `slice(ends[k], ends[k + 1])`.

    An empty column has no run, and its ends are [0].
    """
    return np.append(np.flatnonzero(begins(*columns)), len(columns[0])).astype(np.int64)
