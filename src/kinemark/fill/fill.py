"""Filling the gaps of a trial, each with an expected error and every sample with a covariance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Floats
from .edges import GapEdges, trim_edges
from .judge.auto import Auto
from .judge.combine import close_ones, mean_prediction, mean_tests, together
from .judge.combine import weights as best_weights
from .judge.expected_error import ErrorCalibration, MeasuredErrors, as_hard, weigh
from .judge.hold_out import MANY, Candidate, edge_distance, plan, run
from .known_samples import possible
from .marker_array import Gap, MarkerArray, Prediction, find_gaps
from .methods.stage import FILL, FillMethod, filler_of
from .static import place_absent
from .static_shape import StaticShape

SLOW = 600_000
"""Gaps times frames above which methods that look at the whole trial for each hidden test are not tried; chosen."""
LIMIT = 20.0
"""mm of expected error above which a gap stays open; chosen: about a marker's diameter (see benchmarks/gaps.py)."""
ENOUGH = 60
"""Hidden tests of one method that tell how far off it is; more are made to choose one for each gap.
Chosen (see benchmarks/gaps.py)."""
FIRST = "body"
"""The method that is best in most trials (docs/fill.md)."""
MOSTLY = 0.6
"""Of what is known must be left where all tests are hidden at once, for methods to learn from that.
Chosen (see benchmarks/gaps.py)."""
LITTLE = 0.05
"""Of the weight of a mean, below which a method is not named; chosen."""
UNASKED = Prediction(np.zeros((1, 3)), np.full((1, 3, 3), np.nan))
"""Stands where a method was tried in the tests, but not asked about the gap itself; by definition."""


@dataclass(frozen=True, slots=True)
class FilledGap:
    """One gap and what became of it.

    Attributes:
        marker: its name; start, stop: its frames, from 0, stop excluded.
        method: name of the method that filled it; empty when it stays open.
        expected_mm: mean error expected of the fill, from hidden tests; NaN where none could be made.
        candidates: expected mean error of every method that was tried, mm; infinite where it had nothing to say. In
            trials of many gaps by the tests alone for a method that was not asked about this gap.
        tests: number of hidden tests made for this gap; some have none of their own where there is one method alone.
        reference_markers: those that it was filled from.
        trimmed: frames of the gap that had been measured and are taken to be wrong; filled too, unless it stays open.
        reason: why it stays open; empty when it is filled.
    """

    marker: str
    start: int
    stop: int
    method: str
    expected_mm: float
    candidates: Mapping[str, float] = field(default_factory=dict)
    tests: int = 0
    reference_markers: tuple[str, ...] = ()
    trimmed: tuple[int, ...] = ()
    reason: str = ""

    @property
    def length(self) -> int:
        """Frames."""
        return self.stop - self.start


class Filled(NamedTuple):
    """A trial with its gaps filled, and what is to be said of each gap."""

    trajectories: Trajectories
    gaps: tuple[FilledGap, ...]


class FillAnswer(NamedTuple):
    """One method's predictions for all gaps, how it did in the hidden tests, and the form of it that did so."""

    name: str
    said: list[Prediction]
    measured: MeasuredErrors
    calibration: ErrorCalibration
    tried: list[Candidate]
    method: Any = None


def fill(
    trajectories: Trajectories,
    *,
    method: Any = None,
    limit_mm: float = LIMIT,
    ends: bool = False,
    edges: GapEdges | None = None,
    static: Trajectories | None = None,
    seed: int = 0,
) -> Filled:
    """Fill the gaps of a trial.

    Samples more than a kilometre from the median of all become missing; bad ones beside gaps are filled (`GapEdges`).

    Args:
        trajectories: the trial; what is filled already counts as seen.
        method: one of `FILL`; `Auto()` when None.
        limit_mm: gaps with a greater expected mean error stay open; infinite fills all that can be filled.
        ends: also fill before a marker's first sample and after its last.
        edges: how samples beside gaps are judged and trimmed; `GapEdges()` when None, `GapEdges(most=0)` trims none.
        static: another trial of the same markers; those that this trial never shows are placed from it.
        seed: of the places of the hidden tests.

    Raises:
        ValueError: the method is none of `FILL`, or the limit is not above 0.
    """
    method = Auto() if method is None else method
    if not limit_mm > 0:
        raise ValueError(f"limit_mm is {limit_mm}, wanted above 0")
    candidates = method.methods if isinstance(method, Auto) else (method,)
    for candidate in candidates:
        filler_of(candidate)
    motion = within_reach(MarkerArray.of(trajectories))
    written = _Columns(trajectories)
    written.drop(~motion.seen)
    motion = trim_edges(motion, find_gaps(motion), method=edges or GapEdges()).motion
    gaps = find_gaps(motion, ends=ends)
    if isinstance(method, Auto):
        candidates = tuple(affordable(candidates, len(gaps), trajectories.n_frames))
    answers = (ask_winners if len(gaps) > MANY and len(candidates) > 1 else ask)(motion, gaps, candidates, seed=seed)
    told = []
    for index, gap in enumerate(gaps):
        found, said, cov = choose(motion, gaps, index, answers)
        found = _within(replace(found, trimmed=written.measured(gap)), limit_mm)
        told.append(found)
        if found.method:
            written.put(gap, said.xyz, cov)
    filled = Filled(written.trajectories(), tuple(told))
    return filled if static is None else _with_static(filled, static, limit_mm)


