"""Hold-out gaps: what is known is hidden as the gap hides it, filled, and compared.

A test of a gap of L frames in marker m is a window of L frames elsewhere in the same trial where m is known. Shifted by
s frames to that window goes the whole state of the gap,

    hidden(k, f + s) = missing(k, f)    for all markers k, the gap's frames f and those up to BESIDE from it,  (1)

so that the filler finds the same reference markers there and misses the same ones, and is tied to the same samples
beside it. Windows of several tests that do not
overlap in time share one copy of the trial, so that one call of a filler serves them all; of one marker at most a tenth
is hidden in one copy. Before a marker's first sample and after its last, all its samples to that end are hidden (2).

A short trial may have no room: where hiding the gap's length again would leave less than half of it of the marker to
learn from, the test is made with the nearest other markers, hidden in the frames of the gap itself (3): the same
length, and the same frames to learn from. What is missing beside the gap's marker may be far from the other one, which
would make the test too easy: so for each marker that is missing in the gap and k-th nearest to its marker, the k-th
nearest to the other one is hidden in the same frames (4).

Windows are drawn where the part of the body moves as it does in the gap (`motion`), as a marker that is lost in fast
motion is seen at rest everywhere else (5): those whose motion is within LIKE of the gap's, in logarithms, or the LEAST
nearest share. Where it moves clearly less in all of them, half of the tests are made as (3). So they are where these
windows are all at FEW places: overlapping ones show one pose, be they twelve, and say little of a gap in another (7).
But not in trials of more than MANY gaps, where all tests are hidden at once to learn from, and more tests cost.

What a method could learn from is the gap's as well: another marker that is tested in its stead is
missing wherever the gap's marker is (6). Else a marker that is lost in every stride would be judged by one that is seen
in all strides but one.

The idea of testing a filler on data that it has hidden itself is that of cross-validation (Stone 1974).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from ...data.progress import tell
from ...numerics.runs import true_runs
from ..known_samples import known_median
from ..marker_array import Gap, MarkerArray, Prediction
from .motion import PartMotion

Filler = Callable[..., list[Prediction]]
SHARE = 0.1
"""Of a marker's known samples, at most so many are hidden in one copy, unless by one test alone.
Chosen (see benchmarks/gaps.py)."""
MANY = 20
"""Gaps of a trial above which time counts more than the last tenth of a millimetre; chosen."""
FULL = 0.4
"""Share of the frames of a copy in which something is hidden, above which no further windows are drawn into it: fillers
learn from frames in which many markers are seen; chosen."""
BESIDE, BESIDE_OF = 3, 50
"""Frames on both sides of a gap in which others are missing as in it (1): fillers tie their fill to these. At most one
in so many frames of the trial, as short ones have no room for such tests; chosen (36 frames with 34 gaps were filled up
to 15 % worse with three)."""
SHORTER = 0.7
"""By what a test's length shrinks until it fits, where no marker of the trial has room.
Chosen (see benchmarks/gaps.py)."""

LIKE = 0.4
"""Of ln motion: windows within it of the gap move as it does; chosen (see benchmarks/gaps.py)."""
LEAST = 0.15
"""Share of the windows from which tests are drawn, at least, be they easier or harder; chosen."""
EASY = 0.4
"""Of ln motion: where all windows of the marker fall short of the gap by more, other markers' are asked too; chosen."""
FEW = 2
"""Windows that share no frame: where at most so many move as the gap does, other markers are asked too; chosen."""


class HoldOutGap(NamedTuple):
    """One window to be filled in one copy of the trial.

    Attributes:
        of: index of the gap that it stands for.
        copy: number of the copy.
        window: what the filler is asked to fill.
        keep: those frames of the window that are compared: first and last plus one, counted from its start.
        own: it is the gap's own marker.
        motion: of the body part in those frames (`motion`), √(mm rad).
    """

    of: int
    copy: int
    window: Gap
    keep: tuple[int, int]
    own: bool
    motion: float = 1.0


