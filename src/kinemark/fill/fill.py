"""Filling the gaps of a trial, each with an expected error and every sample with a covariance."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence, Sized
from dataclasses import replace
from typing import Any, cast

import numpy as np

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.edits import OPEN, GapChoice
from ..data.progress import tell
from ..numerics.blas_threads import one_blas_thread
from ..numerics.evenly import evenly
from .chosen_gaps import chosen_gaps, groups
from .edges import GapEdges
from .filled_gap import Filled, FilledGap, GapState
from .judge.auto import Auto
from .judge.choice import CandidateFill, ChosenFill, best_candidate, expected_errors
from .judge.contradiction import contradicts_jump, contradicts_sd
from .judge.expected_error import ErrorCalibration, MeasuredErrors
from .judge.hold_out import MANY, draw_hold_out_gaps, run
from .judge.motion import PartMotion
from .judged_fill import KnownEdges, judged
from .known_samples import plausible
from .marker_array import Gap, MarkerArray, Prediction, find_gaps
from .methods.stage import FILL, FillMethod, filler_of
from .name_order import as_before, by_name
from .static import place_absent
from .static_shape import StaticShape
from .trial_copy import TrialCopy
from .usual_limit import usual_limit

SLOW = 600_000
"""Gaps times frames above which methods that look at the whole trial for each hold-out gap are not tried; chosen."""
NOT_PREDICTED = Prediction(np.zeros((1, 3)), np.full((1, 3, 3), np.nan))
"""Stands where a method was tried in the tests, but not asked about the gap itself; by definition."""
ENOUGH = 60
"""Hold-out gaps of one method that tell how far off it is; more are made to choose one for each gap.
Chosen (see benchmarks/gaps.py)."""
MOST_TESTED = 300
"""Gaps for which tests are made where a method is chosen for each; the others are judged by the tests of these. Chosen
for time and memory, which grow with the square of the tests. In trials of fewer gaps nothing changes."""
FEWEST = 4
"""Hold-out gaps of each gap that is filled once more without suspicious samples; chosen for time: what is usual of a
method counts as many (`judge.expected_error`)."""
LONGEST = 0.3
"""Of these, the share that are the longest gaps of the trial, which each have tests of their own as they are the most
uncertain; chosen."""
MOSTLY = 0.6
"""Of what is known must be left where all tests are hidden at once, for methods to learn from that.
Chosen (see benchmarks/gaps.py)."""


@one_blas_thread()
def fill(
    trajectories: Trajectories,
    *,
    method: Any = None,
    limit_mm: float | None = None,
    ends: bool = False,
    edges: GapEdges | None = None,
    trim: int = 0,
    static: Trajectories | None = None,
    seed: int = 0,
    choices: Sequence[GapChoice] = (),
) -> Filled:
    """Fill the gaps of a trial.

    What was measured stays as it is. The exceptions are samples more than a kilometre from the median of all, which are
    no positions and become missing, and suspicious ones beside gaps where `trim` asks for that. The order of the
    markers makes no difference.

    Args:
        trajectories: the trial; what is filled already counts as seen.
        method: one of `FILL`; `Auto()` when None.
        limit_mm: gaps with a greater expected mean error stay open; infinite fills all that can be filled. None: 20, or
            less where what is measured is smaller than a person (`usual_limit`).
        ends: also fill before a marker's first sample and after its last.
        edges: how samples beside gaps are judged; `GapEdges()` when None; `GapEdges(most_trimmed=0)` judges none.
        trim: so many suspicious samples on each side of a gap may be replaced; 0: they are listed and kept.
        static: another trial of the same markers; those that this trial never shows are placed from it.
        seed: of the places of the hold-out gaps.
        choices: how somebody wants single gaps filled; these are filled whatever error is expected, others as without.

    Raises:
        ValueError: the method or a choice is none of `FILL`, or the limit is not above 0.
    """
    method = Auto() if method is None else method
    usual = usual_limit(trajectories.xyz)
    limit_mm = usual if limit_mm is None else limit_mm
    candidates = _candidates(method, limit_mm)
    edges = replace(edges or GapEdges(), most_trimmed=trim) if trim else edges or GapEdges()
    given, trajectories = trajectories, by_name(trajectories)
    known = KnownEdges.of(without_outliers(MarkerArray.of(trajectories)), edges, keep=not trim)
    gaps = of_markers(find_gaps(known.motion, ends=ends), known.motion.names)
    if isinstance(method, Auto):
        candidates = tuple(affordable(candidates, len(gaps), trajectories.n_frames))
    chosen = chosen_gaps(known.motion, trajectories, choices)

    def again(motion: MarkerArray, longer: list[Gap], names: Collection[str]) -> list[ChosenFill]:
        wanted = chosen_gaps(motion, trajectories, choices)
        own = {gap: wanted[gap] for gap in longer if wanted.get(gap, OPEN) != OPEN}
        return _fills(motion, longer, called(candidates, names), own, seed, tests_again(longer, gaps))

    fills = _fills(known.motion, gaps, candidates, chosen, seed)
    written = TrialCopy(trajectories)
    written.drop(~known.plausible)
    done = [_left_open(known.motion, gap) for gap, choice in chosen.items() if choice == OPEN]
    for one in judged(fills, known, again):
        found = replace(one.found, trimmed=written.measured(one.gap))
        found = found if one.gap in chosen else _within(found, limit_mm, usual)
        done.append(found)
        if found.method:
            written.put(one.gap, one.prediction.xyz, one.cov)
    done.sort(key=lambda found: (given.names.index(found.marker), found.start))
    filled = Filled(as_before(written.trajectories(), given), tuple(done))
    return filled if static is None else _with_static(filled, static, limit_mm)


def _candidates(method: Any, limit_mm: float) -> tuple[FillMethod, ...]:
    """The methods to choose from.

    Raises:
        ValueError: one is none of `FILL`, or the limit is not above 0.
    """
    if not limit_mm > 0:
        raise ValueError(f"limit_mm is {limit_mm}, wanted above 0")
    candidates = method.methods if isinstance(method, Auto) else (method,)
    for candidate in candidates:
        filler_of(candidate)
    return candidates


def of_markers(gaps: list[Gap], names: Sequence[str]) -> list[Gap]:
    """Those of markers; of a trial that has tracks with names, tracks without one are ghosts and left-over pieces."""
    named = [not name.startswith("*") for name in names]
    return [gap for gap in gaps if named[gap.marker]] if any(named) else gaps


def _fills(
    motion: MarkerArray,
    gaps: list[Gap],
    candidates: Sequence[Any],
    chosen: dict[Gap, str],
    seed: int,
    per_gap: int | None = None,
) -> list[ChosenFill]:
    """The best fill of each gap, and that of those for which somebody chose a method, by marker and frame."""
    answers = judged_together(motion, gaps, candidates, seed=seed, per_gap=per_gap)
    todo = [(gap, gaps, index, answers) for index, gap in enumerate(gaps) if gap not in chosen]
    for some, methods in groups(chosen, candidates):
        own = evaluate_candidates(motion, some, methods, seed=seed, per_gap=per_gap)
        todo += [(gap, some, index, own) for index, gap in enumerate(some)]
    return [ChosenFill.of(motion, among, index, by) for _, among, index, by in sorted(todo, key=lambda one: one[0])]


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


def tests_again(longer: Sized, gaps: Sized) -> int:
    """The same for some of a trial's gaps that are filled once more: as many as all had, or FEWEST."""
    return min(tests_per_gap(len(longer)), max(tests_per_gap(len(gaps)), FEWEST))


