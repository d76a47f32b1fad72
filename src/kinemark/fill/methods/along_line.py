"""The place on the straight line through two markers, and beyond them.

"If there is trouble in viewing an ankle marker, put two markers on the lower leg, so that the ankle is further along
the straight line drawn between the two" (Swamidas 1997, 2.5 (5), after Mah). With reference markers a and b,

    u(t) = (b − a) / |b − a|,     x̂(t) = a(t) + s u(t),     s = mean of (x − a) · u                      (1)

over frames where all three are seen; s is below 0 before a and above |b − a| beyond b. What (1) leaves over beside the
gap is carried into it, and gives the covariance (`bridge`). Of all pairs of the reference markers that keep their
distance from the marker best, that one is taken which leaves least over: a marker that does not lie on its line turns
about it, and that is left over.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import ClassVar, NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...data.method import parameter
from ..known_samples import KnownSamples, Span, sections
from ..marker_array import Gap, MarkerArray, Prediction
from ..reference_markers import Distances, distances, nearest
from ..residual_bridge import Leftover, bridge
from .stage import FILL, FillMethod

LEARN = 160
"""Frames from which s is learnt; chosen, as for rigid bodies."""
POOL = 5
"""Reference markers of which pairs are tried, a number; chosen, as for rigid bodies."""


@dataclass(frozen=True, slots=True)
class TwoMarkers(FillMethod):
    """What methods with two reference markers have in common."""

    automatic: ClassVar[bool] = False  # limb_angles and rigid_body do what these do, and better, where they can

    reference_markers: tuple[str, ...] = parameter(
        (), meaning="the two reference markers; empty: chosen by measured skill"
    )

    def check_together(self) -> None:
        """Refuse any other number of reference markers than two."""
        if self.reference_markers and len(set(self.reference_markers)) != 2:
            raise ValueError(
                f"reference_markers are {list(self.reference_markers)}, wanted two different ones, or none"
            )


@dataclass(frozen=True, slots=True)
class AlongLine(TwoMarkers):
    """The place on the straight line through two reference markers."""


class Line(NamedTuple):
    """A pair (2) of reference markers, s mm, and what is left over."""

    pair: Ints
    s: float
    left: Leftover


@FILL.method("along_line", AlongLine, rank=15, source="Swamidas 1997, 2.5 (5)")
def fill_along_line(motion: MarkerArray, gaps: list[Gap], *, method: AlongLine = AlongLine()) -> list[Prediction]:
    """Each gap from two reference markers, section by section where they come and go.

    Raises:
        ValueError: a reference marker named is not in the trial.
    """
    known = KnownSamples.of(motion)
    far, learnt = distances(known), dict[tuple[int, bytes], Line | None]()
    return [_carried(known, known.span(gap), far, learnt, method) for gap in gaps]


def pairs_for(known: KnownSamples, span: Span, start: int, stop: int, far: Distances, method: TwoMarkers) -> list[Ints]:
    """Pairs (2) of the reference markers that are at hand in all frames start … stop − 1."""
    there = known.throughout(start, stop, but=span.marker) & known.among(method.reference_markers)
    pool = nearest(far(span.marker).sd, there, POOL)
    return [np.array(pair) for pair in combinations(sorted(pool.tolist()), 2)]


def _carried(
    known: KnownSamples, span: Span, far: Distances, learnt: dict[tuple[int, bytes], Line | None], method: AlongLine
) -> Prediction:
    out, reasons, references = Prediction.none(span.length, ""), list[str](), set[int]()
    for start, stop in sections(known, span, least=2):
        found = [_line(known, span.marker, pair, learnt) for pair in pairs_for(known, span, start, stop, far, method)]
        lines = [line for line in found if line]
        if not lines:
            reasons.append(f"frames {start + 1} to {stop}: {no_pair(known, span)}")
            continue
        line = min(lines, key=lambda line: float(np.trace(line.left.cov)))
        part = slice(start - span.start, stop - span.start)
        out.xyz[part], out.cov[part] = _carry(known, span, line, np.arange(start, stop))
        references |= set(line.pair.tolist())
    return out._replace(references=tuple(sorted(references)), reason="; ".join(reasons))


def no_pair(known: KnownSamples, span: Span) -> str:
    """Why there is no pair."""
    return (
        f"needs two reference markers that are seen in the gap, and elsewhere together with {known.names[span.marker]}"
    )


def _line(known: KnownSamples, marker: int, pair: Ints, learnt: dict[tuple[int, bytes], Line | None]) -> Line | None:
    """(1) of a pair; None where the three are never seen together."""
    key = marker, pair.tobytes()
    if key not in learnt:
        frames = known.thin(LEARN)
        a, b, x = known.at(np.append(pair, marker)[:, None], frames)
        s = ((x - a) * unit(b - a)).sum(-1)
        some = np.isfinite(s)
        if some.any():
            share = float(s[some].mean())
            step = int(frames[1] - frames[0]) if len(frames) > 1 else 1
            learnt[key] = Line(pair, share, Leftover.of(x - a - share * unit(b - a), step))
        else:
            learnt[key] = None
    return learnt[key]


def _carry(known: KnownSamples, span: Span, line: Line, frames: Ints) -> tuple[Floats, Floats]:
    at = span.with_edges(frames)
    a, b = known.at(line.pair[:, None], at)
    xyz = a + line.s * unit(b - a)  # (1)
    beside = known.x[span.marker, at[-2:]] - xyz[-2:]
    beside[[span.before < 0, span.after < 0]] = np.nan
    correction, cov = bridge(line.left, span, frames.astype(np.float64), beside)
    return xyz[:-2] + correction, cov


def unit(way: Floats) -> Floats:
    """(…, 3) of length 1; NaN of none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(way / np.linalg.norm(way, axis=-1, keepdims=True))
