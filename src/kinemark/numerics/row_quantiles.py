"""Medians and quantiles of many rows with gaps at once; NumPy's take each row by itself, and several times as long.

They are NumPy's to the last digit. Each row has some values that are not NaN.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints


def row_medians(rows: Floats) -> Floats:
    """(…) the medians of rows (…, n) without their NaN."""
    ordered, number = _ordered(rows)
    return np.asarray((_at(ordered, (number - 1) // 2) + _at(ordered, number // 2)) / 2)


def row_quantiles(rows: Floats, share: float) -> Floats:
    """(…) the value below which a share of each of rows (…, n) lies, between two in proportion, without their NaN."""
    ordered, number = _ordered(rows)
    place = (number - 1) * share
    before = place.astype(np.int64)
    low, high, part = _at(ordered, before), _at(ordered, np.minimum(before + 1, number - 1)), place - before
    return np.asarray(np.where(part < 0.5, low + (high - low) * part, high - (high - low) * (1 - part)))


def _ordered(rows: Floats) -> tuple[Floats, Ints]:
    """The rows (…, n) in order, NaN last, and how many each has that are not (…)."""
    return np.sort(rows, axis=-1), (~np.isnan(rows)).sum(-1)


def _at(rows: Floats, k: Ints) -> Floats:
    """(…) one of each of rows (…, n)."""
    return np.asarray(np.take_along_axis(rows, k[..., None], -1)[..., 0])
