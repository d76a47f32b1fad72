"""Means and medians of the numbers among values that may be missing."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats


def finite_mean(values: Floats) -> float:
    """Mean of the finite values (…) of any shape; NaN where there is none."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else float("nan")


def finite_median(values: Floats, none: float = float("nan")) -> float:
    """Median of the finite values (…) of any shape; `none` where there is none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else none
