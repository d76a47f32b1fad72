"""Laws of choosing and judging that the whole of `fill` hardly shows: weights, few tests, ends, time, limits."""

import sys

import numpy as np
import pytest

from kinemark.fill import Body, Gap, Kalman, LimbAngles, Linear, MarkerArray, Prediction, fill
from kinemark.fill.fill import affordable, evaluate_candidates, within_time
from kinemark.fill.judge.choice import CandidateFill, _mean_of_close, best_candidate, choose_candidate, expected_errors
from kinemark.fill.judge.combine import close_ones, mean_prediction, mean_tests, together, weights
from kinemark.fill.judge.expected_error import LEAST, SLOPE, ErrorCalibration, MeasuredErrors, difficulty_weight
from kinemark.fill.judge.hold_out import HoldOutGap, HoldOutResult, draw_hold_out_gaps
from kinemark.fill.methods.angles import fit_model, learned_of
from kinemark.fill.methods.kriging import Hyper
from kinemark.fill.methods.stage import filler_of
from kinemark.synth import walking, with_markers
from support.filling import segment, trial_of


def filled_with(errors):
    """One test of one gap after another; (T, L, 3) errors of one method."""
    L = errors.shape[1]
    tests = [HoldOutGap(0, k, Gap(0, 2 * L * k + 10, 2 * L * k + 10 + L), (0, L), True) for k in range(len(errors))]
    return [HoldOutResult(t, e, np.tile(np.eye(3), (L, 1, 1)), np.ones(L)) for t, e in zip(tests, errors, strict=True)]


class TestWeighing:
    def test_weights_are_those_of_the_least_error_where_tests_are_many(self):
        """Independent errors: 1/σ². A method whose error is another's and more gets nothing."""
        rng = np.random.default_rng(0)
        a, b, c = rng.normal(0, 1, (3, 400, 20, 3)) * np.array([1.0, 1.5, 1.0]).reshape(3, 1, 1, 1)
        w = weights(together([filled_with(e) for e in (a, b, a + c)]), np.ones(400))
        assert np.allclose(w, [2.25 / 3.25, 1 / 3.25, 0], atol=0.03)

    def test_a_hard_test_counts_no_more_than_an_easy_one(self):
        rng = np.random.default_rng(2)
        a, b = rng.normal(0, 1, (2, 50, 20, 3)) * np.array([1.0, 1.5]).reshape(2, 1, 1, 1)
        a[0], b[0] = 1000 * b[0], 1000 * a[0]
        w = weights(together([filled_with(a), filled_with(b)]), np.ones(50))
        assert w[0] > 0.6

    def test_filled_without_an_answer_are_left_out_and_none_at_all_give_equal_weights(self):
        rng = np.random.default_rng(3)
        a, b = (filled_with(e) for e in rng.normal(0, 1, (2, 6, 20, 3)))
        b[2] = b[2]._replace(error=b[2].error[:0])
        rest = np.array([1.0, 1, 0, 1, 1, 1])
        assert np.allclose(weights(together([a, b]), np.ones(6)), weights(together([a, b]), rest))
        assert np.allclose(weights(together([a, b]), np.zeros(6)), 0.5)
        assert [len(t.error) for t in mean_tests([a, b], np.full((6, 2), 0.5))] == [20, 20, 0, 20, 20, 20]

    def test_those_far_behind_are_not_weighed(self):
        assert close_ones([1.0, 9.0, 1.2]) == close_ones([1.2, 9.0, 1.0]) == [0, 2]
        assert close_ones([1.0, 9.0]) == [] and close_ones([np.inf, np.inf]) == []

    def test_a_mean_says_what_its_parts_say_and_names_the_reference_markers_of_those_that_count(self):
        prediction = [
            Prediction(np.full((2, 3), float(k)), np.tile(k * np.eye(3), (2, 1, 1)), references=(k,)) for k in (1, 2, 4)
        ]
        mean = mean_prediction(prediction, np.array([0.25, 0.75, 0.0]))
        assert np.allclose(mean.xyz, 1.75) and np.allclose(mean.cov, 1.75 * np.eye(3)) and mean.references == (1, 2)
        silent = mean_prediction(
            [s._replace(cov=np.full((2, 3, 3), np.nan)) for s in prediction], np.array([0.5, 0.5, 0.0])
        )
        assert np.isnan(silent.cov).all()


