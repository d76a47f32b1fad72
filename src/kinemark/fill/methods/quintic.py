"""The quintic spline with generalised cross-validation across the gap (Woltring 1986).

The marker's own samples on both sides are smoothed and bridged by one natural quintic spline, the smoothest in the
sense of the least mean square jerk, whose smoothing follows from the samples themselves: `signal.smoothing_spline`.
Its error grows fast with the length of the gap; it fills the shortest gaps best, and also takes the noise out of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data.method import parameter
from ...signal import smoothing_spline
from ..known_samples import KnownSamples, Span
from ..marker_array import Gap, MarkerArray, Prediction
from .polynomials import beside
from .stage import FILL, FillMethod

MOST = 60
"""Samples of one side; a side of more would cost time and change nothing; chosen."""


@dataclass(frozen=True, slots=True)
class Quintic(FillMethod):
    """A quintic smoothing spline through the samples on both sides."""

    margin: float = parameter(0.3, unit="s", above=0, meaning="how much of the samples on each side of the gap is used")
    smoothing: float | None = parameter(
        None, unit="mm² s⁵", above=0, meaning="p of the spline; None: by generalised cross-validation"
    )


@FILL.method("quintic", Quintic, rank=3, source="Woltring 1986")
def fill_quintic(motion: MarkerArray, gaps: list[Gap], *, method: Quintic = Quintic()) -> list[Prediction]:
    """Splines through up to `margin` of samples on each side, at least six in all."""
    known = KnownSamples.of(motion)
    return [_bridge(known, known.span(gap), method) for gap in gaps]


def _bridge(known: KnownSamples, span: Span, method: Quintic) -> Prediction:
    reach = max(3, round(min(method.margin, known.n_frames / known.rate) * known.rate))
    frames = beside(known, span, min(reach, MOST), reach)
    if len(frames) < 6:
        few = f"{len(frames)} within {reach} frames"
        return Prediction.none(span.length, known.never(span) or f"needs six samples beside the gap, found {few}")
    origin = frames[0]
    half = (max(frames[-1], span.stop - 1) - min(origin, span.start)) / 2 / known.rate  # seconds of the spline's unit
    found = smoothing_spline(
        (frames - origin).astype(np.float64),
        known.x[span.marker, frames],
        (span.frames - origin).astype(np.float64),
        smoothing=None if method.smoothing is None else method.smoothing / half**5,
    )
    return Prediction(found.values, found.variance[:, None, None] * np.eye(3))