def called(methods: Sequence[Any], names: Collection[str]) -> list[Any]:
    """Those of the methods that have one of these names."""
    return [method for method in methods if FILL.of(method).name in names]


def without_outliers(motion: MarkerArray) -> MarkerArray:
    """The trial without samples that cannot be positions: a filler would take them for motion."""
    known = plausible(motion.xyz)
    outliers = motion.seen & ~known
    return motion._replace(xyz=np.where(known[..., None], motion.xyz, np.nan)) if outliers.any() else motion


def evaluate_candidates(
    motion: MarkerArray, gaps: list[Gap], candidates: Sequence[Any], *, seed: int = 0, per_gap: int | None = None
) -> list[CandidateFill]:
    """Each method's predictions for all gaps, and its results in one set of hold-out gaps.

    Args:
        motion: the trial. gaps: in it. candidates: methods. seed: of the places of hold-out gaps.
        per_gap: hold-out gaps of each; as many as `fill` makes where None.
    """
    return _evaluated(motion, gaps, candidates, seed, lambda _: True, per_gap)


def judged_together(
    motion: MarkerArray, gaps: list[Gap], candidates: Sequence[Any], *, seed: int = 0, per_gap: int | None = None
) -> list[CandidateFill]:
    """Each method's results in one set of hold-out gaps of all gaps, with the predictions needed to choose and fill."""
    evaluate = evaluate_leading if len(gaps) > MANY and len(candidates) > 1 else evaluate_candidates
    return evaluate(motion, gaps, candidates, seed=seed, per_gap=per_gap)


