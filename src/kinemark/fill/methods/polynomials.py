"""A polynomial across the gap, through the marker's own samples beside it.

Through n known samples on each side goes one polynomial of degree 2 n − 1 in time, for each coordinate (Lagrange):

    x̂(t) = Σ_j x(t_j) Π_{i≠j} (t − t_i) / (t_j − t_i)                                                    (1)

n = 1 is a straight line, n = 2 the cubic. What (1) is off half way through a gap of this length is measured in the
frames where the marker is seen, with the same spacing; towards the edges the error falls as that of a smooth motion,
with its square as (4 a (1 − a))², a from 0 to 1 through the gap (2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...data.array_types import Floats, Ints
from ...data.method import parameter
from ..known_samples import KnownSamples, Span
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import INSTANTS, covariance, rounded
from .stage import FILL, FillMethod


@dataclass(frozen=True, slots=True)
class Linear(FillMethod):
    """A straight line from the last sample before the gap to the first after it."""


@dataclass(frozen=True, slots=True)
class Cubic(FillMethod):
    """The cubic through two samples on each side."""

    margin: float = parameter(
        0.1, unit="s", above=0, high=math.inf, meaning="both samples of a side must lie so near to the gap"
    )


@FILL.method("linear", Linear, rank=1)
def fill_linear(motion: MarkerArray, gaps: list[Gap], *, method: Linear = Linear()) -> list[Prediction]:
    """Straight lines; a gap at an end of the marker's path has none."""
    return _fill(KnownSamples.of(motion), gaps, samples=1, margin=np.inf)


@FILL.method("cubic", Cubic, rank=2)
def fill_cubic(motion: MarkerArray, gaps: list[Gap], *, method: Cubic = Cubic()) -> list[Prediction]:
    """Cubics; a gap needs two samples near each side."""
    return _fill(KnownSamples.of(motion), gaps, samples=2, margin=method.margin)


def _fill(known: KnownSamples, gaps: list[Gap], *, samples: int, margin: float) -> list[Prediction]:
    measured: dict[tuple[int, int], Floats] = {}
    return [_bridge(known, known.span(gap), samples, margin, measured) for gap in gaps]


def _bridge(
    known: KnownSamples, span: Span, samples: int, margin: float, measured: dict[tuple[int, int], Floats]
) -> Prediction:
    t = beside(known, span, samples, max(samples, round(min(margin, known.n_frames / known.rate) * known.rate)))
    if len(t) < 2 * samples:
        some = "a sample" if samples == 1 else f"{samples} samples close by"
        return Prediction.none(span.length, known.never(span) or f"needs {some} on both sides of the gap")
    xyz = lagrange(t, span.frames) @ known.x[span.marker, t]  # (1)
    key = (span.marker, rounded(span.half))
    if key not in measured:
        measured[key] = _half_way(known, *key, samples)
    return Prediction(xyz, (span.bow() ** 2)[:, None, None] * measured[key])  # (2)


def beside(known: KnownSamples, span: Span, samples: int, reach: int) -> Ints:
    """Up to so many frames on each side of a gap in which its marker is seen, within a reach in frames, in order."""
    seen = known.seen[span.marker]
    low = max(span.before + 1 - reach, 0) if span.before >= 0 else 0
    first = low + np.flatnonzero(seen[low : span.before + 1])[-samples:]
    last = (
        np.flatnonzero(seen[span.after : span.after + reach])[:samples] + span.after if span.after >= 0 else first[:0]
    )
    return np.concatenate([first, last])


def lagrange(known: Ints, at: Ints) -> Floats:
    """Weights (L, n) of the samples at frames `known` (n) in the polynomial through them at frames `at` (L)."""
    scale = max(float(np.ptp(known)), 1.0)
    t, s = (known - known[0]) / scale, (at - known[0]) / scale
    apart = t[:, None] - t + np.eye(len(t))
    factors = (s[:, None, None] - t) / apart
    factors[:, np.arange(len(t)), np.arange(len(t))] = 1.0
    return factors.prod(2)


def _half_way(known: KnownSamples, marker: int, half: int, samples: int) -> Floats:
    """(3, 3) mm², mean square error half way through a gap of this half length, where the marker is seen."""
    half = max(1, min(half, (known.n_frames - 2 * samples + 1) // 2))
    side = half + np.arange(samples)
    offsets = np.concatenate([-side[::-1], side])
    t = np.arange(side[-1], known.n_frames - side[-1])
    t = t[:: max(1, -(-len(t) // INSTANTS))]
    x = known.x[marker]
    weights = lagrange(offsets, np.zeros(1, np.int64))[0]
    return covariance(x[t] - np.einsum("n,ntk->tk", weights, x[t + offsets[:, None]]))
