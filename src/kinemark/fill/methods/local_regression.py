"""A marker regressed on the markers around it, in the local frame of its body part.

The base of marker y are the three whose distance from y varies least over the trial, of those seen throughout the gap
that do not jump in it (`jumping_markers`); its frame is (R, c) (see `local_frames`). In that frame y and the reference
markers x₁ … x_D have local coordinates, so that only what is not rigid is left to explain, and

    Rᵀ(y − c) = a + B φ,        φ = the reference markers' local coordinates less their means                     (1)

has the ridge solution B = (Σ (yφᵀ)) (Σ φφᵀ + λ n I)⁻¹ over the n frames where all are seen (2) (Hoerl & Kennard 1970).
How many reference markers and which λ is chosen by skill: the frames are cut into blocks of the length of a gap, and
each block is predicted from the sums (2) of all frames less its own (3), so that a trial is passed once whatever is
tried. Reference markers are ranked by how little their distance from y varies. Last, what remains at both edges of the
gap is added, linear between them (4).

With C the covariance of what remains of (1) over the n frames, and b(t) from 0 at the edges to 1 in the middle, the
error of a gap of L frames is stated to be that of a random walk tied to its edges, the greater the farther φ is from
what was learnt from,

    L b(t) C (1 + d(t) / d̄) / 2,     d = φᵀ (Σ φφᵀ + λ n I)⁻¹ φ,     d̄ = mean of d over the n frames                (5)

d is what the variance of a ridge regression grows by (Rasmussen & Williams 2006, 2.11), and its scale is left to the
hold-out gaps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...data.method import parameter
from ..jumping_markers import JumpingMarkers
from ..known_samples import KnownSamples, Span
from ..local_frames import local, triad
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_ranking import FEWEST, Ranks
from .stage import FILL, FillMethod

MOST = 400
"""Frames to learn from, evenly spread; neighbours in time say the same; chosen."""
LEAST = 1e-9
"""d̄ of (5) at least, without unit: of reference markers that never move in the local frame; by definition."""


@dataclass(frozen=True, slots=True)
class LocalRegression(FillMethod):
    """Ridge regression on several reference markers in a local frame."""

    marker_counts: tuple[int, ...] = parameter(
        (6, 12), unit="markers", low=1, meaning="numbers of reference markers that are tried"
    )
    ridges: tuple[float, ...] = parameter(
        (0.3, 3.0, 30.0), unit="mm²", above=0, high=math.inf, meaning="λ, weights of the ridge, that are tried"
    )
    folds: int = parameter(4, unit="folds", low=2, meaning="of the cross-validation: blocks of training frames")

    def check_together(self) -> None:
        """Refuse empty lists."""
        if not self.marker_counts or not self.ridges:
            raise ValueError(f"marker_counts {self.marker_counts} and ridges {self.ridges} must not be empty")


class RegressionFit(NamedTuple):
    """What a marker's regression came to: base, reference markers in use, their means, weights (1), C and d / d̄ (5)."""

    base: Ints
    references: Ints
    mean: Floats
    a: Floats
    B: Floats
    C: Floats
    D: Floats


@FILL.method("local_regression", LocalRegression, rank=13, source="Hoerl and Kennard 1970")
def fill_local_regression(motion: MarkerArray, gaps: list[Gap], *, method: LocalRegression) -> list[Prediction]:
    """Each gap from the reference markers seen throughout it; gaps of one marker with the same ones share a fit."""
    fits: dict[tuple[int, bytes], RegressionFit | str] = {}
    seen, ranks, out = motion.seen, Ranks(motion), []
    trust, known = JumpingMarkers(motion, ranks), KnownSamples.of(motion)
    for gap in gaps:
        ready = seen[:, gap.start : gap.stop].all(1) & trust.of(gap)
        order = ranks.of(gap.marker)
        order = order[ready[order]][: max(3, *method.marker_counts)]
        key = (gap.marker, order.tobytes())
        if key not in fits:
            fits[key] = _fit(motion, seen, gap.marker, order, method)
        fit = fits[key]
        out.append(Prediction.none(gap.length, fit) if isinstance(fit, str) else _predict(motion, known.span(gap), fit))
    return out


