"""What hold-out gaps say of a fill: its expected error, and covariances that are true.

A test tells most of the gap that it was made for. Others count by how near they are to it in length, and in how much
the body part moves, m (`motion`), and more if they are of the same marker:

    w = own · exp(−|ln L/L_gap| / SPREAD − |ln m/m_gap| / SPREAD)                                          (1)

with `own` 1 for the gap's tests and the shares MARKER and OTHER below for the rest. With s̄ the mean size of what the
filler states its error to be (the root of the trace of its covariance), in a test or in the gap, the expected mean
error of the gap is that of the tests, each moved to what it states of this gap, as far as stated errors are true:

    expected = Σ w e (s̄_gap / s̄)^b / Σ w                                                                  (2)

with m in the place of s̄ where a filler states nothing. Some fillers tell an easy gap from a hard one well, others do
not: b is the slope of ln e over ln s̄ in all tests of the method, with S₀ squares of tests of slope b₀ added (10). So
a gap that is harder than all of its tests is expected to be worse than they are. Methods are compared by ln e, moved in
the same way: a few tests gone wrong are no reason to leave the method that is better in all others. Among many methods
some do well in few tests by luck. So another takes the place of the one that is mostly best only if it does better by
more than chance; with d = ln e − ln e' over the tests that both could do,

    d̄ + √( V / (n − 1) ) < 0,     d̄ = Σ w d / Σ w,     V = Σ w (d − d̄)² / Σ w                             (3)

n being the number of tests that differ (7). They are few, so d̄ and V are first shrunk towards those of all tests of the
trial, which count by length and motion alone, w without `own`: these are worth POOLED tests, n d̄ + POOLED d̄_all by
n + POOLED, and so is V (11).

A filler's own covariance is a shape only. Where it gives none, the shape is the mean squared error of the tests as it
grows with the distance d from the nearer edge of the gap, over bins that double, never falling (4). How the errors of
test i compare with it is

    e_c / σ_c = s_i x,      s_i the root mean square over the test's coordinates,                           (5)

x having mean square 1. Errors within a gap go together, so a gap is one draw of s, however many samples it has: tests
are few. With u = ln s, spread normally from gap to gap with variance ω² (random effects: Gelman et al. 2013, ch. 5),

    μ = Σ w u / Σ w,    V = Σ w (u − μ)² / Σ w,    ω² = (ν₀ ω₀² + n V) / (ν₀ + n − 1),
    u of the gap ~ μ + ω √(1 + 1/n) t(ν₀ + n − 1)                                                         (6)

where ω₀ and ν₀ say what is usual, and how many tests that is worth. n is the number of tests that differ: windows of
one marker in a short trial overlap, and twelve of 1 s in 3 s are three. With ρ the share of two tests' frames that are
the same ones of the same marker, n = (Σ w)² / Σ w_i w_j ρ_ij (7). The covariance is scaled such that `LEVEL` of the
product s x, x distributed as in all tests of the method, lies within the interval of that share (8).

Where several methods are tried in a trial of few gaps, easy gaps and hard ones can be told apart: the harder the gap,
the farther are the two methods that do best from one another. With d the root mean square distance of their
predictions, tests in which it is as in the gap tell most:

    w' = w · exp(−|ln d/d_gap| / SPREAD)                                                                   (9)
"""

from __future__ import annotations

import numpy as np
import scipy

from ...data.array_types import Bools, Floats
from ..marker_array import Gap, Prediction
from .hold_out import HoldOutGap, HoldOutResult