class HoldOutGaps(NamedTuple):
    """All tests, and what is hidden in each copy."""

    tests: list[HoldOutGap]
    copies: list[list[Gap]]


class HoldOutResult(NamedTuple):
    """What one filler did in one test of L frames.

    Attributes:
        test: which.
        error: (L, 3) mm, prediction less truth; empty where it had no prediction.
        cov: (L, 3, 3) mm², the filler's own, NaN where it does not say.
        edge: (L) frames to the nearest known sample of the marker.
    """

    test: HoldOutGap
    error: Floats
    cov: Floats
    edge: Floats

    @property
    def mean(self) -> float:
        """Mean distance from the truth, mm; infinite where there is no prediction."""
        return float(np.linalg.norm(self.error, axis=1).mean()) if len(self.error) else np.inf


def draw_hold_out_gaps(motion: MarkerArray, gaps: list[Gap], *, per_gap: int, seed: int) -> HoldOutGaps:
    """Tests for all gaps; a gap for which no marker has room at any length has none."""
    rng = np.random.default_rng(seed)
    source = _Source(motion, motion.seen, PartMotion(motion), cache(lambda marker: distances(motion, marker)))
    made, occupancy = HoldOutGaps([], []), _Occupancy(source.seen, [], {}, {})
    order, tight = rng.permutation(len(gaps)), len(gaps) > MANY
    if tight:
        order = order[np.argsort([-gaps[index].length for index in order], kind="stable")]
    for number, index in enumerate(order):
        tell(number, len(order))
        references = source.moving.references(gaps[index])
        for start, gap, stop in _windows(source, gaps[index], per_gap, rng, occupancy if tight else None):
            own = gap.marker == gaps[index].marker
            shape, marker = Gap(gap.marker, min(start, gap.start), max(stop, gap.stop)), gaps[index].marker
            copy = occupancy.place(shape, marker)
            if copy == len(made.copies):
                made.copies.append([])
            made.copies[copy] += [shape, *_state(source, gaps[index], gap)]
            if not own:
                made.copies[copy] += [Gap(gap.marker, a, b) for a, b in true_runs(~source.seen[marker]).tolist()]  # (6)
            keep = (gap.start - shape.start, gap.stop - shape.start)
            moving = source.moving.of_gap(gap, references if own else None)
            made.tests.append(HoldOutGap(int(index), copy, shape, keep, own, moving))
    return made


def run(motion: MarkerArray, hold_out: HoldOutGaps, filler: Filler, method: Any) -> list[HoldOutResult]:
    """All tests of one method, copy by copy."""
    found: list[HoldOutResult] = []
    for number, hide in enumerate(hold_out.copies):
        tell(number, len(hold_out.copies))
        tests = [test for test in hold_out.tests if test.copy == number]
        copy = motion.hidden(hide)
        filled = filler(copy, [test.window for test in tests], method=method)
        found += [_compare(motion, test, prediction) for test, prediction in zip(tests, filled, strict=True)]
    return found


def edge_distance(motion: MarkerArray, gap: Gap) -> Floats:
    """(L) frames from each frame of the gap to the nearest known sample beside it."""
    frames = np.arange(gap.start, gap.stop, dtype=np.float64)
    before = frames - gap.start + 1 if gap.start > 0 else np.full(gap.length, np.inf)
    after = gap.stop - frames if gap.stop < motion.xyz.shape[1] else np.full(gap.length, np.inf)
    return np.minimum(before, after)


def _compare(motion: MarkerArray, test: HoldOutGap, prediction: Prediction) -> HoldOutResult:
    window, (first, last) = test.window, test.keep
    error = (prediction.xyz - motion.xyz[window.marker, window.start : window.stop])[first:last]
    cov, edge = prediction.cov[first:last], edge_distance(motion, window)[first:last]
    if not np.isfinite(error).all():
        return HoldOutResult(test, error[:0], cov[:0], edge[:0])
    return HoldOutResult(test, error, cov, edge)