def affordable(methods: Sequence[FillMethod], gaps: int, frames: int) -> list[FillMethod]:
    """Those of the methods to choose from that a trial of so many gaps and frames leaves time for."""
    quick = [method for method in methods if not method.slow]
    return quick if quick and gaps * frames > SLOW else list(methods)


def within_time(method: FillMethod, gaps: list[Gap], source: MarkerArray | None) -> FillMethod:
    """The method itself, or a faster form of it where there are many gaps; for `source` see `FillMethod`."""
    return method if len(gaps) <= MANY else method.for_many_gaps(gaps, source)


def tests_per_gap(gaps: int) -> int:
    """How often each gap is tried: more where there are few gaps, as tests of other gaps tell less of it."""
    return int(np.clip(200 // gaps, 1, 12))


def within_reach(motion: MarkerArray) -> MarkerArray:
    """The trial without samples that cannot be positions: a filler would take them for motion."""
    known = possible(motion.xyz)
    outliers = motion.seen & ~known
    return motion._replace(xyz=np.where(known[..., None], motion.xyz, np.nan)) if outliers.any() else motion


def ask(motion: MarkerArray, gaps: list[Gap], candidates: Sequence[Any], *, seed: int = 0) -> list[FillAnswer]:
    """What each method says of all gaps, and how it does in one set of hidden tests."""
    return _asked(motion, gaps, candidates, seed, lambda _: True)


def ask_winners(motion: MarkerArray, gaps: list[Gap], candidates: Sequence[Any], *, seed: int = 0) -> list[FillAnswer]:
    """As `ask`, but of each gap only the methods that are needed to choose and fill are asked, for time's sake.

    That is the one that does best in the tests; the next best where that has nothing to say; and those
    that answer for all gaps together.
    """
    answers = _asked(motion, gaps, candidates, seed, lambda method: method.together)
    left = set(range(len(gaps)))
    while left:
        lead = {index: _leader(answers, *_told(answers, gaps, index)) for index in left}
        left = {index for index in left if lead[index].said[index] is UNASKED}
        for answer in answers:
            mine = sorted(index for index in left if lead[index] is answer)
            for index, said in zip(mine, _say(motion, [gaps[i] for i in mine], answer.method), strict=True):
                answer.said[index] = said
        left = {index for index in left if not np.isfinite(lead[index].said[index].xyz).all()}
    return answers


def _asked(
    motion: MarkerArray, gaps: list[Gap], candidates: Sequence[Any], seed: int, whether: Callable[[Any], bool]
) -> list[FillAnswer]:
    """The hidden tests of all methods, and what those of them say that are asked.

    What a method learns once for all gaps it learns from the trial with all tests hidden: none has its answer in it.
    Where that would leave too little to learn from, it learns in each copy anew.
    """
    if not gaps:
        return []
    tested = _tested(gaps) if len(candidates) == 1 else list(range(len(gaps)))
    planned = plan(motion, [gaps[k] for k in tested], per_gap=tests_per_gap(len(gaps)), seed=seed)
    planned = planned._replace(tests=[test._replace(of=tested[test.of]) for test in planned.tests])
    hidden = motion.hidden(gap for copy in planned.copies for gap in copy)
    source = hidden if hidden.seen.sum() > MOSTLY * motion.seen.sum() else None
    answers = []
    for candidate in candidates:
        method = within_time(candidate, gaps, source)
        tried = run(motion, planned, filler_of(method), method)
        said = _say(motion, gaps, method) if whether(method) else [UNASKED] * len(gaps)
        answers.append(
            FillAnswer(FILL.of(method).name, said, MeasuredErrors(tried), ErrorCalibration(tried), tried, method)
        )
    return answers


def _tested(gaps: list[Gap]) -> list[int]:
    """The gaps for which tests are made where there is no method to choose: `ENOUGH`, of all markers and lengths.

    Each marker's gap of median length comes first, as methods do better with some markers than with others.
    """
    order = sorted(range(len(gaps)), key=lambda k: gaps[k].length)
    of_marker: dict[int, list[int]] = {}
    for k in order:
        of_marker.setdefault(gaps[k].marker, []).append(k)
    median = [own[len(own) // 2] for own in of_marker.values()][:ENOUGH]
    rest = [k for k in order if k not in median]
    places = np.linspace(0, len(rest) - 1, min(ENOUGH - len(median), len(rest))).astype(int)
    return sorted({*median, *(rest[k] for k in places)})


def _say(motion: MarkerArray, gaps: list[Gap], method: Any) -> list[Prediction]:
    """What a method says of some gaps, if any."""
    return filler_of(method)(motion, gaps, method=method) if gaps else []


def _within(found: FilledGap, limit_mm: float) -> FilledGap:
    """The same, open with a reason where no error or too great a one is expected."""
    if found.reason or (found.expected_mm <= limit_mm and np.isfinite(found.expected_mm)):
        return found
    if not np.isfinite(found.expected_mm):
        reason = "no hidden test could be made: too little of the trial is known to say how far off a fill would be"
    else:
        reason = (
            f"the best method ({found.method}) is expected to be off by {found.expected_mm:.1f} mm, "
            f"more than the limit of {limit_mm:g} mm"
        )
    return replace(found, method="", reason=reason)


def _with_static(filled: Filled, static: Trajectories, limit_mm: float) -> Filled:
    """Markers that the trial never shows, placed from the static trial; new ones come last."""
    trajectories = filled.trajectories
    motion = within_reach(MarkerArray.of(trajectories))
    paths, told = {path.name: path for path in trajectories}, list(filled.gaps)
    for placed in place_absent(motion, StaticShape.of(within_reach(MarkerArray.of(static)))):
        found = FilledGap(
            placed.name,
            0,
            trajectories.n_frames,
            "static",
            placed.expected_mm,
            reference_markers=placed.references,
            reason=placed.reason,
        )
        found = _within(replace(found, method="") if placed.reason else found, limit_mm)
        told.append(found)
        if found.method:
            path = MarkerTrajectory.measured(placed.name, placed.xyz, cov=placed.cov)
            origin = np.where(path.origin == Origin.MEASURED, Origin.FILLED, Origin.MISSING)
            paths[placed.name] = replace(path, origin=origin.astype(np.uint8))
    return Filled(replace(trajectories, paths=tuple(paths.values())), tuple(told))


def choose(
    motion: MarkerArray, gaps: list[Gap], index: int, answers: list[FillAnswer]
) -> tuple[FilledGap, Prediction, Floats]:
    """The method that does best in the tests for one gap, its prediction, and the calibrated covariance."""
    gap = gaps[index]
    told, weights = _told(answers, gaps, index)
    best = _leader(answers, told, weights)
    if len(gaps) <= MANY and (mean := _mean_of_close(answers, told, index, weights)) and mean.name not in told:
        told[mean.name] = mean.measured.expect(mean.said[index], weights)
        if mean.measured.behind(best.measured, weights, sure=0.5) < 0:  # one mean, no luckiest of many
            best = mean
    expected = {name: mm for name, (mm, _) in told.items()}
    said = best.said[index]
    tests = sum(t.test.of == index for t in best.tried)
    found = FilledGap(motion.names[gap.marker], gap.start, gap.stop, best.name, expected[best.name], expected, tests)
    if not np.isfinite(said.xyz).all():
        why = said.reason or "no method has anything to say here"
        return replace(found, method="", expected_mm=np.nan, reason=why), said, said.cov
    references = tuple(motion.names[d] for d in said.references)
    return (
        replace(found, reference_markers=references),
        said,
        best.calibration.covariance(said, edge_distance(motion, gap), weights),
    )


def _told(answers: list[FillAnswer], gaps: list[Gap], index: int) -> tuple[dict[str, tuple[float, float]], Floats]:
    """Expected and typical error of one gap by each method, and what each test counts for it.

    By how far two methods are apart too, where there are two, and few enough gaps that all were asked about each.
    """
    weights = weigh([t.test for t in answers[0].tried], index, gaps)

    def told() -> dict[str, tuple[float, float]]:
        return {answer.name: answer.measured.expect(answer.said[index], weights) for answer in answers}

    found = told()
    able = sorted((a for a in answers if np.isfinite(found[a.name][1])), key=lambda a: found[a.name][1])
    if len(able) < 2 or len(gaps) > MANY:
        return found, weights
    apart = np.array([_apart(x.error, y.error) for x, y in zip(able[0].tried, able[1].tried, strict=True)])
    weights = weights * as_hard(apart, _apart(able[0].said[index].xyz, able[1].said[index].xyz))
    return told(), weights


def _apart(one: Floats, other: Floats) -> float:
    """Root mean square distance of two methods' predictions (L, 3), or errors, mm; infinite where one has none."""
    return float(np.sqrt(((one - other) ** 2).sum(1).mean())) if len(one) and len(other) else np.inf


def _leader(answers: list[FillAnswer], told: dict[str, tuple[float, float]], weights: Floats) -> FillAnswer:
    """The least typical error; `FIRST` where it can be used, unless another beats it by more than chance."""
    first = next((a for a in answers if a.name == FIRST and np.isfinite(told[a.name][1])), None)
    if first is None:
        return min(answers, key=lambda a: np.nan_to_num(told[a.name][1], nan=1e300))
    able = [a for a in answers if np.isfinite(told[a.name][1]) and a is not first]
    best = min(able, key=lambda a: a.measured.behind(first.measured, weights), default=first)
    return best if best.measured.behind(first.measured, weights) < 0 else first


def _mean_of_close(
    answers: list[FillAnswer], told: dict[str, tuple[float, float]], index: int, counts: Floats
) -> FillAnswer | None:
    """The weighed mean of methods that do nearly as well for one gap; other gaps of it are not worked out."""
    close = close_ones([np.nan_to_num(told[answer.name][1], nan=np.inf, posinf=np.inf) for answer in answers])
    if not close:
        return None
    chosen = [answers[k] for k in close]
    products = together([answer.tried for answer in chosen])
    w = best_weights(products, counts)
    each = np.tile(w, (len(counts), 1))
    for k in np.flatnonzero([tried.test.of == index for tried in chosen[0].tried]):
        each[k] = best_weights(products, np.where(np.arange(len(counts)) == k, 0.0, counts))
    tried = mean_tests([answer.tried for answer in chosen], each)
    said = list(chosen[0].said)
    said[index] = mean_prediction([answer.said[index] for answer in chosen], w)
    name = " + ".join(answer.name for answer, share in zip(chosen, w, strict=True) if share > LITTLE)
    return FillAnswer(name, said, MeasuredErrors(tried), ErrorCalibration(tried), tried)


class _Columns:
    """Copies of the paths that gaps are written into; others are shared with the trial."""

    def __init__(self, trajectories: Trajectories) -> None:
        self.source = trajectories
        self.changed: dict[int, dict[str, Any]] = {}

    def measured(self, gap: Gap) -> tuple[int, ...]:
        """Frames of a gap in which the trial has a sample."""
        origin = self.source.paths[gap.marker].origin[gap.start : gap.stop]
        return tuple(int(f) for f in gap.start + np.flatnonzero(origin != Origin.MISSING))

    def of(self, marker: int) -> dict[str, Any]:
        """The columns of a marker, copied when they are first asked for."""
        names = ("xyz", "cov", "origin", "residual", "cameras", "view")
        path = self.source.paths[marker]
        return self.changed.setdefault(marker, {name: getattr(path, name).copy() for name in names})

    def drop(self, missing: NDArray[np.bool_]) -> None:
        """Make samples (M, F) missing that are no positions, whether their gap is filled or stays open."""
        for marker, path in enumerate(self.source.paths):
            outliers = missing[marker] & (path.origin != Origin.MISSING)
            if outliers.any():
                into = self.of(marker)
                into["xyz"][outliers] = into["cov"][outliers] = into["residual"][outliers] = np.nan
                into["origin"][outliers], into["cameras"][outliers], into["view"][outliers] = Origin.MISSING, 0, -1

    def put(self, gap: Gap, xyz: Floats, cov: Floats) -> None:
        """Fill a gap."""
        into, at = self.of(gap.marker), slice(gap.start, gap.stop)
        into["xyz"][at], into["cov"][at] = xyz, cov
        into["origin"][at], into["residual"][at] = Origin.FILLED, np.nan
        into["cameras"][at], into["view"][at] = 0, -1

    def trajectories(self) -> Trajectories:
        """The trial with all that was put."""
        paths = [
            replace(path, **self.changed[k]) if k in self.changed else path for k, path in enumerate(self.source.paths)
        ]
        return replace(self.source, paths=tuple(paths))