def evaluate_leading(
    motion: MarkerArray, gaps: list[Gap], candidates: Sequence[Any], *, seed: int = 0, per_gap: int | None = None
) -> list[CandidateFill]:
    """As `evaluate_candidates`, but each gap is predicted only by the methods needed to choose and fill: it is faster.

    That is the one that does best in the tests; the next best where that has no prediction; and those
    that answer for all gaps together.
    """
    answers = _evaluated(motion, gaps, candidates, seed, lambda method: method.together, per_gap)
    left = set(range(len(gaps)))
    while left:
        lead: dict[int, CandidateFill] = {}
        for index in left:
            tell(len(lead), len(left))
            lead[index] = best_candidate(answers, *expected_errors(answers, gaps, index), index)
        left = {index for index in left if lead[index].predictions[index] is NOT_PREDICTED}
        for answer in answers:
            tell(0, len(left))
            mine = sorted(index for index in left if lead[index] is answer)
            predictions = _predictions(motion, [gaps[i] for i in mine], answer.method)
            for index, prediction in zip(mine, predictions, strict=True):
                answer.predictions[index] = prediction
        left = {index for index in left if not np.isfinite(lead[index].predictions[index].xyz).all()}
    return answers


def _evaluated(
    motion: MarkerArray,
    gaps: list[Gap],
    candidates: Sequence[Any],
    seed: int,
    whether: Callable[[Any], bool],
    per_gap: int | None = None,
) -> list[CandidateFill]:
    """The results of all methods in the hold-out gaps, and the predictions of those that `whether` admits.

    What a method learns once for all gaps it learns from the trial with all tests hidden: none has its answer in it.
    Where that would leave too little to learn from, it learns in each copy anew.
    """
    if not gaps:
        return []
    tested = _gaps_to_test(gaps) if len(candidates) == 1 else _gaps_to_test(gaps, MOST_TESTED, longest=LONGEST)
    each = per_gap or tests_per_gap(len(gaps))
    hold_out = draw_hold_out_gaps(motion, [gaps[k] for k in tested], per_gap=each, seed=seed)
    hold_out = hold_out._replace(tests=[test._replace(of=tested[test.of]) for test in hold_out.tests])
    moving = PartMotion(motion)
    amount = [moving.of_gap(gap) for gap in gaps]
    hidden = motion.hidden(gap for copy in hold_out.copies for gap in copy)
    source = hidden if hidden.seen.sum() > MOSTLY * motion.seen.sum() else None
    answers = []
    for candidate in candidates:
        method = within_time(candidate, gaps, source)
        results = run(motion, hold_out, filler_of(method), method)
        predictions = _predictions(motion, gaps, method) if whether(method) else [NOT_PREDICTED] * len(gaps)
        name, measured, calibration = FILL.of(method).name, MeasuredErrors(results), ErrorCalibration(results)
        answers.append(CandidateFill(name, predictions, measured, calibration, results, method, amount))
    return answers