def _fit(motion: MarkerArray, seen: Bools, marker: int, order: Ints, method: LocalRegression) -> RegressionFit | str:
    """The best of the numbers of reference markers and ridges for one marker; a sentence where there is none."""
    if len(order) < 3:
        return f"only {len(order)} other markers are seen throughout the gap and often enough beside it; wanted 3"
    base, references = order[:3], order[: max(method.marker_counts)]
    together = np.flatnonzero(seen[[marker, *references, *base]].all(0))
    if len(together) < FEWEST:
        return f"the marker and its reference markers are seen together in {len(together)} frames only; wanted {FEWEST}"
    frames = together[:: -(-len(together) // MOST)]
    R, c = triad(motion.xyz[base[:, None], frames])
    if not np.isfinite(R).all():
        return "the markers around it stand on one line or in one point: they carry no local frame"
    y = local(R, c, motion.xyz[marker, frames])
    phi = _features(motion, references, frames, R, c)
    mean, a = phi.mean(0), y.mean(0)
    n, ridge = _most_skilled(phi - mean, y - a, method)
    phi, y = phi[:, : 3 * n] - mean[: 3 * n], y - a
    P = np.linalg.inv(phi.T @ phi + ridge * len(frames) * np.eye(3 * n))
    B = P @ (phi.T @ y)  # (2)
    usual = float(_squares(phi, P).mean())
    return RegressionFit(base, references[:n], mean[: 3 * n], a, B, np.cov((y - phi @ B).T), P / max(usual, LEAST))


def _squares(phi: Floats, P: Floats) -> Floats:
    """d (F) of (5)."""
    return np.asarray(np.einsum("fi,ij,fj->f", phi, P, phi))


def _features(motion: MarkerArray, references: Ints, frames: Ints, R: Floats, c: Floats) -> Floats:
    """(F, 3 D) local coordinates of the reference markers."""
    apart = motion.xyz[references, frames[:, None]] - c[:, None]
    return (apart @ R).reshape(len(frames), -1)


def _most_skilled(phi: Floats, y: Floats, method: LocalRegression) -> tuple[int, float]:
    """Number of reference markers and ridge that predict blocks of frames best that they have not seen (3)."""
    N = min(method.folds, len(y))
    n = len(y) // N
    phi, y = phi[: N * n].reshape(N, n, -1), y[: N * n].reshape(N, n, 3)
    G, C = phi.mT @ phi, phi.mT @ y
    G, C = G.sum(0) - G, C.sum(0) - C  # (3)
    D, n_left = phi.shape[2] // 3, (N - 1) * n
    way = np.linspace(0, 1, n)[:, None]
    best, chosen = np.inf, (min(method.marker_counts), method.ridges[-1])
    for many in sorted({min(number, D) for number in method.marker_counts}):
        p = slice(0, 3 * many)
        ridge = n_left * np.array(method.ridges)[:, None, None, None] * np.eye(3 * many)
        rest = y - phi[..., p] @ np.linalg.solve(G[:, p, p] + ridge, C[:, p])  # (2) for each ridge and block
        rest -= rest[..., :1, :] + way * (rest[..., -1:, :] - rest[..., :1, :])  # (4)
        loss = np.square(rest).sum((1, 2, 3))
        if loss.min() < best:
            best, chosen = loss.min(), (many, method.ridges[int(loss.argmin())])
    return chosen


def _predict(motion: MarkerArray, span: Span, fit: RegressionFit) -> Prediction:
    frames = np.arange(max(span.start - 1, 0), min(span.stop + 1, motion.xyz.shape[1]))
    R, c = triad(motion.xyz[fit.base[:, None], frames])
    phi = _features(motion, fit.references, frames, R, c) - fit.mean
    xyz = c + np.einsum("fij,fj->fi", R, fit.a + phi @ fit.B)  # (1)
    xyz = xyz + _bridge_residuals(motion.xyz[span.marker, frames] - xyz)
    inner = slice(span.start - frames[0], span.stop - frames[0])
    size = span.length * span.bow() * (1 + _squares(phi[inner], fit.D)) / 2
    cov = size[:, None, None] * (R[inner] @ fit.C @ R[inner].mT)  # (5)
    return Prediction(xyz[inner], cov, references=tuple(int(d) for d in fit.references))


def _bridge_residuals(rest: Floats) -> Floats:
    """(4): residuals known at one or both ends, linear between them; zero where neither is known."""
    known = [e for e in (0, len(rest) - 1) if np.isfinite(rest[e]).all()]
    if not known:
        return np.zeros_like(rest)
    first, last = rest[known[0]], rest[known[-1]]
    return np.linspace(first, last, len(rest))