class _Source(NamedTuple):
    """The trial that tests are drawn from: which samples are seen, how parts move, distances of all from one marker."""

    motion: MarkerArray
    seen: Bools
    moving: PartMotion
    apart: Callable[[int], Floats]


class _Occupancy(NamedTuple):
    """Which frames of each copy are taken, how much of each marker, and for a gap of which marker each is hidden."""

    seen: Bools
    busy: list[Bools]
    taken: dict[tuple[int, int], int]
    of: dict[tuple[int, int], int]

    def place(self, gap: Gap, of: int) -> int:
        """The first copy with room for a window that is a test of that marker's gap; the room is then taken.

        A marker that is missing as another is (6) is in no other test of the copy.
        """
        room = SHARE * self.seen[gap.marker].sum() if of == gap.marker else np.inf
        for copy, busy in enumerate(self.busy):
            sum_after = self.taken.get((copy, gap.marker), 0) + gap.length
            mine = self.of.get((copy, gap.marker), of) == of
            if mine and sum_after <= room and not busy[gap.start : gap.stop].any():
                break
        else:
            copy = len(self.busy)
            self.busy.append(np.zeros(self.seen.shape[1], np.bool_))
        beside = _beside(self.seen)
        self.busy[copy][max(gap.start - beside, 0) : gap.stop + beside] = True
        self.taken[copy, gap.marker] = self.taken.get((copy, gap.marker), 0) + gap.length
        self.of[copy, gap.marker] = of
        return copy

    def with_room(self, marker: int, length: int, starts: Ints) -> Ints:
        """Those of the starts of a window that the first copy with room for any has room for; all where none has."""
        room = SHARE * self.seen[marker].sum()
        for copy, busy in enumerate(self.busy):
            mine = self.of.get((copy, marker), marker) == marker
            if mine and self.taken.get((copy, marker), 0) + length <= room and busy.mean() < FULL:
                taken = np.concatenate([[0], np.cumsum(busy)])
                free = starts[taken[starts + length] == taken[starts]]
                if len(free):
                    return free
        return starts