def _gaps_to_test(gaps: list[Gap], most: int = ENOUGH, *, longest: float = 0.0) -> list[int]:
    """The gaps for which tests are made: all, or so many of all markers and lengths where there are more.

    Each marker's gap of median length comes first, as methods do better with some markers than with others; then the
    longest, up to that share.
    """
    if len(gaps) <= most:
        return list(range(len(gaps)))
    order = sorted(range(len(gaps)), key=lambda k: gaps[k].length)
    of_marker: dict[int, list[int]] = {}
    for k in order:
        of_marker.setdefault(gaps[k].marker, []).append(k)
    first = [own[len(own) // 2] for own in of_marker.values()][:most]
    first = list(dict.fromkeys([*first, *order[len(order) - int(longest * most) :]]))[:most]
    taken = set(first)
    rest = [k for k in order if k not in taken]
    places = evenly(len(rest), most - len(first))
    return sorted({*first, *(rest[k] for k in places)})


def _predictions(motion: MarkerArray, gaps: list[Gap], method: Any) -> list[Prediction]:
    """What a method says of some gaps, if any."""
    return filler_of(method)(motion, gaps, method=method) if gaps else []


def _within(found: FilledGap, limit_mm: float, usual_mm: float) -> FilledGap:
    """The same, open where no error or too great a one is expected, or it cannot be one marker's."""
    if found.state != "filled":
        return found
    expected = found.expected_mm
    state = cast(GapState, found.state)
    if found.sides_mm and np.isfinite(limit_mm):
        state = "sides_contradict"
    elif not np.isfinite(expected):
        state = "no_hold_out"
    elif expected > limit_mm:
        state = "above_limit"
    elif contradicts_sd(found.sd_mm, expected, limit_mm):
        state = "sd_contradicts"
    elif contradicts_jump(found.jump_mm, expected, limit_mm, usual_mm):
        state = "jump_contradicts"
    return found if state == "filled" else replace(found, method="", state=state)


def _left_open(motion: MarkerArray, gap: Gap) -> FilledGap:
    """A gap that somebody chose to leave as it is."""
    return FilledGap(motion.names[gap.marker], gap.start, gap.stop, "", np.nan, state="left_open")


def _with_static(filled: Filled, static: Trajectories, limit_mm: float) -> Filled:
    """Markers that the trial never shows, placed from the static trial; new ones come last."""
    trajectories = filled.trajectories
    motion = without_outliers(MarkerArray.of(trajectories))
    paths, done = {path.name: path for path in trajectories}, list(filled.gaps)
    for placed in place_absent(motion, StaticShape.of(without_outliers(MarkerArray.of(static)))):
        found = FilledGap(
            placed.name,
            0,
            trajectories.n_frames,
            "static",
            placed.expected_mm,
            reference_markers=placed.references,
            reason=placed.reason,
        )
        found = _within(
            replace(found, method="", state="not_predicted") if placed.reason else found, limit_mm, limit_mm
        )
        done.append(found)
        if found.method:
            path = MarkerTrajectory.measured(placed.name, placed.xyz, cov=placed.cov)
            origin = np.where(path.origin == Origin.MEASURED, Origin.FILLED, Origin.MISSING)
            paths[placed.name] = replace(path, origin=origin.astype(np.uint8))
    return Filled(replace(trajectories, paths=tuple(paths.values())), tuple(done))
