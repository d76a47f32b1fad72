"""From arrays to plain numbers: statistics that survive empty input, and data that JSON can hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs

SCHEMA_VERSION = 1
"""Of all files of figures; it grows when a key is renamed, removed or comes to mean something else."""


def plain(value: Any) -> Any:
    """`value` as dicts, lists, strings, booleans, finite numbers and None; what is not finite becomes None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, (str, bool, int)) or value is None:
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Sequence):
        return [plain(item) for item in value]
    return str(value)


def mean(values: Floats) -> float:
    """Mean of the finite values; NaN where there is none."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else math.nan


def rms(values: Floats) -> float:
    """Root mean square of the finite values; NaN where there is none."""
    return math.sqrt(mean(values**2))


def quantile(values: Floats, share: float) -> float:
    """Quantile of the finite values; NaN where there is none."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if finite.size else math.nan


def over_volume(values: Floats, at: float) -> float:
    """Quantile over all places, those that are not seen being infinitely wrong; NaN where it falls on one of them."""
    return float(np.quantile(np.where(np.isnan(values), np.inf, values), at, method="higher"))


def share(part: float, whole: float) -> float:
    """part / whole; NaN where the whole is nothing."""
    return part / whole if whole > 0 else math.nan


def runs(mask: Bools) -> list[tuple[int, int]]:
    """First and last-plus-one index of each run of true values in `mask` (F)."""
    return [(int(a), int(b)) for a, b in true_runs(mask)]
