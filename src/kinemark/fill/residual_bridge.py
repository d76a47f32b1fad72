"""What a method leaves over goes on into the gap: its residuals at the edges correct it inside.

A method predicts a marker also where it is seen, and is off by the residual r(t), of mean square C₀ = E r rᵀ and with
the autocorrelation

    ρ(k) = Σ r(t) · r(t + k) / Σ |r(t)|²                                                                (1)

over all frames where r is known, pairs with an unknown one left out (so ρ is positive semidefinite). In a gap the
residuals r(a), r(b) of the known samples on both sides say how it goes on there, as simple kriging has it:

    r̂(t) = w_a r(a) + w_b r(b),     [1 + ν   ρ(b−a); ρ(b−a)   1 + ν] w = [ρ(t−a); ρ(b−t)]               (2)
    cov(t) = C₀ (1 − w · [ρ(t−a), ρ(b−t)])                                                              (3)

A residual that lasts is carried through the whole gap, one that is gone after a few frames only bends the ends; the
covariance is small at the edges and C₀ far from them. All of it turns with the laboratory. ν keeps (2) solvable.

Source: the interpolation of a stationary random function (Cressie 1993, chapter 3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Floats
from .known_samples import Span

NUGGET = 1e-6
"""ν, as a share of the residual's variance: what is added for noise; chosen (see benchmarks/gaps.py)."""


class Leftover(NamedTuple):
    """What a method leaves over in known frames.

    Attributes:
        cov: (3, 3) mm², C₀.
        rho: (K) autocorrelation, at lags of `step` frames.
        step: frames.
    """

    cov: Floats
    rho: Floats
    step: int

    @classmethod
    def of(cls, residual: Floats, step: int) -> Leftover:
        """From residuals (F, 3) every `step` frames, NaN where unknown; at least one is known."""
        known = ~np.isnan(residual[:, 0])
        r = np.where(known[:, None], residual, 0.0)
        n = scipy.fft.next_fast_len(2 * len(r), real=True)
        power = (np.abs(scipy.fft.rfft(r, n, axis=0)) ** 2).sum(1)
        rho = scipy.fft.irfft(power, n)[: len(r)]  # (1)
        square = max(float((r * r).sum()), np.finfo(float).tiny)
        return cls(r.T @ r / known.sum(), rho / square, step)

    def at(self, lag: Floats) -> Floats:
        """ρ at any lags, frames."""
        return np.interp(lag, self.step * np.arange(len(self.rho)), self.rho, right=0.0)


def bridge(left: Leftover, span: Span, frames: Floats, beside: Floats) -> tuple[Floats, Floats]:
    """r̂ (L, 3) mm and its covariance (L, 3, 3) at frames (L).

    Args:
        left: of the method.
        span: the gap.
        frames: (L) of it, or of a part.
        beside: (2, 3) residuals before and after it, NaN where there is none.
    """
    there = np.flatnonzero(~np.isnan(beside[:, 0]))
    if not len(there):
        return np.zeros((len(frames), 3)), np.broadcast_to(left.cov, (len(frames), 3, 3)).copy()
    at = np.array([span.before, span.after], np.float64)[there]
    to = left.at(np.abs(frames[:, None] - at))
    among = left.at(np.abs(at[:, None] - at)) + NUGGET * np.eye(len(at))
    w = np.linalg.solve(among, to.T).T  # (2)
    rest = np.clip(1 - (w * to).sum(1), 0.0, 1.0)
    return w @ beside[there], rest[:, None, None] * left.cov  # (3)
