"""The place on the circle that the known distances to two markers leave, and where on it by interpolation.

"If the distances between three markers on a segment are known and the locations of two of the markers are known, the
location of the third marker can be constrained": to a circle (Swamidas 1997, 2.5 (8), after Olree, who has it from "an
interpolative procedure", or from one camera, whose line of sight meets the circle). With the distances d₁ and d₂ of the
marker from the reference markers a and b, D = |b − a| and u = (b − a) / D, it is

    x̂ = a + s u + ρ e,    s = (d₁² − d₂² + D²) / 2D,    ρ² = d₁² − s²                                    (1)

d₁ and d₂ are interpolated between what they are at both ends of the gap. Where on the circle, the unit vector e that is
perpendicular to u, follows from the directions e₀ and e₁ at both ends: each is carried along with u by the shortest
rotation M that takes u there to u here (it does not turn about the line), and

    e ∝ (1 − w) M₀ e₀ + w M₁ e₁,    w from 0 to 1 through the gap                                        (2)
    M p = p − (u · p) / (1 + u₀ · u) (u₀ + u)   for p perpendicular to u₀                                (3)

At an end of the path there is one of them. What (1) and (2) are off half way through a gap of this length is measured
where the marker is seen, in the axes u, e and u × e; it falls towards the edges as a polynomial's does, to what a gap
of one frame has, which is noise. So the covariance is long along the circle and short across it, and the image of one
camera in the gap (`rays`) makes it the place where the camera's ray meets the circle. Of all pairs of reference markers
that one is taken which is least off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...numerics.vectors import cross
from ..known_samples import KnownSamples, Span, sections
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import INSTANTS, Distances, covariance, distances, rounded
from .along_line import TwoMarkers, no_pair, pairs_for, unit
from .stage import FILL


@dataclass(frozen=True, slots=True)
class Circle(TwoMarkers):
    """The place on the circle of known distances from two reference markers."""


class OnCircle(NamedTuple):
    """Places (N, 3) mm and the axes (N, 3, 3) u, e and u × e as columns."""

    xyz: Floats
    axes: Floats


class Pair(NamedTuple):
    """A pair (2) of reference markers and what (1) and (2) are off, in the axes of the circle: cov (3, 3) mm² half way
    through the gap, noise (3, 3) mm² in one of a single frame."""

    pair: Ints
    cov: Floats
    noise: Floats


@FILL.method("circle", Circle, rank=16, source="Swamidas 1997, 2.5 (8)")
def fill_circle(motion: MarkerArray, gaps: list[Gap], *, method: Circle = Circle()) -> list[Prediction]:
    """Each gap from two reference markers, section by section where they come and go.

    Raises:
        ValueError: a reference marker named is not in the trial.
    """
    known = KnownSamples.of(motion)
    far, measured = distances(known), dict[tuple[int, int, bytes], Pair | None]()
    return [_carried(known, known.span(gap), far, measured, method) for gap in gaps]


def _carried(
    known: KnownSamples,
    span: Span,
    far: Distances,
    measured: dict[tuple[int, int, bytes], Pair | None],
    method: Circle,
) -> Prediction:
    if not span.edges:
        return Prediction.none(span.length, known.never(span))
    out, reasons, references = Prediction.none(span.length, ""), list[str](), set[int]()
    for start, stop in sections(known, span, least=2):
        pairs = [
            pair for pair in pairs_for(known, span, start, stop, far, method) if known.seen[pair][:, span.edges].all()
        ]
        found = [_measured(known, span, pair, measured) for pair in pairs]
        some = [pair for pair in found if pair]
        if not some:
            reasons.append(f"frames {start + 1} to {stop}: {no_pair(known, span)}, and at its edges")
            continue
        best = min(some, key=lambda pair: float(np.trace(pair.cov)))
        frames, part = np.arange(start, stop), slice(start - span.start, stop - span.start)
        first, last = np.array(span.edges[:1]), np.array(span.edges[-1:])
        place = on_circle(known, span.marker, best.pair, first, last, frames)
        bow = (span.bow()[part] ** 2)[:, None, None]
        out.xyz[part] = place.xyz
        out.cov[part] = place.axes @ (bow * best.cov + best.noise) @ place.axes.mT
        references |= set(best.pair.tolist())
    return out._replace(references=tuple(sorted(references)), reason="; ".join(reasons))


def on_circle(known: KnownSamples, marker: int, pair: Ints, first: Ints, last: Ints, frames: Ints) -> OnCircle:
    """(1) and (2) in frames (N), from what is known at the frames first and last (N, or 1), which may be the same."""
    a, b = known.at(pair[:, None], frames)
    u, D = unit(b - a), np.linalg.norm(b - a, axis=-1)
    ends = [_beside(known, marker, pair, end, u) for end in (first, last)]
    w = np.where(last > first, (frames - first) / np.maximum(last - first, 1), 0.0)
    d1, d2 = ((1 - w) * ends[0][k] + w * ends[1][k] for k in (0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):  # two markers in one place: no line
        s = (d1**2 - d2**2 + D**2) / (2 * D)
        radius = np.sqrt(np.maximum(d1**2 - s**2, 0.0))
    e = unit((1 - w)[:, None] * ends[0][2] + w[:, None] * ends[1][2])  # (2)
    return OnCircle(a + s[:, None] * u + radius[:, None] * e, np.stack([u, e, cross(u, e)], -1))  # (1)


def _beside(known: KnownSamples, marker: int, pair: Ints, end: Ints, u: Floats) -> tuple[Floats, Floats, Floats]:
    """Distances (N) mm from both reference markers at an end, and the direction there, carried to u (N, 3)."""
    a, b, x = known.at(np.append(pair, marker)[:, None], end)
    u0, way = unit(b - a), x - a
    p = unit(way - (way * u0).sum(-1, keepdims=True) * u0)
    with np.errstate(invalid="ignore", divide="ignore"):  # a line that turns right round: no shortest rotation
        turned = p - ((u * p).sum(-1) / (1 + (u0 * u).sum(-1)))[:, None] * (u0 + u)  # (3)
    return np.linalg.norm(way, axis=-1), np.linalg.norm(x - b, axis=-1), turned


def _measured(
    known: KnownSamples, span: Span, pair: Ints, measured: dict[tuple[int, int, bytes], Pair | None]
) -> Pair | None:
    """How far off a pair's circle is half way through a gap like this; None where the three are too seldom seen."""
    half = max(1, min(rounded(span.half), (known.n_frames - 1) // 2))
    key = span.marker, half, pair.tobytes()
    if key not in measured:
        cov, noise = (_half_way(known, span.marker, pair, h) for h in (half, 1))
        measured[key] = Pair(pair, cov, noise) if np.isfinite([cov, noise]).all() else None
    return measured[key]


def _half_way(known: KnownSamples, marker: int, pair: Ints, half: int) -> Floats:
    """(3, 3) mm² mean square of what (1) and (2) are off half way through gaps of this half length."""
    t = np.arange(half, known.n_frames - half)
    t = t[:: max(1, -(-len(t) // INSTANTS))]
    place = on_circle(known, marker, pair, t - half, t + half, t)
    return covariance(np.einsum("nij,ni->nj", place.axes, known.x[marker, t] - place.xyz))