SPREAD = 0.5  # of ln length, and of ln distance; chosen; its coverage is that of benchmarks/gaps.py
MARKER = 0.25  # weight of tests for other gaps of the marker; chosen; its coverage is that of benchmarks/gaps.py
OTHER = 0.05  # weight of tests for other markers; chosen; its coverage is that of benchmarks/gaps.py
LEVEL = 0.95  # probability within the interval; conventional
OMEGA, PRIOR_TESTS = 0.5, 4.0
"""ω₀ and ν₀ of (6). On 648 gaps of seven trials ω was 0.44 for body, 0.57, 0.60, 0.65 and 0.75 for four others.
Chosen (see benchmarks/gaps.py)."""
LEAST = 1e-3
"""mm below which distances do not differ, and the least weight by (9); chosen (see benchmarks/gaps.py)."""
MOST = 30.0
"""What a stated error may move the error of a test by, at most; chosen (see benchmarks/gaps.py)."""
SLOPE, PRIOR_SQUARES = 0.8, 1.0
"""b₀ and S₀ of (10), without unit. Of eleven methods on three movements b was 0.75 to 1.2, for stated errors and for
motion. Chosen (see benchmarks/gaps.py)."""
POOLED = 4.0
"""Tests that all tests of the trial are worth in the choice of one gap's method (11); chosen: of 2, 4 and 8 the best
for 20 gaps in nine trials, seeds 1, 21 and 22."""
STEEPEST = 1.2
"""b of (10) at most, without unit; chosen (see benchmarks/gaps.py)."""
Z = 1.959964  # standard deviations on each side that hold 95 %; the normal distribution's, by definition
QUANTILES = (np.arange(40) + 0.5) / 40
"""At which distributions are tabulated; by definition."""


def hold_out_weights(tests: list[HoldOutGap], of: int, gaps: list[Gap], moving: float = np.nan) -> Floats:
    """(1): what each test counts for the gap of that index, in which the part moves by so much √(mm rad)."""
    about = np.array([(t.of, t.window.marker) for t in tests], np.int64).reshape(-1, 2)
    share = np.where(about[:, 0] == of, 1.0, np.where(about[:, 1] == gaps[of].marker, MARKER, OTHER))
    return np.asarray(share * likeness(tests, gaps[of], moving))


def likeness(tests: list[HoldOutGap], gap: Gap, moving: float = np.nan) -> Floats:
    """(1) without `own`: what each test counts by its length and motion alone."""
    length = np.array([t.keep[1] - t.keep[0] for t in tests])
    mismatch = np.abs(np.log(length / gap.length))
    if np.isfinite(moving):
        mismatch = mismatch + np.abs(np.log(np.array([t.motion for t in tests]) / moving))
    return np.asarray(np.exp(-mismatch / SPREAD))


def difficulty_weight(apart: Floats, here: float) -> Floats:
    """What (9) makes of each test, from how far the predictions of two methods are apart in it and in the gap, mm."""
    ratio = np.log(np.maximum(apart, LEAST) / max(here, LEAST))
    return np.asarray(np.maximum(np.exp(-np.abs(ratio) / SPREAD), LEAST))


def slope(x: Floats, y: Floats) -> float:
    """(10): by how much y grows with x, from what is known of both (T)."""
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return SLOPE
    x, y = x[known] - x[known].mean(), y[known] - y[known].mean()
    return float(np.clip((SLOPE * PRIOR_SQUARES + x @ y) / (PRIOR_SQUARES + x @ x), 0.0, STEEPEST))


def size(cov: Floats) -> float:
    """Mean over the frames of the root of the trace of covariances (L, 3, 3), mm; NaN where not all are known."""
    return float(np.sqrt(np.trace(cov, axis1=-2, axis2=-1)).mean()) if len(cov) else np.nan


