"""What is known of a trial, as fillers read it: the samples that can be true, and what lies around a gap.

A sample more than `FAR` (a kilometre) from the median of all samples is no marker's; it counts as missing, so that one
wrong number does not swamp the sums that all gaps are learnt from. Where the world has its origin does not matter.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..data.nearest_word import some_names
from ..numerics.runs import equal_runs
from .marker_array import Gap, MarkerArray

FAR = 1e6
"""mm from the median of all samples, beyond which a sample is no position of a marker.
Chosen (see benchmarks/gaps.py)."""
RESOLVED = 2.0**42
"""mm, 4.4 million km: farther from the origin, doubles are more than a thousandth of a millimetre apart.
Chosen (see benchmarks/gaps.py)."""
MOST_SECTIONS = 12
"""Of a gap, at most; chosen for time."""
ENOUGH = 600
"""Frames that are enough to learn from; longer trials are thinned evenly; chosen (see benchmarks/gaps.py)."""


def plausible(xyz: Floats) -> Bools:
    """(M, F) which samples (M, F, 3) mm, NaN where missing, can be true: those within `FAR` of the median of all.

    What lies beyond `RESOLVED` is none either, wherever the others lie.
    """
    missing = np.isnan(xyz[..., 0])
    if missing.all():
        return ~missing
    one = xyz.reshape(-1, 3)[missing.argmin()]
    if (np.abs(one) < RESOLVED).all():
        near = _within(xyz, one, FAR / 2)
        if (near | missing).all():  # so that no two are `FAR` apart: a median would take ten times as long
            return near
    resolved = np.asarray((np.abs(xyz) < RESOLVED).all(-1))
    return resolved & _within(xyz, np.median(xyz[resolved], axis=0), FAR) if resolved.any() else resolved


def _within(xyz: Floats, place: Floats, reach: float) -> Bools:
    """(M, F) which samples lie within so many mm of a place (3,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        difference = xyz - place
        return np.asarray(np.einsum("mfi,mfi->mf", difference, difference) < reach**2)


def known_median(values: Floats) -> Floats:
    """(N) median over the first axis of what is known of (K, N); NaN where nothing is."""
    if not len(values):
        return np.full(values.shape[1], np.nan)
    order = np.sort(values, axis=0)  # what is not known comes last
    count = np.count_nonzero(~np.isnan(values), axis=0)
    low, high = np.maximum(count - 1, 0) // 2, count // 2
    median = np.take_along_axis(order, np.stack([low, np.minimum(high, len(values) - 1)]), axis=0).mean(0)
    return np.asarray(np.where(count > 0, median, np.nan))


class Span(NamedTuple):
    """A gap and the samples beside it.

    Attributes:
        marker: whose.
        start: first frame.
        stop: last frame plus one.
        before: the marker's last seen frame before it, −1 where there is none.
        after: its first seen frame after it, −1 where there is none.
    """

    marker: int
    start: int
    stop: int
    before: int
    after: int

    @property
    def length(self) -> int:
        """Frames."""
        return self.stop - self.start

    @property
    def frames(self) -> Ints:
        """(L) of the gap."""
        return np.arange(self.start, self.stop)

    @property
    def edges(self) -> list[int]:
        """The frames beside it that are seen: two, one at an end of the marker's path, none if it is never seen."""
        return [f for f in (self.before, self.after) if f >= 0]

    @property
    def inside(self) -> bool:
        """Whether the marker is seen on both sides."""
        return self.before >= 0 and self.after >= 0

    @property
    def half(self) -> int:
        """Frames from its middle to the nearest known sample, at least 1."""
        return max(1, (self.after - self.before) // 2 if self.inside else self.length // 2)

    def progress(self) -> Floats:
        """(L) from 0 at the sample before to 1 at the sample after; only for a gap inside."""
        return (self.frames - self.before) / (self.after - self.before)

    def share_of_after(self) -> Floats:
        """(L, 1) how much the sample after counts beside that before, in a line; 0 at an end of the path."""
        return self.progress()[:, None] if self.inside else np.zeros((self.length, 1))

    def with_edges(self, frames: Ints) -> Ints:
        """(L + 2) frames (L), then those before and after the gap; 0 for one that is not there."""
        return np.concatenate([frames, [max(self.before, 0), max(self.after, 0)]])

    def bow(self) -> Floats:
        """(L) 0 at the known samples beside the gap and 1 in its middle; at an end it grows beyond 1."""
        if self.inside:
            a = self.progress()
            return 4 * a * (1 - a)
        edge = self.edges[0] if self.edges else self.start
        return np.abs(self.frames - edge) / self.half


class KnownSamples(NamedTuple):
    """A trial without impossible samples.

    Attributes:
        x: (M, F, 3) mm, NaN where missing.
        seen: (M, F).
        rate: Hz.
        names: (M).
    """

    x: Floats
    seen: Bools
    rate: float
    names: tuple[str, ...]

    @classmethod
    def of(cls, motion: MarkerArray) -> KnownSamples:
        """What of a trial can be true."""
        seen = plausible(motion.xyz)
        x = np.where(seen[..., None], motion.xyz, np.nan) if (motion.seen & ~seen).any() else motion.xyz
        return cls(np.ascontiguousarray(x), seen, motion.rate, motion.names)

    @property
    def n_frames(self) -> int:
        """F."""
        return self.seen.shape[1]

    def at(self, markers: Ints, frames: Ints) -> Floats:
        """(…, 3) x[markers, frames] for indices that broadcast, 0 or more: as one index into all samples, for time's
        sake."""
        return self.x.reshape(-1, 3).take(markers * self.n_frames + frames, axis=0)

    def span(self, gap: Gap) -> Span:
        """The gap with what lies beside it."""
        seen = self.seen[gap.marker]
        before, after = seen[: gap.start][::-1], seen[gap.stop :]
        return Span(
            *gap,
            before=gap.start - 1 - int(before.argmax()) if before.any() else -1,
            after=gap.stop + int(after.argmax()) if after.any() else -1,
        )

    def thin(self, most: int = ENOUGH) -> Ints:
        """At most so many frames, evenly spread over the trial."""
        return np.arange(0, self.n_frames, max(1, -(-self.n_frames // most)))

    def throughout(self, start: int, stop: int, *, but: int) -> Bools:
        """(M) which markers, but one, are seen in all frames from start to stop − 1."""
        there: Bools = np.logical_and.reduce(self.seen[:, max(start, 0) : stop], axis=1)
        there[but] = False
        return there

    def around(self, span: Span) -> Bools:
        """(M) which other markers are seen throughout a gap and in the frames of its edges."""
        there = self.throughout(span.start, span.stop, but=span.marker)
        for edge in span.edges:
            there &= self.seen[:, edge]
        return there

    def never(self, span: Span) -> str:
        """Why a marker never seen has no prediction; empty for others."""
        return "" if span.edges else f"marker {self.names[span.marker]} is nowhere seen in this trial"

    def places(self, names: Sequence[str]) -> list[int]:
        """Where markers stand.

        Raises:
            ValueError: a name is not there.
        """
        if lost := [name for name in names if name not in self.names]:
            raise ValueError(f"no markers {', '.join(lost)}; there are {some_names(self.names)}")
        return [self.names.index(name) for name in names]

    def among(self, names: Sequence[str]) -> Bools:
        """(M) which markers have one of these names; all where there are none.

        Raises:
            ValueError: a name is not there.
        """
        chosen = np.full(len(self.names), not names)
        chosen[self.places(names)] = True
        return chosen

    def called(self, markers: Iterable[int]) -> str:
        """Names of markers, for messages."""
        return ", ".join(self.names[k] for k in markers)


def sections(known: KnownSamples, span: Span, *, least: int) -> list[tuple[int, int]]:
    """Frames (start, stop) into which a gap is cut where too few of its neighbours are seen throughout it.

    It stays whole where at least `least` markers, and seven in ten of those seen on average, are seen throughout. Else
    it is cut wherever a marker comes or goes, or evenly where that makes more than `MOST_SECTIONS`.
    """
    seen = known.seen[:, span.start : span.stop]
    whole = seen.all(1).sum()
    if span.length < 2 or (whole >= least and whole >= 0.7 * seen.sum(0).mean()):
        return [(span.start, span.stop)]
    cuts = equal_runs(*seen)[1:-1]
    if len(cuts) >= MOST_SECTIONS:
        cuts = np.unique(np.linspace(0, span.length, MOST_SECTIONS + 1).astype(int))[1:-1]
    ends = [span.start, *(span.start + int(c) for c in cuts), span.stop]
    return list(pairwise(ends))
