"""Weighted principal components of all markers (Federolf 2013; Gløersen & Federolf 2016).

Signals are positions less the mean of the markers seen in the gap (`neighbourhood`), less their mean in time and
divided by their standard deviation σ_j, times a weight that falls with the mean distance δ_j from the missing markers,

    y_j = g_j (x_j − μ_j) / σ_j,     g_j = exp(−δ_j² / 2 ς²),     g = g₀ for missing markers             (1)

N has all columns, Z the same with the missing ones zero, in frames where all are seen. V and V_Z hold the n first
principal components of N and of Z; n is the number of which the singular values sum to `kept` of the whole, the greater
of the two. In the gap, z of the markers seen is taken to components of Z, these to those of N, and back,

    ŷ = z V_Z (V_Zᵀ V) Vᵀ                                                                              (2)

which is a fixed matrix from the columns seen to those missing (3), one for each set of missing markers. σ_j is of all
three coordinates of a marker together here, where the paper has one for each: so the method turns with the laboratory.

Strategies of the paper. R1: all markers that are missing somewhere in the gap are reconstructed at once, δ_j is the
distance to the nearest of them. R2 (default): the marker alone, other missing ones are left out; seen ones that cost
too many frames to learn from are left out too.

What (2) leaves over beside the gap is carried into it and gives the covariance (`bridge`), which is not in the paper;
`bridged=False` does without.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...data.method import ONE, parameter
from ..known_samples import KnownSamples, Span, sections
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import Distances, distances, nearest
from ..residual_bridge import Leftover, bridge
from .neighbourhood import Neighbourhood, columns, neighbourhood
from .stage import FILL, FillMethod


@dataclass(frozen=True, slots=True)
class PCA(FillMethod):
    """Principal components of the markers that are near, with weights."""

    strategy: Literal["R1", "R2"] = parameter(
        "R2",
        meaning="of the paper: R1 reconstructs all markers that are missing in the gap at once, R2 the marker alone",
    )
    scale: float = parameter(200.0, unit="mm", above=0, meaning="ς of (1), the distance over which markers count")
    missing_weight: float = parameter(0.02, unit=ONE, above=0, meaning="g₀ of (1), weight of the missing marker itself")
    component_share: float = parameter(
        0.99, unit=ONE, above=0, high=1, meaning="share of the sum of singular values that the components hold"
    )
    most_markers: int = parameter(
        12, unit="markers", low=2, meaning="nearest markers used at most; farther ones weigh next to nothing"
    )
    bridge_residuals: bool = parameter(True, meaning="the residuals beside the gap are carried into it")


BLOCKS = 5
"""Of the frames learnt from, every second of so many blocks is left out to measure what the map leaves over.
Chosen (see benchmarks/gaps.py)."""


class Map(NamedTuple):
    """(3): from the columns seen to one marker, x̂ = mean + (x − mean_seen) B.

    Attributes:
        hood: the markers.
        mean: (3 K) mm, of all columns.
        B: (3 n_seen, 3).
        left: what it leaves over.
    """

    hood: Neighbourhood
    mean: Floats
    B: Floats
    left: Leftover

    def at(self, known: KnownSamples, frames: Ints) -> Floats:
        """The marker (F, 3) mm; NaN where one of those it needs is missing."""
        Y, centre = columns(known, self.hood._replace(markers=self.hood.markers[: self.hood.n_seen]), frames)
        return (Y - self.mean[: Y.shape[1]]) @ self.B + self.mean[-3:] + centre


class _LearntComponents(NamedTuple):
    """What gaps of a call share."""

    distances: Distances
    frames: Ints
    maps: dict[tuple[int, bytes], Map | None]


@FILL.method("pca", PCA, rank=11, source="Federolf 2013; Gløersen and Federolf 2016")
def fill_pca(motion: MarkerArray, gaps: list[Gap], *, method: PCA = PCA()) -> list[Prediction]:
    """Each gap from the markers seen in it, or section by section where markers come and go."""
    known = KnownSamples.of(motion)
    learnt = _LearntComponents(distances(known), known.thin(), {})
    return [_reconstruct(known, known.span(gap), learnt, method) for gap in gaps]


def _reconstruct(known: KnownSamples, span: Span, learnt: _LearntComponents, method: PCA) -> Prediction:
    if not span.edges:
        return Prediction.none(span.length, known.never(span))
    out, lost, references = Prediction.none(span.length, ""), list[str](), set[int]()
    for start, stop in sections(known, span, least=3):
        there = known.throughout(start, stop, but=span.marker)
        found = _map(known, span.marker, there, learnt, method)
        if found is None:
            lost.append(f"{start + 1} to {stop}")
            continue
        part = slice(start - span.start, stop - span.start)
        out.xyz[part], out.cov[part] = _apply(known, span, found, np.arange(start, stop), method.bridge_residuals)
        references |= {int(d) for d in found.hood.markers[: found.hood.n_seen]}
    wanted = "needs two markers seen in the gap and, with this one, in other frames"
    return out._replace(
        references=tuple(sorted(references)), reason=f"frames {', '.join(lost)}: {wanted}" if lost else ""
    )


def _apply(known: KnownSamples, span: Span, found: Map, frames: Ints, bridged: bool) -> tuple[Floats, Floats]:
    at = span.with_edges(frames)
    xyz = found.at(known, at)
    if not bridged:
        return xyz[:-2], np.broadcast_to(found.left.cov, (len(frames), 3, 3))
    beside = known.x[span.marker, at[-2:]] - xyz[-2:]
    beside[[span.before < 0, span.after < 0]] = np.nan
    correction, cov = bridge(found.left, span, frames.astype(np.float64), beside)
    return xyz[:-2] + correction, cov


def _map(known: KnownSamples, marker: int, there: Bools, learnt: _LearntComponents, method: PCA) -> Map | None:
    """The map for a marker with these others at hand; the same for all gaps with the same ones."""
    near = nearest(learnt.distances(marker).mean, there, method.most_markers)
    sought = np.array([marker])
    if method.strategy == "R1":
        hidden = nearest(learnt.distances(marker).mean, ~there & known.seen.any(1), method.most_markers)
        sought = np.append(hidden[hidden != marker], marker)
    key = (len(near), np.concatenate([near, sought]).tobytes())
    if key not in learnt.maps:
        hood = neighbourhood(known, near, sought, frames=learnt.frames, least=min(200, len(learnt.frames) // 3))
        learnt.maps[key] = _learn(known, hood, learnt, method) if hood else None
    return learnt.maps[key]


def _learn(known: KnownSamples, hood: Neighbourhood, learnt: _LearntComponents, method: PCA) -> Map:
    """The map from all frames, and what a map from a part of them leaves over in the others."""
    Y, _ = columns(known, hood, hood.frames)
    seen, sought = hood.markers[: hood.n_seen], hood.markers[hood.n_seen :]
    distance = np.min([learnt.distances(int(k)).mean[seen] for k in sought], axis=0)
    g = np.append(np.exp(-(distance**2) / (2 * method.scale**2)), np.full(len(sought), method.missing_weight))
    sums = _Sums.of(Y)
    mean, B = _fit(sums, g, hood.n_seen, method.component_share)
    residual = np.full((len(learnt.frames), 3), np.nan)
    block = BLOCKS * np.arange(len(Y)) // len(Y)
    tested = block % 2 == 1
    part_mean, part_B = _fit(sums.without(Y[tested]), g, hood.n_seen, method.component_share)
    deviation = Y[tested] - part_mean
    residual[np.searchsorted(learnt.frames, hood.frames[tested])] = deviation[:, -3:] - deviation[:, : len(B)] @ part_B
    return Map(hood, mean, B, Leftover.of(residual, hood.step))


class _Sums(NamedTuple):
    """Of n frames of signals: the mean of each column, and the sums of products about it."""

    n: int
    mean: Floats
    G: Floats

    @classmethod
    def of(cls, Y: Floats) -> _Sums:
        """From signals (n, K)."""
        mean = Y.mean(0)
        deviation = Y - mean
        return cls(len(Y), mean, deviation.T @ deviation)

    def without(self, Y: Floats) -> _Sums:
        """Those of all frames but these, (m, K)."""
        deviation, n = Y - self.mean, self.n - len(Y)
        shift = deviation.sum(0) / n
        return _Sums(n, self.mean - shift, self.G - deviation.T @ deviation - n * np.outer(shift, shift))


def _fit(sums: _Sums, g: Floats, n_seen: int, kept: float) -> tuple[Floats, Floats]:
    """Means of all columns, and B of (3), for weights g of the markers."""
    _, mean, G = sums
    square = np.maximum(np.diagonal(G), 0.0).reshape(-1, 3).sum(1)
    deviation = np.sqrt(
        np.where(square > 1e-12 * square.max(), square / sums.n, np.inf)
    )  # constant columns tell nothing
    factor = np.repeat(g / deviation, 3)  # (1)
    n = 3 * n_seen
    B = factor[:n, None] * _matrix(G * factor[:, None] * factor, n, kept)
    return mean, np.divide(B, factor[-3:], out=np.zeros_like(B), where=factor[-3:] > 0)


def _matrix(G: Floats, n_seen: int, kept: float) -> Floats:
    """(2) as a matrix (n_seen, 3) to the last three columns, from the sums of products of the columns of N."""
    s, V = np.linalg.eigh(G)
    s_z, V_z = np.linalg.eigh(G[:n_seen, :n_seen])
    n = max(_count(s, kept), _count(s_z, kept))
    V, V_z = V[:, ::-1][:, :n], V_z[:, ::-1][:, :n]
    return V_z @ ((V_z.T @ V[:n_seen]) @ V[-3:].T)


def _count(eigenvalues: Floats, kept: float) -> int:
    s = np.sqrt(np.maximum(eigenvalues[::-1], 0.0))
    return int(np.searchsorted(np.cumsum(s), kept * s.sum() * (1 - 1e-12))) + 1