class MeasuredErrors:
    """What the tests of one method say of its errors: mean error and stated size of each, mm."""

    def __init__(self, results: list[HoldOutResult]) -> None:
        self.means = np.array([t.mean for t in results], np.float64)
        self.logs = np.log(np.maximum(self.means, 1e-9))
        self.stated = np.log(np.maximum([size(t.cov) for t in results], 1e-9))
        self.moved = np.log([t.test.motion for t in results])
        self.same = same_frames([t.test for t in results])
        self.slopes = [slope(x, self.logs) for x in (self.stated, self.moved)]

    def expect(self, prediction: Prediction, weights: Floats, moving: float = np.nan) -> tuple[float, float]:
        """(2) and the geometric mean of e, mm; infinite where it mostly had no prediction, NaN where no test is."""
        if not weights.sum():
            return np.nan, np.nan
        able = np.isfinite(self.means) & (weights > 0)
        w = weights[able]
        if not np.isfinite(prediction.xyz).all() or w.sum() < 0.5 * weights.sum():
            return np.inf, np.inf
        w = w / w.sum()
        moved = np.exp(self._factor(prediction, moving, able))
        return float(w @ (self.means[able] * moved)), float(np.exp(w @ self.logs[able]))

    def _factor(self, prediction: Prediction, moving: float, able: Bools) -> Floats:
        """(T) ln of what each of the tests' errors is moved by (2), of those that are able."""
        with np.errstate(invalid="ignore", divide="ignore"):
            heres = np.log(max(size(prediction.cov), 1e-9)), np.log(moving)
        for there, here, b in zip((self.stated, self.moved), heres, self.slopes, strict=True):
            if np.isfinite(here) and np.isfinite(there[able]).all():
                return np.asarray(np.clip(b * (here - there[able]), -np.log(MOST), np.log(MOST)))
        return np.zeros(int(able.sum()))

    def stated_share(self) -> Floats:
        """(T) what of ln e follows from what the method states, or else from the motion, by (10)."""
        able = np.isfinite(self.means)
        of = next((k for k in (0, 1) if np.isfinite((self.stated, self.moved)[k][able]).all()), 1)
        return np.asarray(self.slopes[of] * (self.stated, self.moved)[of])

    def moved_to(self, prediction: Prediction, moving: float) -> Floats:
        """(T) ln e of all tests, moved to one gap as (2) does; infinite where the method had no prediction."""
        able = np.isfinite(self.means)
        logs = np.where(able, self.logs, np.inf)
        logs[able] += self._factor(prediction, moving, able)
        return logs


def behind(
    logs: Floats,
    others: Floats,
    same: scipy.sparse.csr_array,
    weights: Floats,
    alike: Floats | None = None,
    *,
    sure: float = 1.0,
) -> float:
    """(3): the left side of it, below 0 where one method is better than another by more than `sure` standard errors.

    Args:
        logs: (T) ln e of the one.
        others: (T) of the other.
        same: (T, T) ρ of (7).
        weights: (T) what each test counts for the gap.
        alike: (T) the same by length and motion alone, for (11); without it, nothing is shrunk.
    """
    with np.errstate(invalid="ignore"):
        d = logs - others
    mean, variance, n = _moments(d, weights, same)
    if alike is not None and np.isfinite(mean):
        usual, spread, _ = _moments(d, alike, same)
        mean, variance = ((n * a + POOLED * b) / (n + POOLED) for a, b in ((mean, usual), (variance, spread)))
        n += POOLED
    return mean + sure * np.sqrt(variance / (n - 1)) if n > 1.001 else np.inf


def _moments(d: Floats, weights: Floats, same: scipy.sparse.csr_array) -> tuple[float, float, float]:
    """Mean and variance of (3) and n of (7); an infinite mean where nothing is known."""
    w = np.where(np.isfinite(d), weights, 0.0)
    if not w.sum():
        return np.inf, 0.0, 0.0
    w, d = w / w.sum(), np.where(w > 0, d, 0.0)
    mean = float(w @ d)
    return mean, float(w @ (d - mean) ** 2), 1 / float(w @ (same @ w))