def test_a_mean_is_judged_in_tests_that_its_weights_were_not_made_from():
    """Four fillers of pure chance in six tests: with weights from the same tests 0.85 of the true error is told."""
    rng = np.random.default_rng(4)
    gap, told, true = Gap(0, 0, 20), [], []
    prediction = Prediction(np.zeros((20, 3)), np.tile(np.eye(3), (20, 1, 1)))
    for _ in range(60):
        results = [filled_with(np.tile(e, (1, 20, 1))) for e in rng.normal(0, 1, (4, 6, 1, 3))]
        answers = [
            CandidateFill(name, [prediction], MeasuredErrors(t), ErrorCalibration(t), t)
            for name, t in zip("abcd", results, strict=True)
        ]
        expected, counts = expected_errors(answers, [gap], 0)
        mean = _mean_of_close(answers, expected, 0, counts)
        if len(close_ones([mm for _, mm in expected.values()])) == 4:
            told.append(np.mean([t.mean for t in mean.results]))
            w = weights(together(results), counts)
            true.append(np.linalg.norm(np.tensordot(w, rng.normal(0, 1, (4, 500, 3)), 1), axis=1).mean())
    assert np.mean(told) == pytest.approx(np.mean(true), rel=0.1)


@pytest.mark.parametrize("method", [Body(), LimbAngles()], ids=lambda m: type(m).__name__)
def test_what_is_learnt_once_for_many_gaps_is_learnt_without_what_the_tests_hide(method, monkeypatch):
    subject = with_markers(walking(duration_s=12, rate=50.0, seed=2), 16, seed=2)
    gaps = [Gap(k % 16, 12 * k + 20, 12 * k + 30) for k in range(40)]
    motion = MarkerArray(subject.xyz, 50.0, subject.names).hidden(gaps)
    seen = []

    def spy(one, some, learnt_from):
        seen.append(learnt_from)
        return within_time(one, some, learnt_from)

    monkeypatch.setattr(sys.modules["kinemark.fill.fill"], "within_time", spy)
    (answer,) = evaluate_candidates(motion, gaps, [method])
    (learnt_from,) = seen
    assert len(answer.results) >= 40 and isinstance(answer.method, type(method)) and answer.method != method
    for test in (results.test for results in answer.results):
        assert np.isnan(learnt_from.xyz[test.window.marker, test.window.start : test.window.stop]).all()
    again = filler_of(method)(motion, gaps, method=answer.method)
    assert all(np.array_equal(a.xyz, b.xyz, equal_nan=True) for a, b in zip(again, answer.predictions, strict=True))


def test_a_gap_in_which_the_methods_agree_is_expected_to_be_as_good_as_the_tests_in_which_they_do():
    rng = np.random.default_rng(5)
    hard = np.where(np.arange(20) % 2, 5.0, 0.5)[:, None, None]
    results = [filled_with(hard * rng.normal(0, 1, (20, 20, 3))) for _ in "ab"]
    expected = {}
    for apart in (0.5, 5.0):
        prediction = [Prediction(k * apart * np.full((20, 3), np.sqrt(2)), np.full((20, 3, 3), np.nan)) for k in (0, 1)]
        answers = [
            CandidateFill(n, [x], MeasuredErrors(t), ErrorCalibration(t), t)
            for n, x, t in zip("ab", prediction, results, strict=True)
        ]
        expected[apart] = expected_errors(answers, [Gap(0, 0, 20)], 0)[0]["a"][0]
    usual = np.sqrt(8 / np.pi)  # mean length of a unit normal vector in space
    assert expected[0.5] == pytest.approx(0.5 * usual, rel=0.15) and expected[5.0] == pytest.approx(5 * usual, rel=0.15)