def _windows(
    source: _Source, gap: Gap, n: int, rng: np.random.Generator, occupancy: _Occupancy | None
) -> list[tuple[int, Gap, int]]:
    """Up to n windows (first hidden frame, window compared, last hidden frame + 1) for a gap.

    With `occupancy`, where the copies have room.
    """
    length, seen = gap.length, source.seen
    F = seen.shape[1]
    while length >= 1:
        own, easy = _starts(seen[gap.marker], length), False
        if len(own) and 1.5 * length <= seen[gap.marker].sum():  # half as much is left to learn from
            own, easy = _as_moving(own, source.moving, gap, length)
            easy = easy or (occupancy is None and _at_few_places(own, length))
            own = occupancy.with_room(gap.marker, length, own) if occupancy else own
            chosen = [Gap(gap.marker, int(a), int(a) + length) for a in _spread(own, -(-n // 2) if easy else n, rng)]
        else:
            chosen, easy = [], True
        if easy:
            chosen += _windows_of_neighbours(source, gap, length, n if chosen else 2 * n)
        if chosen:
            return [(0 if gap.start == 0 else w.start, w, F if gap.stop == F else w.stop) for w in chosen]  # (2)
        length = int(SHORTER * length)
    return []


def _as_moving(starts: Ints, moving: PartMotion, gap: Gap, length: int) -> tuple[Ints, bool]:
    """(5): those of the starts of a window in which the part moves most as it does in the gap, and whether it moves
    clearly less in all of them."""
    references = moving.references(gap)
    difference = np.log(moving.of(gap.marker, starts, length, references) / moving.of_gap(gap, references))
    alike = max(LIKE, float(np.quantile(np.abs(difference), LEAST)))
    chosen = np.abs(difference) <= alike
    return starts[chosen], bool(difference[chosen].max() < -EASY)


def _at_few_places(starts: Ints, length: int) -> bool:
    """(7): whether no more than FEW windows of so many frames, from starts that rise, share no frame."""
    at = 0
    for _ in range(FEW):
        at = int(np.searchsorted(starts, starts[at] + length))
        if at == len(starts):
            return True
    return False


def _windows_of_neighbours(source: _Source, gap: Gap, length: int, n: int) -> list[Gap]:
    """(3): the same frames, or the first so many of them, of the n nearest markers known there and on both sides."""
    window, seen = slice(max(gap.start - 1, 0), gap.start + length + 1), source.seen
    known = seen[:, window].all(1) & ((seen & seen[gap.marker]).sum(1) > 0.5 * seen[gap.marker].sum())
    known[gap.marker] = False
    apart = source.apart(gap.marker)
    near = [k for k in np.argsort(apart) if known[k] and np.isfinite(apart[k])]
    return [Gap(int(k), gap.start, gap.start + length) for k in near[:n]]


def distances(motion: MarkerArray, marker: int) -> Floats:
    """(M) mm, median distance of all markers from one, over at most a few hundred frames; NaN where never together."""
    thin = motion.xyz[:, :: max(1, motion.xyz.shape[1] // 300)]
    return known_median(np.linalg.norm(thin - thin[marker], axis=-1).T)


def _beside(seen: Bools) -> int:
    return min(BESIDE, seen.shape[1] // BESIDE_OF)


def _starts(known: Bools, length: int) -> Ints:
    """Where a window of a marker may start: known throughout and one frame on both sides."""
    seen = np.concatenate([[0], np.cumsum(known)])
    if len(seen) < length + 3:
        return np.zeros(0, np.int64)
    return np.flatnonzero(seen[length + 2 :] - seen[: -length - 2] == length + 2) + 1


def _spread(starts: Ints, n: int, rng: np.random.Generator) -> Ints:
    """About n of the starts, one drawn from each of n equal shares."""
    shares = np.array_split(starts, min(n, len(starts)))
    return np.array([rng.choice(share) for share in shares])


def _state(source: _Source, gap: Gap, window: Gap) -> list[Gap]:
    """(1): what else is missing in the gap and beside it, shifted to the window; (4) where that is another marker's."""
    beside = _beside(source.seen)
    first, stop = max(gap.start - beside, 0), gap.start + window.length
    missing = ~source.seen[:, first : stop + (beside if stop == gap.stop else 0)]
    missing[gap.marker, gap.start - first : stop - first] = False
    if window.marker != gap.marker:
        missing[[gap.marker, window.marker]] = False  # (6) is about these
    others = np.flatnonzero(missing.any(1))
    alike = window.marker == gap.marker or not len(others)
    as_it = {} if alike else _corresponding(source, gap.marker, window.marker, others)
    shift = first + window.start - gap.start
    out = []
    for marker in others.tolist():
        runs = np.clip(true_runs(missing[marker]) + shift, 0, source.seen.shape[1]).tolist()
        for hidden in {marker, as_it.get(marker, marker)}:
            out += [Gap(hidden, a, b) for a, b in runs if a < b]
    return out


def _corresponding(source: _Source, marker: int, other: int, missing: Ints) -> dict[int, int]:
    """(4): for each missing marker, that which is as many-th nearest to the other marker as it is to this one.

    Those as near to the other marker that are missing anyway, this one too, stand for as many.
    """
    order, theirs = (np.argsort(source.apart(k), kind="stable") for k in (marker, other))
    place = np.argsort(order)[missing]
    near, gone = theirs[1 : place.max() + 2], [marker, *missing]
    spare = int(np.isin(near, gone).sum() - np.isin(theirs[place], gone).sum())
    last = np.argsort(place)[: max(0, len(missing) - max(spare, 0))]
    return {int(missing[k]): int(theirs[place[k]]) for k in last if theirs[place[k]] != other}
