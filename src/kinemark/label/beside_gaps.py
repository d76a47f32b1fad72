"""What is seen on both sides of tracks' gaps: how well parts of tracks go on as each other, by motion and by distances.

That b is the same marker as a, rather than any other, has over the neighbours N

    Σ_N max( log(0.75 R / (σ √(2π))) − (m_b − m_a)² / (2 σ²),  log 0.25 )                                          (1)

nats, m the medians of the distances to N within a second of the gap, σ² their variances on both sides and what markers
are seen to, R half the size of the body: `evidence` (1) with the other side of the gap as template.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .evidence import INLIERS, OF_SIZE, REST
from .stretches import SPEED_S, link_nats, speed_at, speed_between

LEAST_S = 0.02
"""Shortest gap, s; chosen: over shorter ones motion tells, see `breaks`."""
NOT_ON = -20.0
"""Least nats of motion; chosen: tracks turn round in gaps."""
WINDOW_S = 1.0
"""Of a track beside its gap, at most, s; chosen: a stride shows what keeps its distance, half a second did as well."""
SAMPLES, FEWEST = 30, 3
"""Frames of a window that are looked at, at most, and that a neighbour is seen in, at least; chosen."""
STIFFEST = 6
"""Neighbours of each side that count; chosen on the exchanges of `hidden.CLEAR`: with ten, twelve lost, with six
five."""


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """P parts of tracks between gaps, in the order of tracks and frames.

    Attributes:
        track: (P) of which. first, last: (P) frames. begin, end: (P, 3) mm.
        into, out: (P, 3) mm a frame at these; NaN of one sample.
        goes_on: (P) whether the next part is of the same track. rate: frames a second. size: of the body, mm.
    """

    track: Ints
    first: Ints
    last: Ints
    begin: Floats
    end: Floats
    into: Floats
    out: Floats
    goes_on: Bools
    rate: float
    size: float

    @classmethod
    def of(cls, xyz: Floats, rate: float, size: float) -> Parts:
        """Of tracks (T, F, 3)."""
        seen, rows, width = np.isfinite(xyz[..., 0]), [], max(1, round(SPEED_S * rate))
        for t, own in enumerate(seen):
            frames = np.flatnonzero(own)
            ends = np.flatnonzero(np.diff(frames) > 1 + LEAST_S * rate)
            bounds = zip(frames[np.r_[0, ends + 1]], frames[np.r_[ends, -1]], strict=True) if len(frames) else ()
            rows += [(t, int(a), int(b)) for a, b in bounds]
        track, first, last = np.array(rows, np.int64).reshape(-1, 3).T
        into = np.array([speed_at(xyz[t], seen[t], a, width) for t, a, _ in rows]).reshape(-1, 3)
        out = np.array([speed_at(xyz[t], seen[t], b, -width) for t, _, b in rows]).reshape(-1, 3)
        goes_on = np.append(track[1:] == track[:-1], np.zeros(min(len(rows), 1), bool))
        return cls(track, first, last, xyz[track, first], xyz[track, last], into, out, goes_on, rate, size)

    def motion(self, a: int | Ints, b: int | Ints) -> Floats:
        """(n) nats that parts b go on where parts a end, over any place."""
        frames = np.asarray(self.first[b] - self.last[a])
        step = self.begin[b] - self.end[a] - speed_between(self.out[a], self.into[b]) * frames[..., None]
        return np.maximum(link_nats(step, frames, self.rate, self.size), NOT_ON)


class Side(NamedTuple):
    """Of a part beside a gap: (T) median distance to each track, and its standard deviation; NaN if hardly seen."""

    median: Floats
    spread: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Beside:
    """What is seen beside gaps.

    Attributes:
        parts: of tracks (T, F, 3) mm, xyz. first, last: (P) frames to which windows reach: the nearest open gaps.
        sides: those that were asked for, part and whether it is before the gap.
    """

    parts: Parts
    xyz: Floats
    first: Ints
    last: Ints
    sides: dict[tuple[int, bool], Side] = field(default_factory=dict)

    @classmethod
    def of(cls, xyz: Floats, parts: Parts, gaps: Iterable[int]) -> Beside:
        """Of tracks, of which the gaps after some parts are open."""
        shut = parts.goes_on.copy()
        shut[list(gaps)] = False
        first, last = parts.first.copy(), parts.last.copy()
        for p in np.flatnonzero(shut).tolist():
            first[p + 1] = first[p]
        for p in np.flatnonzero(shut)[::-1].tolist():
            last[p] = last[p + 1]
        return cls(parts, xyz, first, last)

    def side(self, part: int, before: bool) -> Side:
        """Of a part, before its gap or after the one that it follows."""
        if (part, before) not in self.sides:
            n = round(WINDOW_S * self.parts.rate)
            a, b = self.parts.first[part], self.parts.last[part]
            a, b = (max(self.first[part], b - n), b) if before else (a, min(self.last[part], a + n))
            frames = np.unique(np.linspace(a, b, min(SAMPLES, b - a + 1)).round().astype(int))
            own = self.parts.track[part]
            apart = np.linalg.norm(self.xyz[:, frames] - self.xyz[own, frames], axis=2)
            apart[np.isfinite(apart).sum(1) < FEWEST] = np.nan
            apart[own] = np.nan
            out = Side(np.full(len(apart), np.nan), np.full(len(apart), np.nan))
            some = np.isfinite(apart).any(1)
            out.median[some], out.spread[some] = np.nanmedian(apart[some], axis=1), np.nanstd(apart[some], axis=1)
            self.sides[part, before] = out
        return self.sides[part, before]

    def neighbours(self, sides: Sequence[tuple[int, bool]]) -> Ints:
        """The tracks that are seen on all of these sides, and keep their distance best to one of them."""
        spread = np.array([self.side(*one).spread for one in sides])
        there = np.flatnonzero(np.isfinite(spread).all(0))
        best = np.argsort(spread[:, there], axis=1, kind="stable")[:, :STIFFEST]
        return there[np.unique(best)]

    def same(self, a: int, b: int, neighbours: Ints) -> float:
        """Nats (1) that part b after its gap is the same marker as part a before its own."""
        one, two = (Side(*(values[neighbours] for values in self.side(*of))) for of in ((a, True), (b, False)))
        size = self.parts.size
        sigma = np.sqrt(one.spread**2 + two.spread**2 + (OF_SIZE * size) ** 2)
        base = np.log(INLIERS * 0.5 * size / (sigma * np.sqrt(2 * np.pi)))
        return float(np.maximum(base - (two.median - one.median) ** 2 / (2 * sigma**2), REST).sum())