@pytest.mark.parametrize(("harder", "chosen"), [(1.0, "body"), (20.0, "pca")])
def test_a_method_that_finds_the_gap_much_harder_than_its_tests_gives_way(harder, chosen):
    """It did better in all tests, and says itself that the gap is none of them."""
    rng, prediction = np.random.default_rng(9), {}
    size = np.exp(np.linspace(-1, 1, 20))[:, None, None]
    results = {
        name: filled_with(sd * size * rng.normal(0, 1, (20, 20, 3))) for name, sd in (("body", 0.7), ("pca", 1.0))
    }
    answers = []
    for name, tests in results.items():
        told = [t._replace(cov=t.cov * s**2) for t, s in zip(tests, size, strict=True)]
        cov = np.tile(np.eye(3), (20, 1, 1)) * (harder**2 if name == "body" else 1.0)
        prediction[name] = Prediction(np.full((20, 3), 0.1 * len(answers)), cov)
        answers.append(CandidateFill(name, [prediction[name]], MeasuredErrors(told), ErrorCalibration(told), told))
    errors, counts = expected_errors(answers, [Gap(0, 0, 20)], 0)
    assert best_candidate(answers, errors, counts, 0, np.ones(20)).name == chosen


def test_few_tests_make_wider_bands():
    def band(n):
        rng = np.random.default_rng(0)
        tests = [HoldOutGap(0, k, Gap(0, 40 * k + 10, 40 * k + 30), (0, 20), True) for k in range(n)]
        results = [
            HoldOutResult(t, rng.normal(0, 1, (20, 3)), np.tile(np.eye(3), (20, 1, 1)), np.ones(20)) for t in tests
        ]
        prediction = Prediction(np.zeros((20, 3)), np.tile(np.eye(3), (20, 1, 1)))
        return ErrorCalibration(results).covariance(prediction, np.ones(20), np.ones(n))[0, 0, 0] ** 0.5

    assert band(100) == pytest.approx(1.0, abs=0.1)
    assert band(2) > 1.4 and 1.0 < band(10) < 1.5


def test_the_tests_of_an_end_hide_all_to_that_end():
    motion = MarkerArray(segment(200), 100.0, tuple("ABCDE"))
    first, last = Gap(1, 0, 20), Gap(2, 180, 200)
    for gap, end in ((first, "start"), (last, "stop")):
        tests = draw_hold_out_gaps(motion.hidden([gap]), [gap], per_gap=6, seed=0).tests
        assert tests and all(getattr(test.window, end) == getattr(gap, end) for test in tests)
        assert all(test.keep[1] - test.keep[0] == 20 for test in tests)


def test_slow_methods_are_left_out_of_long_trials_with_many_gaps_unless_they_are_all_there_is():
    both = [LimbAngles(), Linear()]
    assert affordable(both, 2, 500) == both and affordable(both, 200, 6000) == [Linear()]
    assert affordable(both[:1], 200, 6000) == both[:1]


def test_the_limit_holds_for_markers_of_the_static_trial_too():
    truth = segment(60)
    xyz = truth.copy()
    xyz[4] = np.nan
    before, static = trial_of(xyz).trajectories, trial_of(truth[:, :10]).trajectories
    (placed,) = fill(before, static=static).gaps
    (tight,) = fill(before, static=static, limit_mm=placed.expected_mm / 2).gaps
    assert placed.method == "static" and tight.method == "" and tight.state == "above_limit"


def answer(name, errors, *, at=0.0, claim=1.0):
    results, L = filled_with(errors), errors.shape[1]
    prediction = Prediction(np.full((L, 3), at), np.tile(claim * np.eye(3), (L, 1, 1)))
    return CandidateFill(name, [prediction], MeasuredErrors(results), ErrorCalibration(results), results)


def along(axis, sizes):
    """(T, 20, 3) errors of these sizes along one axis."""
    return np.array(sizes, float)[:, None, None] * np.tile(np.eye(3)[axis], (20, 1))


MOTION, GAP = MarkerArray(np.zeros((1, 600, 3)), 100.0, ("A",)), Gap(0, 0, 20)


def test_what_a_test_counts_is_what_it_counts_for_the_weights():
    products = together([filled_with(along(0, [1, 3])), filled_with(along(1, [3, 1]))])
    assert np.allclose(weights(products, np.array([9.0, 1.0])), [0.833, 0.167], atol=0.1)
    assert weights(products, np.array([1.0, 9.0]))[1] > 0.7


