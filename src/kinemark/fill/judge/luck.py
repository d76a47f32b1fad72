"""What of the small error expected of a method is luck: it was chosen because of it.

Of many methods, the one of which the least error is expected was mostly lucky, in its tests and in what it states of
the gap, so its error is greater than that (the winner's curse; Cawley & Talbot 2010). By how much, choosing in the
tests tells (nested cross-validation). With x_j(k) what method j states of test k and b_j its slope (`expected_error`),
of test k it is expected, from the tests i that share no frame with k, and w what the tests count,

    ln ê_j(k) = b_j x_j(k) + Σ w_i (ln e_j(i) − b_j x_j(i)) / Σ w_i                                        (1)

With j(k) the method of which the least is expected, the errors are greater than expected by the factor e^c,

    c = max(0, Σ w_k (ln e_j(k)(k) − ln ê_j(k)(k)) / Σ w_k)                                               (2)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data.array_types import Floats
from .expected_error import MeasuredErrors


def luck(methods: Sequence[MeasuredErrors], weights: Floats) -> float:
    """c of (2), a natural logarithm, from the tests of all methods and what they count (T); 0 of too few."""
    able = [each for each in methods if np.isfinite(each.logs[weights > 0]).all()]
    counts = weights > 0
    if len(able) < 2 or counts.sum() < 2:
        return 0.0
    w = weights[counts]
    others = np.where(able[0].same.toarray()[np.ix_(counts, counts)] > 0, 0.0, w[:, None])
    counts_k = others.sum(0)
    told = counts_k > 0
    if not told.any():
        return 0.0
    logs = np.array([each.logs[counts] for each in able])
    base = np.array([each.stated_share()[counts] for each in able])
    expected = base + (logs - base) @ (others / np.where(told, counts_k, 1.0))  # (1)
    chosen = expected.argmin(0), np.arange(len(w))
    return max(0.0, float((w * told) @ (logs - expected)[chosen] / (w @ told)))
