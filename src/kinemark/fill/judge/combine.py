"""Methods weighed together so that their errors cancel (combination of forecasts: Bates & Granger 1969).

Of methods that do nearly as well in the hold-out gaps, which is the best is partly chance, and their errors partly
cancel. With e_j the error of method j in a test, and s the least root mean square of any in it, so that a hard test
counts no more than an easy one, those within CLOSE of the least typical error get the weights

    w = argmin wᵀC w,     w ≥ 0,  Σ w_j = 1,     C_jk = mean over the tests of ⟨e_j · e_k⟩ / s²             (1)

In each of the gap's own tests the mean is tried with the weights that the others give: a candidate like any other.
Its covariance is the weighted mean of those of the methods that state one: they know the hard frames.

To move C towards what is usual, as tests are few, was tried: correlations of a half, or equal errors. Neither was
better by more than half a per cent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from ...data.array_types import Floats
from ..marker_array import Prediction
from .hold_out import HoldOutResult

CLOSE = 2.0  # times the least typical error; methods within it share the weight; chosen
HEAVY = 1e3
"""What Σ w = 1 counts in the least squares that give (1): any value gives the same w once Σ w is made 1, a great one
keeps rounding away; chosen (see benchmarks/gaps.py)."""


def close_ones(typical: Sequence[float]) -> list[int]:
    """The methods to be averaged, by index, rising so that a mean has one name; empty where one stands alone."""
    close = [k for k, one in enumerate(typical) if one <= CLOSE * min(typical)]
    return close if len(close) > 1 and np.isfinite(min(typical)) else []


def together(results: Sequence[list[HoldOutResult]]) -> Floats:
    """(T, K, K) ⟨e_j · e_k⟩ / s² of every test; NaN where one of the K methods had no prediction."""
    out = np.full((len(results[0]), len(results), len(results)), np.nan)
    for k, each in enumerate(zip(*results, strict=True)):
        if all(len(t.error) for t in each):
            errors = np.array([t.error.ravel() for t in each])
            product = errors @ errors.T
            out[k] = product / max(product.diagonal().min(), 1e-12)
    return out


def weights(products: Floats, counts: Floats) -> Floats:
    """(K) by (1), from what `together` says of T tests and (T) what each counts; equal where no test can tell."""
    known = np.isfinite(products[:, 0, 0]) & (counts > 0)
    K = products.shape[1]
    if not known.any():
        return np.full(K, 1 / K)
    C = np.tensordot(counts[known] / counts[known].sum(), products[known], 1)
    factor = np.linalg.cholesky(C + 1e-9 * (1 + np.trace(C)) * np.eye(K)).T
    w = scipy.optimize.nnls(np.vstack([factor, np.full(K, HEAVY)]), np.append(np.zeros(K), HEAVY))[0]
    return np.asarray(w / w.sum())


def mean_prediction(prediction: Sequence[Prediction], w: Floats) -> Prediction:
    """The weighed mean of predictions, of their covariances too, and the reference markers of those that count."""
    used = [one for one, share in zip(prediction, w, strict=True) if share > 0]
    xyz = np.tensordot(w, np.array([s.xyz for s in prediction]), 1)
    references = tuple(dict.fromkeys(d for s in used for d in s.references))
    return Prediction(xyz, _mean_cov([s.cov for s in prediction], w), references=references)


def mean_tests(results: Sequence[list[HoldOutResult]], w: Floats) -> list[HoldOutResult]:
    """The same of all tests, each with its own weights (T, K); empty errors where a method had no prediction."""
    return [_mean_test(each, of) for each, of in zip(zip(*results, strict=True), w, strict=True)]


def _mean_test(each: Sequence[HoldOutResult], w: Floats) -> HoldOutResult:
    if not all(len(t.error) for t in each):
        return min(each, key=lambda t: len(t.error))
    error = np.tensordot(w, np.array([t.error for t in each]), 1)
    return each[0]._replace(error=error, cov=_mean_cov([t.cov for t in each], w))


def _mean_cov(cov: Sequence[Floats], w: Floats) -> Floats:
    """The weighed mean of those covariances (L, 3, 3) that are known throughout, be it that of a method that hardly
    counts; NaN if none is."""
    known = [k for k, c in enumerate(cov) if np.isfinite(c).all()]
    return np.average([cov[k] for k in known], axis=0, weights=w[known] + 1e-9) if known else cov[0]