def test_however_easy_or_hard_a_test_it_counts_a_little():
    assert np.allclose(difficulty_weight(np.array([0.0, 1.0, 1e9]), 1.0), [LEAST, 1, LEAST])


def test_how_hard_a_gap_is_the_best_two_tell():
    rng = np.random.default_rng(5)
    hard = np.where(np.arange(20) % 2, 5.0, 0.5)[:, None, None]
    a, b, c = (
        answer(name, hard * rng.normal(0, k, (20, 20, 3)), at=k * x)
        for name, k, x in (("a", 1, 0), ("b", 1, 0.5), ("c", 90, 1))
    )
    assert np.array_equal(expected_errors([c, a, b], [GAP], 0)[1], expected_errors([a, b], [GAP], 0)[1])


MIXED = [1] * 9 + [2.5] * 3, [1] * 6 + [2.5] * 3 + [1] * 3


def test_a_mean_is_taken_if_better_by_half_a_standard_error_and_claims_what_it_says():
    """It is better by 2.5 standard errors where errors are across, worse where they are along the same line."""
    across = [answer("a", along(0, MIXED[0])), answer("b", along(1, MIXED[1]), claim=16.0)]
    found = choose_candidate(MOTION, [GAP], 0, across)[0]
    same = choose_candidate(MOTION, [GAP], 0, [across[0], across[1]._replace(predictions=across[0].predictions)])[0]
    assert found.method == "a + b" == same.method and list(found.candidates) == ["a", "b", "a + b"]
    assert found.expected_mm == pytest.approx(8.5 ** (SLOPE / 2) * same.expected_mm)  # half of 1 and 16
    line = [answer("a", along(0, [1, 2] * 4)), answer("b", along(0, [2, 1] * 4))]
    assert choose_candidate(MOTION, [GAP], 0, line)[0].method == "a"


@pytest.mark.parametrize(("ahead", "aside", "name"), [(0.95, 1.29, "a"), (0.9, 0.995, "a + b")])
def test_a_mean_is_named_after_those_that_count_and_one_alone_is_no_mean(ahead, aside, name):
    """The other has 0.03 and 0.1 of the weight."""
    both = [answer("a", along(0, [1] * 8)), answer("b", along(0, [ahead] * 8) + along(1, [aside] * 8))]
    found, prediction, _ = choose_candidate(MOTION, [GAP], 0, both)
    assert found.method == name and (prediction is both[0].predictions[0]) == (name == "a")
    assert found.candidates["a"] == pytest.approx(1.0, abs=1e-9)


def walker():
    subject = with_markers(walking(duration_s=6, rate=50.0, seed=2), 16, seed=2)
    return MarkerArray(subject.xyz, 50.0, subject.names)


def test_the_faster_form_keeps_what_is_given():
    motion, gaps, mine = walker(), [Gap(2, 100, 120)] * 30, Hyper(lam=7.0)
    quick = within_time(Body(most_markers=5, training_frames=20, hyper=mine), gaps, motion)
    assert quick.hyper == mine and quick.most_markers == 5 and quick.training_frames == 20
    for given in (
        LimbAngles(model=fit_model(motion).model),
        LimbAngles(learned=learned_of(motion, method=LimbAngles())),
    ):
        assert within_time(given, gaps, motion) is given
    assert [within_time(Kalman(margin=h), gaps, motion).margin for h in (0.1, 2.0)] == [0.1, 0.25]


def test_where_the_tests_together_hide_most_of_the_trial_each_copy_is_learnt_from():
    subject = with_markers(walking(duration_s=8, rate=50.0, seed=2), 16, seed=2)
    gaps = [Gap(k % 16, 10 + 14 * k, 35 + 14 * k) for k in range(24)]
    motion = MarkerArray(subject.xyz, 50.0, subject.names).hidden(gaps)
    body, limbs = evaluate_candidates(motion, gaps, [Body(most_markers=6, training_frames=40), LimbAngles()])
    assert body.method.hyper is None and limbs.method.learned is None
    assert np.isfinite([t.mean for t in body.results]).mean() > 0.8
