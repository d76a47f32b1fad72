"""Relational filling: the marker in the frame of three chosen markers.

Three markers O, A, P make a frame of their own in every field,

    e₁ = A − O,   e₃ = e₁ × (P − O),   e₂ = e₃ × e₁,   each of length 1                                  (1)

in which the marker has the coordinates y = [e₁ e₂ e₃]ᵀ (x − O). Across the gap each of these is interpolated between
what it is before and after (2): unlike a rigid body, the marker may drift in its frame. At an end of the path it stays.

The three are named by the user, or chosen: of the markers that keep their distance best, every three that make a proper
triangle are tried, and those taken whose y a linear bridge of this length predicts best (`reference_markers`, equation
1).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ...data.array_types import Floats, Ints
from ...data.method import parameter
from ..known_samples import KnownSamples, Span
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import Distances, bridge_error, covariance, distances, mean_square, nearest, rounded, triples
from .stage import FILL, FillMethod

POOL = 5
"""The most rigid markers, of which every three are tried; chosen (see benchmarks/gaps.py)."""
SHARP = 0.15
"""Sine of the angle at O below which three markers are not chosen."""
LINE = 0.02
"""Sine below which they make no frame; chosen (see benchmarks/gaps.py)."""


@dataclass(frozen=True, slots=True)
class Relational(FillMethod):
    """The place in the frame of three reference markers, interpolated over the gap."""

    reference_markers: tuple[str, ...] = parameter(
        (),
        meaning="reference markers: the origin O, A on the first axis and P in the plane; empty: chosen by measured "
        "skill",
    )

    def check_together(self) -> None:
        """Refuse any other number of markers than three."""
        if len(self.reference_markers) not in (0, 3) or len(set(self.reference_markers)) != len(self.reference_markers):
            raise ValueError(
                f"reference_markers are {list(self.reference_markers)}, wanted three different ones, or none"
            )


Chosen = dict[tuple[int, int, bytes], tuple[Ints, Floats]]


@FILL.method("relational", Relational, rank=7)
def fill_relational(motion: MarkerArray, gaps: list[Gap], *, method: Relational = Relational()) -> list[Prediction]:
    """Each gap in the frame of three markers, which must be seen throughout the gap and beside it.

    Raises:
        ValueError: a marker named is not in the trial.
    """
    known = KnownSamples.of(motion)
    named = np.array(known.places(method.reference_markers), np.int64)
    bent: dict[int, Floats] = {}
    chosen: Chosen = {}
    far = distances(known)
    return [_relate(known, known.span(gap), named, far, bent, chosen) for gap in gaps]


def _relate(
    known: KnownSamples, span: Span, named: Ints, far: Distances, bent: dict[int, Floats], chosen: Chosen
) -> Prediction:
    there = known.around(span)
    if len(named):
        usable = named if there[named].all() else named[:0]
    else:
        usable = np.sort(nearest(far(span.marker).sd, there, POOL))
    if not span.edges or len(usable) < 3:
        return Prediction.none(span.length, known.never(span) or _lacking(known, named))
    h = rounded(span.half)
    if h not in bent:
        bent[h] = triples(known, h)
    key = (span.marker, h, usable.tobytes())
    if key not in chosen:
        sets = [usable] if len(named) else [np.array(c) for c in combinations(usable, 3)]
        chosen[key] = _choose(bent[h], span.marker, sets)
    three, cov = chosen[key]
    return _interpolate(known, span, three, cov)


def _lacking(known: KnownSamples, named: Ints) -> str:
    if len(named):
        return f"{known.called(named)} are not all seen throughout the gap and beside it"
    return "needs three markers seen throughout the gap and beside it"


def _choose(x: Floats, marker: int, sets: list[Ints]) -> tuple[Ints, Floats]:
    """The best three, and their mean square error half way, in their frame, from x (M, 3, T, 3)."""
    index = np.array(sets)
    R, origin = frames(*(x[index[:, k]] for k in range(3)), sharp=SHARP)
    y = np.einsum("...i,...ij->...j", x[marker] - origin, R)
    e = bridge_error(y)
    best = int(np.argmin(mean_square(e, least=3)))
    return index[best], covariance(e[best])


def _interpolate(known: KnownSamples, span: Span, three: Ints, cov: Floats) -> Prediction:
    at = np.concatenate([span.frames, [span.edges[0], span.edges[-1]]])
    R, origin = frames(*known.at(three[:, None], at), sharp=LINE)
    y = (R.mT @ (known.x[span.marker, at] - origin)[..., None])[..., 0]
    if np.isnan(R).any():
        return Prediction.none(span.length, f"{known.called(three)} come to lie on a line in the gap")
    s = span.share_of_after()
    local = (1 - s) * y[-2] + s * y[-1]  # (2)
    R, origin = R[:-2], origin[:-2]
    xyz = (R @ local[..., None])[..., 0] + origin
    return Prediction(xyz, span.bow()[:, None, None] * (R @ cov @ R.mT), references=tuple(int(k) for k in three))


def _cross(a: Floats, b: Floats) -> Floats:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def frames(origin: Floats, A: Floats, P: Floats, *, sharp: float) -> tuple[Floats, Floats]:
    """(1): R (…, 3, 3) with the axes as columns, and the origin; NaN where the three lie nearly on a line."""
    # Coordinates first: long arrays are many times as fast as many short ones.
    e1, to_p = (np.ascontiguousarray(np.moveaxis(point - origin, -1, 0)) for point in (A, P))
    e3 = _cross(e1, to_p)
    with np.errstate(invalid="ignore", divide="ignore"):
        n1, n3, n_p = (np.sqrt((v * v).sum(0)) for v in (e1, e3, to_p))
        proper = n3 > sharp * n1 * n_p
        e1, e3 = np.where(proper, e1 / n1, np.nan), np.where(proper, e3 / n3, np.nan)
    axes = np.stack([e1, _cross(e3, e1), e3])
    return np.ascontiguousarray(np.moveaxis(axes, (1, 0), (-2, -1))), origin
