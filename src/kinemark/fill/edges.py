"""Bad samples beside a gap, found by the marker's own statistics.

A marker that is about to vanish is seen by fewer cameras, half hidden or merged with another one, and its last samples
are often wrong. Let z be the marker's positions less the mean of its `neighbours` most rigid neighbours, if they are
seen, else the positions themselves. Away from the gap, b is the last sample that cannot be bad; from the parabola
through the `fit_samples` samples up to b follow, h samples nearer to the gap,

    e(b, h) = |z(b + h) − ẑ(b + h)|,      h = 1 … b' − b                                                  (1)

and the same is worked out everywhere in the trial, forward and backward, where no gap is near: E(h), what e is like for
this marker. A sample is bad if

    e(b, h) > median_ratio · median E(h),   > tail_ratio · 99.5th percentile of E(h),   and  > least_error    (2)

The first says that it stands out from the usual, the second that the marker does nothing like it elsewhere (a foot that
strikes the ground is no error), the third that it matters. Some markers always vanish in the fastest movement of a
trial, so that what they do there is never seen elsewhere; but then their neighbours are off their own parabolas too.
What (2) allows is therefore multiplied by how fast the movement changes, worked out for the neighbours' positions,

    factor = max( 1, median over neighbours d of  e_d(b, h) / median E_d(h) )                            (3)

b moves towards the gap until the first bad sample; that one
and all between it and the gap are suspicious, at most `most_trimmed`. `fill` lists them; where it is asked to trim
them, they are missing afterwards and the gap is longer. Some of them are good samples of a rare movement: nothing is
trimmed unasked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats, Ints
from ..data.method import ONE, Method, parameter
from .known_samples import KnownSamples
from .marker_array import Gap, MarkerArray
from .reference_markers import Distances, distances, nearest


@dataclass(frozen=True, slots=True)
class GapEdges(Method):
    """How samples beside gaps are judged."""

    most_trimmed: int = parameter(5, unit="samples", low=0, meaning="that may be bad on each side; 0: no check")
    fit_samples: int = parameter(6, unit="samples", low=4, meaning="that the parabola is fitted to")
    median_ratio: float = parameter(
        3.0, unit=ONE, above=0, meaning="a sample is bad from this many times the median error on"
    )
    tail_ratio: float = parameter(
        1.3,
        unit=ONE,
        above=0,
        meaning="and from this many times what the marker exceeds in one frame of two hundred on",
    )
    least_error: float = parameter(1.0, unit="mm", above=0, meaning="and from this error on")
    neighbours: int = parameter(
        3, unit="markers", low=0, meaning="reference markers: neighbours whose mean error is taken off; 0: none"
    )
    fewest_errors: int = parameter(50, unit="errors", low=1, meaning="errors E(h) that must be known for a verdict")


class Trimmed(NamedTuple):
    """A trial without bad edge samples.

    Attributes:
        motion: with the trimmed samples missing.
        gaps: the gaps, longer by what was trimmed, in the order given; two may have grown into one another.
        before: (n) frames trimmed before each gap.
        after: (n) frames trimmed after it.
    """

    motion: MarkerArray
    gaps: list[Gap]
    before: Ints
    after: Ints

    def suspicious(self) -> dict[Gap, tuple[int, ...]]:
        """The frames that would be trimmed, by the gap as it was before; gaps that have none are left out."""
        out = {}
        for longer, before, after in zip(self.gaps, self.before.tolist(), self.after.tolist(), strict=True):
            gap = Gap(longer.marker, longer.start + before, longer.stop - after)
            if before or after:
                out[gap] = (*range(longer.start, gap.start), *range(gap.stop, longer.stop))
        return out


def trim_edges(motion: MarkerArray, gaps: list[Gap], *, method: GapEdges = GapEdges()) -> Trimmed:
    """Find the bad samples beside gaps and make them missing."""
    before, after = np.zeros((2, len(gaps)), np.int64)
    known = KnownSamples.of(motion)
    if method.most_trimmed:
        far, ladder = distances(known), _ladder(method.fit_samples, method.most_trimmed)
        error_quantiles = cache(lambda marker: _error_quantiles(known.x[marker], ladder, method))
        for marker in {gap.marker for gap in gaps}:
            own = [i for i, gap in enumerate(gaps) if gap.marker == marker]
            judge = _Judge.of(known, marker, far, error_quantiles, method)
            for i in own:
                before[i] = judge.bad(gaps[i].start - 1, 1)
                after[i] = judge.bad(gaps[i].stop, -1)
    longer = [
        Gap(gap.marker, gap.start - int(a), gap.stop + int(b)) for gap, a, b in zip(gaps, before, after, strict=True)
    ]
    trimmed = motion.hidden(g for g, a, b in zip(longer, before, after, strict=True) if a or b)
    return Trimmed(trimmed, longer, before, after)


class _Judge(NamedTuple):
    """What is usual for one marker.

    Attributes:
        z: signals (F, 3), against reference markers first, then the positions; NaN where missing.
        ladder: (most, past) weights of ẑ at h = 1 … most.
        limits: give for each signal, when it is asked for, (most) mm; NaN where too little is known.
        references: neighbours' positions (D, F, 3), for (3).
        usual: gives (D, most) mm, median E_d(h), which is only needed where something stands out.
        method: parameters.
    """

    z: list[Floats]
    ladder: Floats
    limits: Sequence[Callable[[], Floats]]
    references: Floats
    usual: Callable[[], Floats]
    method: GapEdges

    @classmethod
    def of(
        cls,
        known: KnownSamples,
        marker: int,
        far: Distances,
        error_quantiles: Callable[[int], Floats],
        method: GapEdges,
    ) -> _Judge:
        """From all the trial; `error_quantiles` gives those of E(h), median and 99.5th percentile, of any marker."""
        z, limits = [known.x[marker]], [cache(lambda: _limits(error_quantiles(marker), method))]
        ladder = _ladder(method.fit_samples, method.most_trimmed)
        there = known.seen.any(1) & (np.arange(len(known.names)) != marker)
        references = nearest(far(marker).sd, there, method.neighbours)
        if len(references):
            against = known.x[marker] - known.x[references].mean(0)
            z.insert(0, against)
            limits.insert(0, cache(lambda: _limits(_error_quantiles(against, ladder, method), method)))
        least = method.least_error / method.median_ratio  # noise
        usual = cache(lambda: np.array([np.maximum(error_quantiles(int(d))[0], least) for d in references]))
        return cls(z, ladder, limits, known.x[references], usual, method)

    def bad(self, edge: int, toward: int) -> int:
        """How many samples from `edge` away from the gap are bad; the gap lies in the direction `toward` (1 or −1)."""
        for z, limits in zip(self.z, self.limits, strict=True):
            reach = self.method.fit_samples + self.method.most_trimmed
            t = edge - toward * np.arange(reach)[::-1]
            t = t[(t >= 0) & (t < len(z))]
            run = z[t]
            unknown = np.flatnonzero(np.isnan(run[:, 0]))
            t = t[unknown[-1] + 1 :] if len(unknown) else t
            if len(t) > self.method.fit_samples and not np.isnan(limits()).any():
                return self._first_bad(z[t], self.references[:, t], limits())
        return 0

    def _first_bad(self, run: Floats, beside: Floats, limits: Floats) -> int:
        """Samples of a run, whose last is beside the gap, from its first bad one on; `beside` its neighbours'."""
        for b in range(self.method.fit_samples, len(run)):
            h = len(run) - b
            e = self._error(run, b)
            if (e <= limits[:h]).all():
                continue  # whatever the violence, which is 1 or more
            if (bad := np.flatnonzero(e > limits[:h] * self._relative_acceleration(beside, b))).size:
                return h - int(bad[0])
        return 0

    def _error(self, run: Floats, b: int) -> Floats:
        """(1) for the samples from b on, from those before it."""
        e = run[..., b:, :] - self.ladder[: run.shape[-2] - b] @ run[..., b - self.method.fit_samples : b, :]
        return np.sqrt((e**2).sum(-1))

    def _relative_acceleration(self, beside: Floats, b: int) -> Floats:
        """(3) for the samples from b on; 1 where no neighbour is known."""
        e = self._error(beside, b)
        if not len(e):
            return np.ones(e.shape[1])
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = e / self.usual()[:, : e.shape[1]]
        ratio = ratio[np.isfinite(ratio).all(1)]
        return np.maximum(np.median(ratio, axis=0), 1.0) if len(ratio) else np.ones(e.shape[1])


