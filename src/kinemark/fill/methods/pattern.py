"""The pattern of a reference marker: the marker moves as another one does.

Over the gap from a to b the marker keeps its offset from the reference marker d, which goes linearly from what it is
before the gap to what it is after:

    x̂(t) = x_d(t) + (1 − s) (x(a) − x_d(a)) + s (x(b) − x_d(b)),     s = (t − a) / (b − a)               (1)

The reference marker is the one whose offset a linear bridge of this length predicts best half way, over the frames of
the trial where both are seen (`reference_markers`, equation 1); that mean square error, falling to 0 at the edges as 4
s (1 − s), is the covariance (2). At an end of the path the offset stays and the covariance grows in proportion to the
time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data.array_types import Floats
from ...data.method import parameter
from ..known_samples import KnownSamples, Span
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import bridge_error, covariance, mean_square, rounded, triples
from .stage import FILL, FillMethod


@dataclass(frozen=True, slots=True)
class Pattern(FillMethod):
    """The motion of one reference marker that moves in parallel, carried over between the gap's edges."""

    reference_markers: tuple[str, ...] = parameter(
        (), meaning="names of reference markers to choose from; empty: all markers"
    )


@FILL.method("pattern", Pattern, rank=4)
def fill_pattern(motion: MarkerArray, gaps: list[Gap], *, method: Pattern = Pattern()) -> list[Prediction]:
    """Each gap from its best reference marker, which must be seen throughout the gap and beside it.

    Raises:
        ValueError: a reference marker named is not in the trial.
    """
    known = KnownSamples.of(motion)
    allowed = known.among(method.reference_markers)
    bent: dict[int, Floats] = {}
    return [_follow(known, known.span(gap), allowed, bent) for gap in gaps]


def _follow(known: KnownSamples, span: Span, allowed: np.ndarray, bent: dict[int, Floats]) -> Prediction:
    there = np.flatnonzero(known.around(span) & allowed)
    if not span.edges or not len(there):
        return Prediction.none(
            span.length, known.never(span) or "no reference marker is seen throughout the gap and beside it"
        )
    h = rounded(span.half)
    if h not in bent:
        bent[h] = bridge_error(triples(known, h))
    e = bent[h][span.marker] - bent[h][there]
    skill = mean_square(e, least=3)
    best = int(np.argmin(skill))
    if not np.isfinite(skill[best]):  # never seen together long enough: the nearest
        edge = known.x[:, span.edges[0]]
        best = int(np.argmin(((edge[there] - edge[span.marker]) ** 2).sum(1)))
    reference = int(there[best])
    s = span.share_of_after()
    ends = [span.edges[0], span.edges[-1]]
    first, last = known.x[span.marker, ends] - known.x[reference, ends]
    xyz = known.x[reference, span.start : span.stop] + (1 - s) * first + s * last  # (1)
    return Prediction(xyz, span.bow()[:, None, None] * covariance(e[best]), references=(reference,))  # (2)
