"""A Kalman smoother in few dimensions (Burke & Lasenby 2016).

The positions of all markers at time t are y(t) = μ + V s(t) with few columns V: the d greatest singular vectors of the
frames where nothing is missing, with 1 − `tolerance` of the sum of singular values. The state s takes random steps,

    s(t) = s(t − 1) + q,  q ~ N(0, Q),      y_seen(t) = (μ + V s(t))_seen + e,  e ~ N(0, r I)            (1)

and is smoothed through the gap from what is seen. Positions are taken less the mean of the markers seen in the gap
(`neighbourhood`), as otherwise the walk through the laboratory is the first component; Q is the covariance of the
steps of V⁺(y − μ), and r the mean variance that V leaves over (the paper: 10⁻³ mm²).

The smoother is solved in closed form. With Q = A Aᵀ, s = A u and Aᵀ V_seenᵀ V_seen A / r = W Λ Wᵀ, the coordinates of
Wᵀ u are independent: each is a random walk of unit steps, seen with the information λ in every frame of the gap, so

    −u(t−1) + (2 + λ) u(t) − u(t+1) = i(t),     i = Wᵀ Aᵀ V_seenᵀ (y_seen − μ) / r                       (2)

with u known beside the gap, where the marker is seen too. The sine transform turns (2) into a division: its sequences
sin(π k t / (L + 1)) have the eigenvalues 2 + λ − 2 cos(π k / (L + 1)) (3). The variance of u(t), L frames and
2 cosh θ = 2 + λ, is

    sinh(t θ) sinh((L + 1 − t) θ) / (sinh θ sinh((L + 1) θ))                                             (4)

to which comes r. A gap at an end of the path is mirrored there, which leaves its end free. The posterior from
the whole information matrix, which a Kalman smoother reaches frame by frame, is the same (a test).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from ...data.array_types import Bools, Floats, Ints
from ...data.method import ONE, parameter
from ..known_samples import KnownSamples, Span
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import Distances, distances, nearest
from .neighbourhood import Neighbourhood, columns, neighbourhood
from .stage import FILL, FillMethod


@dataclass(frozen=True, slots=True)
class LowRankKalman(FillMethod):
    """Kalman smoothing of the principal components of the markers that are near."""

    tolerance: float = parameter(
        0.01, unit=ONE, above=0, below=1,
        meaning="share of the sum of singular values that the components may leave out (the paper: 0.0025)",
    )  # fmt: skip
    measurement_sd: float | None = parameter(
        None, unit="mm", above=0,
        meaning="standard deviation of the measurements, √r; None: what the components leave over",
    )  # fmt: skip
    most_markers: int = parameter(12, unit="markers", low=2, meaning="nearest markers used at most")


class Walk(NamedTuple):
    """(2) for one marker and the others at hand, with the letters of the derivation.

    Attributes:
        hood: the markers.
        mean: (3 K) mm, μ.
        VAW: (3 K, d) V A W: positions of the independent coordinates.
        information: (d) λ.
        r: mm².
    """

    hood: Neighbourhood
    mean: Floats
    VAW: Floats
    information: Floats
    r: float

    @property
    def n(self) -> int:
        """Columns seen in the gap."""
        return 3 * self.hood.n_seen


class _LearntDynamics(NamedTuple):
    """What gaps of a call share."""

    distances: Distances
    frames: Ints
    walks: dict[tuple[int, bytes], Walk | None]


@FILL.method("low_rank_kalman", LowRankKalman, rank=12, source="Burke and Lasenby 2016")
def fill_low_rank_kalman(
    motion: MarkerArray, gaps: list[Gap], *, method: LowRankKalman = LowRankKalman()
) -> list[Prediction]:
    """Each gap from the markers seen throughout it."""
    known = KnownSamples.of(motion)
    learnt = _LearntDynamics(distances(known), known.thin(), {})
    return [_smooth(known, known.span(gap), learnt, method) for gap in gaps]


def _smooth(known: KnownSamples, span: Span, learnt: _LearntDynamics, method: LowRankKalman) -> Prediction:
    if not span.edges:
        return Prediction.none(span.length, known.never(span))
    there = known.throughout(span.start, span.stop, but=span.marker)
    walk = _walk(known, span.marker, there, learnt, method)
    if walk is None:
        return Prediction.none(span.length, "needs two markers seen throughout the gap and, with this one, elsewhere")
    seen = walk.hood._replace(markers=walk.hood.markers[: walk.hood.n_seen])
    Y, centre = columns(known, seen, span.frames)
    i = (Y - walk.mean[: walk.n]) @ walk.VAW[: walk.n] / walk.r
    beside = [_beside(known, walk, f) if f >= 0 else None for f in (span.before, span.after)]
    u, variance = solve(walk.information, i, *beside)
    target = walk.VAW[-3:]
    cov = np.einsum("id,td,jd->tij", target, variance, target) + walk.r * np.eye(3)
    references = tuple(int(k) for k in seen.markers)
    return Prediction(u @ target.T + walk.mean[-3:] + centre, cov, references=references)


def _beside(known: KnownSamples, walk: Walk, frame: int) -> Floats | None:
    """u (d) at a frame where the marker is seen, from all that is seen there; None where the centre is not known."""
    Y, centre = columns(known, walk.hood, np.array([frame]))
    seen = ~np.isnan(Y[0])
    if not seen[-3:].all() or np.isnan(centre).any():
        return None
    B = walk.VAW[seen]
    prior = 1e-9 * np.trace(B.T @ B) * np.eye(B.shape[1])
    return np.asarray(np.linalg.solve(B.T @ B + prior, B.T @ (Y[0] - walk.mean)[seen]))


def solve(information: Floats, i: Floats, before: Floats | None, after: Floats | None) -> tuple[Floats, Floats]:
    """(2) for i (L, d): u (L, d) and its variance (L, d).

    Args:
        information: (d) λ.
        i: (L, d).
        before: (d) u before the gap; None: the gap is at the beginning of the path.
        after: (d) u after it; None: the gap is at its end. Where both are None, nothing but i speaks.
    """
    if before is None and after is None:
        u = i / np.maximum(information, 1e-12)
        return u, np.broadcast_to(1 / np.maximum(information, 1e-12), u.shape)
    if before is None:
        u, variance = solve(information, i[::-1], after, None)
        return u[::-1], variance[::-1]
    L = len(i)
    if after is None:  # mirrored: twice the way, half of which is kept
        i, after = np.concatenate([i, i[::-1]]), before
    n = len(i)
    rhs = i.copy()
    rhs[0] += before
    rhs[-1] += after
    k = np.arange(1, n + 1)[:, None]
    u = scipy.fft.dst(
        scipy.fft.dst(rhs, type=1, axis=0) / (2 + information - 2 * np.cos(np.pi * k / (n + 1))), type=1, axis=0
    )  # (3)
    return (u / (2 * (n + 1)))[:L], _variance(information, n, mirrored=n > L)[:L]


def _variance(information: Floats, n: int, *, mirrored: bool) -> Floats:
    """(4) for n frames (n, d); mirrored, the variance of the sum of two like halves, as each half says all there is."""
    theta = np.arccosh(1 + np.maximum(information, 1e-9) / 2)
    t = np.arange(1, n + 1)[:, None]
    away = (1 - np.exp(-2 * t * theta)) * (1 - np.exp(-2 * (n + 1 - t) * theta))
    variance = away / ((1 - np.exp(-2 * (n + 1) * theta)) * 2 * np.sinh(theta))
    if mirrored:  # cov(t, t') with its own image t' = n + 1 − t: the free end has var + cov
        near = np.minimum(t, n + 1 - t)
        fold = np.exp(-(n + 1 - 2 * near) * theta) * (1 - np.exp(-2 * near * theta)) ** 2
        variance = variance + fold / ((1 - np.exp(-2 * (n + 1) * theta)) * 2 * np.sinh(theta))
    return variance


def _walk(
    known: KnownSamples, marker: int, there: Bools, learnt: _LearntDynamics, method: LowRankKalman
) -> Walk | None:
    near = nearest(learnt.distances(marker).mean, there, method.most_markers)
    key = (marker, near.tobytes())
    if key not in learnt.walks:
        frames = learnt.frames
        hood = neighbourhood(known, near, np.array([marker]), frames=frames, least=min(200, len(frames) // 3))
        learnt.walks[key] = _learn(known, hood, method) if hood else None
    return learnt.walks[key]


def _learn(known: KnownSamples, hood: Neighbourhood, method: LowRankKalman) -> Walk | None:
    Y, _ = columns(known, hood, hood.frames)
    mean = Y.mean(0)
    e, V = np.linalg.eigh((Y - mean).T @ (Y - mean) / len(Y))
    s = np.sqrt(np.maximum(e[::-1], 0.0))
    d = int(np.searchsorted(np.cumsum(s), (1 - method.tolerance) * s.sum())) + 1
    d = min(d, int((s > 1e-6 * max(s[0], 1e-3)).sum()))
    steps = _steps(known, hood) @ V[:, ::-1][:, :d]
    if not d or not len(steps):
        return None
    V = V[:, ::-1][:, :d]
    r = method.measurement_sd**2 if method.measurement_sd else max(float((s[d:] ** 2).sum()) / (len(s) - d), 1e-3)
    q, A = np.linalg.eigh(steps.T @ steps / len(steps))
    A = A * np.sqrt(np.maximum(q, 1e-9 * q[-1] + 1e-12))
    B = V[: 3 * hood.n_seen] @ A
    information, W = np.linalg.eigh(B.T @ B / r)
    return Walk(hood, mean, V @ A @ W, np.maximum(information, 0.0), r)


def _steps(known: KnownSamples, hood: Neighbourhood) -> Floats:
    """Steps (N, 3 K) from one frame to the next, where all are seen in both."""
    frames = hood.frames[hood.frames + 1 < known.n_frames]
    frames = frames[known.seen[hood.markers, frames[:, None] + 1].all(1)]
    now, then = (columns(known, hood, f)[0] for f in (frames, frames + 1))
    return then - now
