"""Which method fills a gap: the best in the hold-out gaps, or a mean of those that do nearly as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...data.array_types import Floats
from ..filled_gap import FilledGap
from ..marker_array import Gap, MarkerArray, Prediction
from .combine import close_ones, mean_prediction, mean_tests, together
from .combine import weights as best_weights
from .contradiction import largest_sd
from .expected_error import (
    ErrorCalibration,
    MeasuredErrors,
    behind,
    difficulty_weight,
    hold_out_weights,
    likeness,
)
from .hold_out import MANY, HoldOutResult, edge_distance
from .luck import luck

FIRST = "body"
"""The method that is best in most trials (docs/theory/fill.md)."""
TELLING = 0.02
"""Of the weight of the test that counts most, above which a test tells the error of a gap; chosen."""
LITTLE = 0.05
"""Of the weight of a mean, below which a method is not named; chosen."""


class CandidateFill(NamedTuple):
    """One method's predictions for all gaps, how it did in the hold-out gaps, and the form of it that did so."""

    name: str
    predictions: list[Prediction]
    measured: MeasuredErrors
    calibration: ErrorCalibration
    results: list[HoldOutResult]
    method: Any = None
    motion: Sequence[float] = ()


class ChosenFill(NamedTuple):
    """The fill that was chosen for one gap.

    Attributes:
        gap: that it fills.
        found: what is said of it.
        prediction: (L, 3) mm. cov: (L, 3, 3) mm², calibrated.
        candidates: all that it was chosen from.
    """

    gap: Gap
    found: FilledGap
    prediction: Prediction
    cov: Floats
    candidates: list[CandidateFill]

    @classmethod
    def of(cls, motion: MarkerArray, gaps: list[Gap], index: int, answers: list[CandidateFill]) -> ChosenFill:
        """By `choose_candidate`."""
        return cls(gaps[index], *choose_candidate(motion, gaps, index, answers), answers)

    def witness(self) -> CandidateFill | None:
        """How `FIRST` did, which tells best where the marker is; None where it was not tried."""
        return next((one for one in self.candidates if one.name == FIRST), None)


def choose_candidate(
    motion: MarkerArray, gaps: list[Gap], index: int, answers: list[CandidateFill]
) -> tuple[FilledGap, Prediction, Floats]:
    """The method that does best in the tests for one gap, its prediction, and the calibrated covariance."""
    gap = gaps[index]
    errors, weights = expected_errors(answers, gaps, index)
    few = len(gaps) <= MANY
    alike = likeness([t.test for t in answers[0].results], gap, motion_of(answers[0], index)) if few else None
    best = best_candidate(answers, errors, weights, index, alike)
    if few and (mean := _mean_of_close(answers, errors, index, weights)) and mean.name not in errors:
        errors[mean.name] = mean.measured.expect(mean.predictions[index], weights, motion_of(best, index))
        ln_e = mean.measured.logs, best.measured.logs  # one mean, no luckiest of many
        if behind(*ln_e, best.measured.same, weights, alike, sure=0.5) < 0:
            best = mean
    lucky = few and best.name != FIRST and any(best is answer for answer in answers)
    factor = float(np.exp(luck([answer.measured for answer in answers], weights))) if lucky else 1.0
    expected = {name: mm for name, (mm, _) in errors.items()} | {best.name: factor * errors[best.name][0]}
    prediction = best.predictions[index]
    tests = sum(t.test.of == index for t in best.results)
    found = FilledGap(
        motion.names[gap.marker], gap.start, gap.stop, best.name, expected[best.name], expected, tests,
        motion_ratio=_motion_ratio(answers[0], index, weights),
    )  # fmt: skip
    if not np.isfinite(prediction.xyz).all():
        why = prediction.reason or "no method has a prediction here"
        missing = replace(found, method="", expected_mm=np.nan, state="not_predicted", reason=why)
        return missing, prediction, prediction.cov
    references = tuple(motion.names[d] for d in prediction.references)
    cov = factor**2 * best.calibration.covariance(prediction, edge_distance(motion, gap), weights)
    return replace(found, reference_markers=references, sd_mm=largest_sd(cov)), prediction, cov


