"""Two or three methods that do alike, weighed together.

Where several methods do almost equally well in the hidden tests, which of them is the best is chance, and their errors
partly cancel. Those whose typical error is within CLOSE of the least are averaged with the weights

    w_j ∝ 1 / e_j²,      Σ w_j = 1                                                                        (1)

e_j their typical errors. The mean is tried in the same tests, and is a candidate like any other. Its claim is the mean
of the claims of those that make one: they know the hard frames.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .hiding import Tried
from .motion import Floats, Prediction

CLOSE = 1.25
AT_MOST = 3


def close_ones(typical: Sequence[float]) -> dict[int, float]:
    """(1): the methods to be averaged with their weights, by index; empty where one stands alone."""
    order = [int(k) for k in np.argsort(typical)[:AT_MOST] if typical[k] <= CLOSE * min(typical) and typical[k] > 0]
    if len(order) < 2 or not np.isfinite(min(typical)):
        return {}
    w = np.array([1 / typical[k] ** 2 for k in order])
    return dict(zip(order, (w / w.sum()).tolist(), strict=True))


def mean_prediction(said: Sequence[Prediction], weights: Floats) -> Prediction:
    """The weighed mean of predictions, of their covariances too, and all their donors."""
    xyz = np.tensordot(weights, np.array([s.xyz for s in said]), 1)
    return Prediction(
        xyz, _claim([s.cov for s in said], weights), donors=tuple(dict.fromkeys(d for s in said for d in s.donors))
    )


def mean_tests(tried: Sequence[list[Tried]], weights: Floats) -> list[Tried]:
    """The same of all tests; empty errors where one of the methods had nothing to say."""
    return [_mean_test(each, weights) for each in zip(*tried, strict=True)]


def _mean_test(each: Sequence[Tried], weights: Floats) -> Tried:
    if not all(len(t.error) for t in each):
        return min(each, key=lambda t: len(t.error))
    error = np.tensordot(weights, np.array([t.error for t in each]), 1)
    return each[0]._replace(error=error, cov=_claim([t.cov for t in each], weights))


def _claim(cov: Sequence[Floats], weights: Floats) -> Floats:
    """The weighed mean of those covariances (L, 3, 3) that are known throughout; the first, unknown, if none is."""
    known = [k for k, c in enumerate(cov) if np.isfinite(c).all()]
    return np.average([cov[k] for k in known], axis=0, weights=weights[known]) if known else cov[0]