def _ladder(past: int, most: int) -> Floats:
    """Weights (most, past) of the parabola through `past` samples, read 1 … most samples on."""
    t = np.vander(np.arange(1 - past, 1), 3, increasing=True)
    on = np.vander(np.arange(1, most + 1), 3, increasing=True)
    return np.asarray(on @ np.linalg.pinv(t))


def _limits(error_quantiles: Floats, method: GapEdges) -> Floats:
    """(2): what (1) may be for h = 1 … most."""
    usual, rare = error_quantiles
    return np.maximum(np.maximum(method.median_ratio * usual, method.tail_ratio * rare), method.least_error)


def _error_quantiles(z: Floats, ladder: Floats, method: GapEdges) -> Floats:
    """Median and 99.5th percentile (2, most) of E(h), mm, over all the trial but the neighbourhoods of gaps.

    NaN where too little is known.
    """
    n, past = ladder.shape
    window = n + past
    if len(z) < window:
        return np.full((2, n), np.nan)
    near = np.concatenate([[0], np.cumsum(_near_gaps(np.isnan(z[:, 0]), n))])
    starts = np.flatnonzero(near[window:] == near[:-window])
    starts = starts[:: max(1, len(starts) // 2000)]
    if 2 * len(starts) < method.fewest_errors:
        return np.full((2, n), np.nan)
    runs = z.take(np.arange(window)[:, None] + starts, axis=0).reshape(window, -1)
    one_way = np.hstack([-ladder, np.eye(n)])  # (1) of a run forward; backward it is read from its end
    e = (np.vstack([one_way, one_way[:, ::-1]]) @ runs).reshape(2, n, -1, 3)
    square = (e * e) @ np.ones(3)
    ordered = np.sqrt(np.sort(square.swapaxes(0, 1).reshape(n, -1), axis=1))
    return np.array([_share(ordered, 0.5), _share(ordered, 0.995)])


def _share(ordered: Floats, share: float) -> Floats:
    """(n) what this share of the values (n, N) in rising order lies below; sorting takes half the time of a search."""
    at = share * (ordered.shape[1] - 1)
    low, high = ordered[:, math.floor(at)], ordered[:, math.ceil(at)]
    return np.asarray(low + (at % 1) * (high - low))


def _near_gaps(missing: np.ndarray, n: int) -> np.ndarray:
    """Frames that are missing, or within n frames of one that is."""
    return np.asarray(np.convolve(missing, np.ones(2 * n + 1), "same")[: len(missing)] > 0.5)
