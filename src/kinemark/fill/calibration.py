"""What hidden tests say of a fill: its expected error, and covariances that are true.

A test tells most of the gap that it was made for. Others count by how near they are to it in length, and more if they
are of the same marker:

    w = own · exp(−|ln L/L_gap| / SPREAD)                                                                  (1)

with `own` 1 for the gap's tests and the shares MARKER and OTHER below for the rest. With s̄ the mean size of what the
filler claims its error to be (the root of the trace of its covariance), in a test or in the gap, the expected mean
error of the gap is that of the tests, moved half way to what the claim says of this gap:

    expected = Σ w e / Σ w · √( s̄_gap / (Σ w s̄ / Σ w) )                                                   (2)

(half way, in logarithms, as some fillers tell an easy gap from a hard one well and others do not; the root is 1 where
a filler claims nothing). Methods are compared by the geometric mean of e alone (3): a few tests gone wrong are no
reason to leave the method that is better in all others, nor is the honesty of one that finds a gap harder than its
tests.

A filler's own covariance is a shape only. Where it gives none, the shape is the mean squared error of the tests as it
grows with the distance d from the nearer edge of the gap, over bins that double, never falling (4). The scale is such
that the share `LEVEL` of the tests' coordinates lie within the interval of that share,

    scale = quantile( |e_c| / (z σ_c) ),      z = 1.96                                                      (5)

with the weights (1) spread over the samples of each test. Few tests make an uncertain quantile. With ν the number of
tests that the weights amount to, (Σ w)²/Σ w², the scale is widened by t(ν)/z, as Student's t is against the normal
distribution, and the quantile is that of LEVEL (1 + 1/(4ν)), as there is always one more test to come (6).
"""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from .hiding import HiddenTest, Tried
from .motion import Floats, Gap, Prediction

SPREAD = 0.5
MARKER = 0.25
OTHER = 0.05
LEVEL = 0.95
MOST = 5.0
"""What a claim may move an expected error by, at most."""
Z = 1.959964


def weigh(tests: list[HiddenTest], of: int, gaps: list[Gap]) -> Floats:
    """(1): what each test counts for the gap of that index."""
    gap = gaps[of]
    about = np.array([(t.of, t.window.marker, t.keep[1] - t.keep[0]) for t in tests], np.int64).reshape(-1, 3)
    share = np.where(about[:, 0] == of, 1.0, np.where(about[:, 1] == gap.marker, MARKER, OTHER))
    return share * np.exp(-np.abs(np.log(about[:, 2] / gap.length)) / SPREAD)


def size(cov: Floats) -> float:
    """Mean over the frames of the root of the trace of covariances (L, 3, 3), mm; NaN where not all are known."""
    return float(np.sqrt(np.trace(cov, axis1=-2, axis2=-1)).mean()) if len(cov) else np.nan


class Measured:
    """What the tests of one method say of its errors: mean error and claimed size of each, mm."""

    def __init__(self, tried: list[Tried]) -> None:
        self.means = np.array([t.mean for t in tried], np.float64)
        self.claims = np.array([size(t.cov) for t in tried], np.float64)

    def expect(self, said: Prediction, weights: Floats) -> tuple[float, float]:
        """(2) and (3) mm; infinite where the method mostly had nothing to say, NaN where there is no test."""
        if not weights.sum():
            return np.nan, np.nan
        able = np.isfinite(self.means) & (weights > 0)
        w = weights[able]
        if not np.isfinite(said.xyz).all() or w.sum() < 0.5 * weights.sum():
            return np.inf, np.inf
        means, usual = self.means[able], np.average(self.claims[able], weights=w)
        here = np.sqrt(size(said.cov) / usual) if usual > 0 else 1.0
        here = float(np.clip(here, 1 / MOST, MOST)) if np.isfinite(here) else 1.0
        typical = np.exp(np.average(np.log(np.maximum(means, 1e-9)), weights=w))
        return here * float(np.average(means, weights=w)), float(typical)


class Calibration:
    """What one method's tests say of its covariances; sorted once for all gaps."""

    def __init__(self, tried: list[Tried]) -> None:
        """From all tests of the method in which it had something to say."""
        self.used = np.array([k for k, t in enumerate(tried) if len(t.error)], np.int64)
        told = [tried[k] for k in self.used]
        if not told:
            return
        errors, cov = np.concatenate([t.error for t in told]), np.concatenate([t.cov for t in told])
        self.edge = np.concatenate([t.edge for t in told])
        self.silent = not np.isfinite(cov).all()
        self.growth = Growth(self.edge, errors) if self.silent else None
        if self.growth:
            cov = self.growth.cov(self.edge)
        sd = np.sqrt(np.maximum(np.diagonal(cov, axis1=-2, axis2=-1), 1e-12))
        ratio = (np.abs(errors) / (Z * sd)).ravel()
        order = np.argsort(ratio)
        self.length = np.array([len(t.error) for t in told])
        self.test = np.repeat(np.arange(len(told)), 3 * self.length)[order]
        self.ratio = ratio[order]

    def covariance(self, said: Prediction, edge: Floats, weights: Floats) -> Floats:
        """(L, 3, 3) mm² of a prediction, `edge` (L) frames from its nearer edge; NaN where no test can tell.

        Args:
            said: the prediction.
            edge: (L).
            weights: of all tests, from `weigh`.
        """
        if not len(self.used) or not (w := weights[self.used]).sum():
            return np.full_like(said.cov, np.nan)
        shape = self.growth.cov(edge) if self.growth else said.cov
        total = np.cumsum((w / self.length)[self.test])
        dof = w.sum() ** 2 / (w**2).sum()
        level = min(LEVEL * (1 + 0.25 / dof), 0.995)  # (6)
        scale = self.ratio[np.searchsorted(total, level * total[-1])]  # (5)
        widen = stdtrit(max(dof, 2.0), (1 + LEVEL) / 2) / Z  # (6)
        return shape * (scale * widen) ** 2


class Growth:
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