class ErrorCalibration:
    """What one method's tests say of its covariances; (5) and (7) once for all gaps."""

    def __init__(self, results: list[HoldOutResult]) -> None:
        """From all tests of the method in which it had a prediction."""
        self.used = np.array([k for k, t in enumerate(results) if len(t.error)], np.int64)
        usable = [results[k] for k in self.used]
        if not usable:
            return
        errors, cov = np.concatenate([t.error for t in usable]), np.concatenate([t.cov for t in usable])
        edge = np.concatenate([t.edge for t in usable])
        self.growth = None if np.isfinite(cov).all() else ErrorGrowth(edge, errors)
        if self.growth:
            cov = self.growth.cov(edge)
        ratio = errors / np.sqrt(np.maximum(np.diagonal(cov, axis1=-2, axis2=-1), 1e-12))
        length = np.array([len(t.error) for t in usable])
        square = np.add.reduceat((ratio**2).mean(1), np.cumsum(length) - length) / length
        self.u = 0.5 * np.log(np.maximum(square, 1e-12))  # (5)
        x = np.abs(ratio) / np.repeat(np.exp(self.u), length)[:, None]
        self.within = np.quantile(x, QUANTILES)
        self.same = same_frames([t.test for t in usable])

    def covariance(self, prediction: Prediction, edge: Floats, weights: Floats) -> Floats:
        """(L, 3, 3) mm² of a prediction, `edge` (L) frames from its nearer edge; NaN where no test can tell.

        Args:
            prediction: the prediction.
            edge: (L).
            weights: of all tests, from `hold_out_weights`.
        """
        if not len(self.used) or not (w := weights[self.used]).sum():
            return np.full_like(prediction.cov, np.nan)
        shape = self.growth.cov(edge) if self.growth else prediction.cov
        w = w / w.sum()
        n = 1 / float(w @ (self.same @ w))  # (7)
        mean = float(w @ self.u)
        dof = PRIOR_TESTS + n - 1
        omega = np.sqrt((PRIOR_TESTS * OMEGA**2 + n * float(w @ (self.u - mean) ** 2)) / dof)  # (6)
        s = np.exp(mean + omega * np.sqrt(1 + 1 / n) * scipy.special.stdtrit(dof, QUANTILES))
        return shape * (_product_quantile(s, self.within) / Z) ** 2


def same_frames(tests: list[HoldOutGap]) -> scipy.sparse.csr_array:
    """ρ of (7) for all pairs of tests: the frames that both compare of one marker, by the mean length.

    Few pairs have any, and (7) is asked of every gap and method.
    """
    about = [(t.window.marker, t.window.start + t.keep[0], t.window.start + t.keep[1]) for t in tests]
    marker, start, stop = np.array(about, np.float64).reshape(-1, 3).T
    common = np.minimum.outer(stop, stop) - np.maximum.outer(start, start)
    length = stop - start
    share = np.maximum(common, 0.0) / np.sqrt(np.multiply.outer(length, length))
    return scipy.sparse.csr_array(np.where(marker[:, None] == marker, share, 0.0))


def _product_quantile(s: Floats, x: Floats) -> float:
    """(8): the `LEVEL` quantile of s x, from equally likely values of both."""
    product = np.sort(np.multiply.outer(s, x), axis=None)
    return float(np.interp(LEVEL * (product.size - 1), np.arange(product.size), product))


class ErrorGrowth:
    """(4): how the squared error grows from the edges, learnt from tests' samples."""

    def __init__(self, edge: Floats, errors: Floats) -> None:
        far = np.minimum(edge, 1e9)
        bins = np.floor(np.log2(np.maximum(far, 1.0))).astype(int)
        each = [bins == b for b in np.unique(bins)]
        self.at = np.array([np.log(far[mine]).mean() for mine in each])
        square = [(errors[mine] ** 2).mean() for mine in each]
        self.variance = np.maximum(np.maximum.accumulate(square), 1e-12)

    def cov(self, edge: Floats) -> Floats:
        """(L, 3, 3) mm²."""
        variance = np.interp(np.log(np.minimum(edge, 1e9)), self.at, self.variance)
        return variance[:, None, None] * np.eye(3)
