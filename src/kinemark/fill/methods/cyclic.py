"""Cyclic filling: what the marker did one cycle before or after.

The cycle is found from the trial: with v(t) the velocities of all markers less their means,

    ρ(k) = Σ v(t) · v(t + k) / √(Σ |v(t)|² Σ |v(t + k)|²)    over all t where both are known             (1)

has a peak at every whole number of cycles; the first peak that comes near to the highest is one cycle. Around each
multiple n of it, forward and backward, the lag is refined for this gap: the one at which the marker and its neighbours
move in the gap's surroundings as they do here,

    m(k) = mean |v(t) − v(t − k)|²    over the gap and a margin, where known                             (2)

is least. A repeat is the marker's own path at that lag, y(t) = x(t − k), taken over to the gap by the offsets at
both edges, which go linearly from one to the other, as a walk goes on and drifts (3). Repeats are averaged with weights
w ∝ 1 / m, Σ w = 1.

How unlike the cycles are is how wrong a repeat is: a velocity that is off by √m all through a gap of L frames takes the
marker √m L away. With the mean over the same places

    M(k) = mean (v(t) − v(t − k)) (v(t) − v(t − k))ᵀ,      whose trace is m,

the covariance has the shape

    Σ_k w_k M(k) L² 4 s (1 − s),     s from 0 to 1 over the gap                                            (4)

Over hold-out gaps of half a second, ln error over ln √m L has a slope of 1.0 to 1.5 and r = 0.4 to 0.97 (five trials).
So the hold-out gaps of a trial of a few strides, which find the next cycle hidden by the gap itself and are filled from
one less like it, do not make the gap look as bad as they are.

Source: common in motion capture systems; the finding of the cycle is an autocorrelation (Box & Jenkins 1970).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from ...data.array_types import Floats, Ints
from ...data.method import ONE, parameter
from ..known_samples import KnownSamples, Span
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import Distances, distances, nearest
from .stage import FILL, FillMethod

FINE = 1500
"""Frames to which a trial is thinned to find its cycle; chosen (see benchmarks/gaps.py)."""
NEIGHBOURS = 6  # markers that cycles are compared by; chosen (see benchmarks/gaps.py)
INSTANTS = 16
"""Instants at which (2) is taken for a gap; chosen (see benchmarks/gaps.py)."""


@dataclass(frozen=True, slots=True)
class Cyclic(FillMethod):
    """The same part of other cycles of a motion that comes again, fitted to the gap's edges."""

    period: float | None = parameter(None, unit="s", above=0, meaning="of the cycle; None: estimated from the trial")
    shortest_period: float = parameter(0.3, unit="s", above=0, meaning="shortest cycle that is looked for")
    min_correlation: float = parameter(
        0.4, unit=ONE, low=-1, high=1,
        meaning="least correlation ρ at the peak, below which the motion does not count as cyclic",
    )  # fmt: skip
    most_cycles: int = parameter(
        4, unit="cycles", low=1, meaning="most cycles averaged, those most correlated with the gap's sides"
    )
    period_variation: float = parameter(
        0.12, unit=ONE, above=0, meaning="share of itself by which a cycle may be longer or shorter than the mean one"
    )
    margin: float = parameter(0.2, unit="s", above=0, meaning="how much before and after the gap is compared")


class _LearntCycle(NamedTuple):
    """What gaps of a call share: the cycle in frames (0: none), velocities (M, F, 3), mean distances."""

    period: float
    velocity: Floats
    distances: Distances


@FILL.method("cyclic", Cyclic, rank=6)
def fill_cyclic(motion: MarkerArray, gaps: list[Gap], *, method: Cyclic = Cyclic()) -> list[Prediction]:
    """Each gap from other cycles of its own marker."""
    known = KnownSamples.of(motion)
    if not gaps:
        return []
    period = (
        method.period * known.rate
        if method.period
        else find_period(known, method.shortest_period, method.min_correlation)
    )
    velocity = np.full_like(known.x, np.nan)
    velocity[:, 1:-1] = (known.x[:, 2:] - known.x[:, :-2]) / 2
    learnt = _LearntCycle(period, velocity, distances(known))
    return [_repeat(known, known.span(gap), learnt, method) for gap in gaps]


