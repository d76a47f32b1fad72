"""What a method leaves over goes on into the gap: its residuals at the edges correct it inside.

A method predicts a marker also where it is seen, and is off by the residual r(t), of mean square C₀ = E r rᵀ and with
the autocorrelation

    ρ(k) = 2 Σ r(t) · r(t + k) / Σ (|r(t)|² + |r(t + k)|²)                                              (1)

over all pairs of frames where r is known. (Divided by all frames' |r|² instead, it fell with every pair that a hole
takes away: a trial with holes seemed to have residuals that hardly last a frame.) Lags of few pairs tell little, so it
is less there, in proportion. In a gap the residuals r(a), r(b) of the known samples on both sides say how it goes on
there, as simple kriging has it:

    r̂(t) = w_a r(a) + w_b r(b),     [1 + ν   ρ(b−a); ρ(b−a)   1 + ν] w = [ρ(t−a); ρ(b−t)]               (2)
    cov(t) = C₀ (1 − w · [ρ(t−a), ρ(b−t)])                                                              (3)

with the three ρ of t, a and b changed as little as makes them those of any residual: their matrix, with 1 in the
diagonal, has no negative eigenvalues then (4). A residual that lasts is carried through the whole gap, one that is gone
after a few frames only bends the ends; the covariance is small at the edges and C₀ far from them. All of it turns with
the laboratory. ν keeps (2) solvable.

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


TELLING = 0.1
"""Share of the known frames that the pairs of a lag are, from which (1) is taken as it is; chosen."""


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
        square = (r * r).sum(1)
        n = scipy.fft.next_fast_len(2 * len(r), real=True)
        of_r, of_square, of_known = (scipy.fft.rfft(x, n, axis=0) for x in (r, square, known.astype(np.float64)))
        spectra = (np.abs(of_r) ** 2).sum(1), (of_square * of_known.conj()).real, np.abs(of_known) ** 2
        products, squares, pairs = (scipy.fft.irfft(x, n)[: len(r)] for x in spectra)
        told = (pairs > 0.5) & (squares > 1e-9 * squares[0])
        rho = np.divide(products, squares, out=np.zeros(len(r)), where=told)  # (1)
        rho *= np.minimum(pairs / (TELLING * pairs[0]), 1.0)
        return cls(r.T @ r / known.sum(), np.clip(rho, -1.0, 1.0), step)

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
    to, among = left.at(np.abs(frames[:, None] - at)), left.at(np.abs(at[:, None] - at))
    to, among = _consistent(to, among)
    among = among + NUGGET * np.eye(len(at))
    w = np.linalg.solve(among, to[..., None])[..., 0]  # (2)
    rest = np.clip(1 - (w * to).sum(1), 0.0, 1.0)
    return w @ beside[there], rest[:, None, None] * left.cov  # (3)


def _consistent(to: Floats, among: Floats) -> tuple[Floats, Floats]:
    """(4): ρ of frames and edges (L, E), and of the edges among themselves, (L, E, E) as they are with each frame."""
    n = 1 + len(among)
    whole = np.ones((len(to), n, n))
    whole[:, 0, 1:] = whole[:, 1:, 0] = to
    whole[:, 1:, 1:] = among
    whole[:, range(n), range(n)] = 1.0  # of residuals that are all 0 too
    size, along = np.linalg.eigh(whole)
    whole = (along * np.maximum(size, 0.0)[:, None]) @ along.mT
    scale = np.sqrt(np.diagonal(whole, axis1=1, axis2=2))
    whole /= scale[:, :, None] * scale[:, None]
    return whole[:, 0, 1:], whole[:, 1:, 1:]