def expected_errors(
    answers: list[CandidateFill], gaps: list[Gap], index: int
) -> tuple[dict[str, tuple[float, float]], Floats]:
    """Expected and typical error of one gap by each method, and what each test counts for it.

    By how far two methods are apart too, where there are two, and few enough gaps that all were asked about each.
    """
    moving = motion_of(answers[0], index)
    weights = hold_out_weights([t.test for t in answers[0].results], index, gaps, moving)

    def expected() -> dict[str, tuple[float, float]]:
        return {answer.name: answer.measured.expect(answer.predictions[index], weights, moving) for answer in answers}

    found = expected()
    able = sorted((a for a in answers if np.isfinite(found[a.name][1])), key=lambda a: found[a.name][1])
    if len(able) < 2 or len(gaps) > MANY:
        return found, weights
    apart = np.array([_apart(x.error, y.error) for x, y in zip(able[0].results, able[1].results, strict=True)])
    weights = weights * difficulty_weight(apart, _apart(able[0].predictions[index].xyz, able[1].predictions[index].xyz))
    return expected(), weights


def _motion_ratio(answer: CandidateFill, index: int, weights: Floats) -> float:
    """How many times as much the part moves in a gap as in any test that counts for it; NaN where that is not known."""
    if not len(weights):
        return np.nan
    counting = np.exp(answer.measured.moved[weights > TELLING * weights.max()])
    return float(motion_of(answer, index) / counting.max()) if len(counting) else np.nan


def motion_of(answer: CandidateFill, index: int) -> float:
    """How much the part moves in a gap, √(mm rad); NaN where it is not known."""
    return answer.motion[index] if len(answer.motion) else np.nan


def _apart(one: Floats, other: Floats) -> float:
    """Root mean square distance of two methods' predictions (L, 3), or errors, mm; infinite where one has none."""
    return float(np.sqrt(((one - other) ** 2).sum(1).mean())) if len(one) and len(other) else np.inf


def best_candidate(
    answers: list[CandidateFill],
    errors: dict[str, tuple[float, float]],
    weights: Floats,
    index: int,
    alike: Floats | None = None,
) -> CandidateFill:
    """The least typical error; `FIRST` where it can be used, unless another beats it by more than chance.

    Tests are moved to the gap, and all of the trial count, where `alike` is given: what each counts by length and
    motion alone. That wants the predictions of all methods.
    """
    able = [a for a in answers if np.isfinite(errors[a.name][1])]
    ln_e = {a.name: _ln_errors(a, index, moved=alike is not None) for a in able}
    first = next((a for a in able if a.name == FIRST), None)
    if first is None:
        return min(able, key=lambda a: _mean_known(ln_e[a.name], weights), default=answers[0])

    def behind_first(answer: CandidateFill) -> float:
        return behind(ln_e[answer.name], ln_e[FIRST], answer.measured.same, weights, alike)

    best = min((a for a in able if a is not first), key=behind_first, default=first)
    return best if best is not first and behind_first(best) < 0 else first


def _ln_errors(answer: CandidateFill, index: int, *, moved: bool) -> Floats:
    """(T) ln e of a method's tests, moved to the gap where that is asked for."""
    if moved:
        return answer.measured.moved_to(answer.predictions[index], motion_of(answer, index))
    return answer.measured.logs


def _mean_known(logs: Floats, weights: Floats) -> float:
    """The weighed mean of those that are finite."""
    w = np.where(np.isfinite(logs), weights, 0.0)
    return float(w @ np.where(w > 0, logs, 0.0) / w.sum())


def _mean_of_close(
    answers: list[CandidateFill], errors: dict[str, tuple[float, float]], index: int, counts: Floats
) -> CandidateFill | None:
    """The weighed mean of methods that do nearly as well for one gap; other gaps of it are not worked out."""
    close = close_ones([np.nan_to_num(errors[answer.name][1], nan=np.inf, posinf=np.inf) for answer in answers])
    if not close:
        return None
    chosen = [answers[k] for k in close]
    products = together([answer.results for answer in chosen])
    w = best_weights(products, counts)
    each = np.tile(w, (len(counts), 1))
    for k in np.flatnonzero([result.test.of == index for result in chosen[0].results]):
        each[k] = best_weights(products, np.where(np.arange(len(counts)) == k, 0.0, counts))
    results = mean_tests([answer.results for answer in chosen], each)
    predictions = list(chosen[0].predictions)
    predictions[index] = mean_prediction([answer.predictions[index] for answer in chosen], w)
    name = " + ".join(answer.name for answer, share in zip(chosen, w, strict=True) if share > LITTLE)
    return CandidateFill(name, predictions, MeasuredErrors(results), ErrorCalibration(results), results)