def find_period(known: KnownSamples, shortest: float, min_correlation: float) -> float:
    """Frames of one cycle, from (1); 0 where the trial shows no two like cycles."""
    step = max(1, -(-known.n_frames // FINE))
    x = known.x[known.seen.any(1), ::step]
    v = np.diff(x, axis=1)
    there = ~np.isnan(v[..., :1])
    v = np.where(there, v, 0.0)
    v = np.where(there, v - v.sum(1, keepdims=True) / np.maximum(there.sum(1, keepdims=True), 1), 0.0)
    first, last = max(2, round(shortest * known.rate / step)), int(0.7 * v.shape[1])
    if last - first < 3:
        return 0.0
    rho = _correlation(v, there.astype(np.float64), last + 1)
    k = np.arange(first, last)
    peak = k[(rho[k] >= rho[k - 1]) & (rho[k] > rho[k + 1])]
    if not len(peak) or not rho[peak].max() >= min_correlation:
        return 0.0
    one = int(peak[rho[peak] >= rho[peak].max() - 0.15 * (1 - min_correlation)][0])
    bend = rho[one - 1] - 2 * rho[one] + rho[one + 1]
    return step * (one + (0.5 * (rho[one - 1] - rho[one + 1]) / bend if bend < 0 else 0.0))


def _correlation(v: Floats, there: Floats, n: int) -> Floats:
    """(1) at lags 0 … n − 1."""
    size = scipy.fft.next_fast_len(2 * v.shape[1], real=True)
    V, P, T = (scipy.fft.rfft(a, size, axis=1) for a in (v, (v * v).sum(-1, keepdims=True), there))
    product, before, behind = (
        scipy.fft.irfft(s.sum((0, 2)), size)[:n] for s in (V.conj() * V, T.conj() * P, P.conj() * T)
    )
    norm = np.sqrt(np.maximum(before, 0.0) * np.maximum(behind, 0.0))
    return np.divide(product, norm, out=np.zeros(n), where=norm > 1e-9 * max(norm[0], 1e-300))


def _repeat(known: KnownSamples, span: Span, learnt: _LearntCycle, method: Cyclic) -> Prediction:
    if not span.edges:
        return Prediction.none(span.length, known.never(span))
    if not learnt.period:
        return Prediction.none(span.length, "no two cycles of the trial resemble each other")
    around = _surroundings(known, span, learnt, method)
    found = _lags(known, span, learnt, around, method)
    if not found:
        return Prediction.none(span.length, "no other cycle shows this part of the marker's path")
    found = sorted(found)[: method.most_cycles]
    weight = 1 / np.maximum([m for m, _ in found], 1e-12 + 1e-3 * found[0][0])
    weight /= weight.sum()
    mean = np.einsum("k,kti->ti", weight, [_taken_over(known, span, lag) for _, lag in found])
    M = np.einsum("k,kij->ij", weight, [_products(learnt.velocity, around, round(lag)) for _, lag in found])
    return Prediction(mean, span.bow()[:, None, None] * M * span.length**2)  # (4)


class _Surroundings(NamedTuple):
    """What cycles are compared by: markers (W, 1), instants (T), their velocities there (W, T, 3)."""

    who: Ints
    t: Ints
    velocity: Floats


def _reach(span: Span) -> tuple[int, int]:
    """First and last frame that a repeat must show: the gap and the known samples beside it."""
    return min(span.edges[0], span.start), max(span.edges[-1], span.stop - 1)


def _surroundings(known: KnownSamples, span: Span, learnt: _LearntCycle, method: Cyclic) -> _Surroundings:
    low, high = _reach(span)
    margin = round(method.margin * known.rate)
    t = np.unique(np.linspace(low - margin, high + margin, INSTANTS).round().astype(np.int64))
    t = t[(t >= 0) & (t < known.n_frames)]
    near = nearest(learnt.distances(span.marker).mean, known.throughout(low, high + 1, but=span.marker), NEIGHBOURS)
    who = np.append(near, span.marker)[:, None]
    return _Surroundings(who, t, learnt.velocity[who, t])


def _lags(
    known: KnownSamples, span: Span, learnt: _LearntCycle, around: _Surroundings, method: Cyclic
) -> list[tuple[float, float]]:
    """(m, lag in frames) of every repeat that shows the whole gap."""
    low, high = _reach(span)
    unseen = np.concatenate([[0], np.cumsum(~known.seen[span.marker])])
    each = []
    for n in [n for k in range(1, method.most_cycles + 1) for n in (-k, k)]:
        lags = np.arange(
            round((n - method.period_variation) * learnt.period),
            round((n + method.period_variation) * learnt.period) + 1,
        )
        lags = lags[(low - lags >= 0) & (high - lags < known.n_frames)]
        lags = lags[unseen[high + 1 - lags] == unseen[low - lags]]
        if len(lags):
            each.append(lags)
    return [(m, lag) for m, lag in _refined(learnt.velocity, *around, each) if np.isfinite(m)]


def _refined(velocity: Floats, who: Ints, t: Ints, here: Floats, each: list[Ints]) -> list[tuple[float, float]]:
    """The least (2) and its lag, for each of several sets of lags: coarse first, then every frame, then between."""
    steps = [max(1, len(lags) // 8) for lags in each]
    coarse = [lags[step // 2 :: step] for lags, step in zip(each, steps, strict=True)]
    best = [lags[np.argmin(m)] for lags, m in zip(coarse, _mismatches(velocity, who, t, here, coarse), strict=True)]
    fine = [lags[np.abs(lags - b) <= step] for lags, b, step in zip(each, best, steps, strict=True)]
    return [_between(lags, m) for lags, m in zip(fine, _mismatches(velocity, who, t, here, fine), strict=True)]


def _between(fine: Ints, m: Floats) -> tuple[float, float]:
    """The least m and where between the lags it lies, by a parabola."""
    k = int(np.argmin(m))
    if not 0 < k < len(m) - 1 or not np.isfinite(m[k - 1 : k + 2]).all():
        return float(m[k]), float(fine[k])
    bend = m[k - 1] - 2 * m[k] + m[k + 1]
    return float(m[k]), float(fine[k] + (0.5 * (m[k - 1] - m[k + 1]) / bend if bend > 0 else 0.0))


def _mismatches(velocity: Floats, who: Ints, t: Ints, here: Floats, each: list[Ints]) -> list[Floats]:
    """(2) at several sets of lags."""
    if not each:
        return []
    m = _mismatch(velocity, who, t, here, np.concatenate(each))
    return np.split(m, np.cumsum([len(lags) for lags in each])[:-1])


def _mismatch(velocity: Floats, who: Ints, t: Ints, here: Floats, lags: Ints) -> Floats:
    """(2) at lags (K), infinite where nothing can be compared."""
    difference = _differences(velocity, who, t, here, lags)
    square = np.einsum("wkti,wkti->wkt", difference, difference)
    known = ~np.isnan(square)
    n = known.sum((0, 2))
    return np.divide(np.where(known, square, 0.0).sum((0, 2)), n, out=np.full(len(lags), np.inf), where=n > 0)


def _differences(velocity: Floats, who: Ints, t: Ints, here: Floats, lags: Ints) -> Floats:
    """v(t − k) − v(t) at lags (K): (W, K, T, 3), NaN where one is not known."""
    then = t - lags[:, None]
    inside = (then >= 0) & (then < velocity.shape[1])
    at = who[:, None] * velocity.shape[1] + np.where(inside, then, 0)
    there = velocity.reshape(-1, 3).take(at, axis=0)
    return np.where(inside[..., None], there - here[:, None], np.nan)


def _products(velocity: Floats, around: _Surroundings, lag: int) -> Floats:
    """(3, 3) M of (4) at the frame nearest to a lag."""
    difference = _differences(velocity, *around, np.array([lag])).reshape(-1, 3)
    difference = difference[~np.isnan(difference[:, 0])]
    return np.asarray(difference.T @ difference / max(len(difference), 1))


def _taken_over(known: KnownSamples, span: Span, lag: float) -> Floats:
    """(3): the repeat at a lag, between frames read linearly, in the gap (L, 3)."""
    at = np.concatenate([span.frames, [span.edges[0], span.edges[-1]]]) - lag
    low = np.floor(at).astype(np.int64)
    part = (at - low)[:, None]
    x = known.x[span.marker]
    last = len(x) - 1
    a, b = x[np.clip(low, 0, last)], x[np.clip(low + 1, 0, last)]
    y = np.where(np.isnan(b) | (part == 0), a, np.where(np.isnan(a), b, (1 - part) * a + part * b))
    first, end = x[span.edges[0]] - y[-2], x[span.edges[-1]] - y[-1]
    s = span.share_of_after()
    return y[:-2] + (1 - s) * first + s * end
