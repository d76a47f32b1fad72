"""Hold-out gaps: they are in the gap's state, and what is drawn from them about errors is true."""

from itertools import pairwise

import numpy as np
import pytest

from kinemark.fill import Body, Gap, Linear, MarkerArray, Prediction
from kinemark.fill.judge.expected_error import SLOPE, ErrorCalibration, MeasuredErrors, behind, hold_out_weights
from kinemark.fill.judge.hold_out import HoldOutGap, HoldOutResult, draw_hold_out_gaps, run
from kinemark.fill.methods.stage import filler_of
from support.filling import moving


class TestHiding:
    def test_the_same_others_are_missing_in_a_test(self):
        motion = moving(600)
        gaps = [Gap(0, 100, 150), Gap(1, 120, 140), Gap(4, 300, 320)]
        hidden = motion.hidden(gaps)
        hold_out = draw_hold_out_gaps(hidden, gaps, per_gap=3, seed=1)
        for test in hold_out.tests:
            if test.of == 0 and test.own:
                copy = hidden.hidden(hold_out.copies[test.copy])
                start = test.window.start
                assert np.isnan(copy.xyz[1, start + 20 : start + 40]).all()
                assert not np.isnan(copy.xyz[2, start : start + 50]).any()

    def test_what_is_missing_beside_a_gap_is_missing_beside_its_tests(self):
        """A neighbour lost a frame earlier and longer, and the marker itself seen in two frames between two gaps."""
        gaps = [Gap(0, 100, 102), Gap(0, 104, 108), Gap(1, 99, 103), Gap(2, 94, 96)]
        hidden = moving(600).hidden(gaps)
        hold_out = draw_hold_out_gaps(hidden, gaps, per_gap=3, seed=1)
        tests = [test for test in hold_out.tests if test.of == 0 and test.own]
        assert tests
        for test in tests:
            copy, start = hidden.hidden(hold_out.copies[test.copy]), test.window.start
            missing = np.isnan(copy.xyz[:3, start - 3 : start + 5, 0])
            assert missing.tolist() == [[k in (3, 4, 7) for k in range(8)], [2 <= k < 6 for k in range(8)], [False] * 8]

    @pytest.mark.parametrize(("frames", "also"), [(36, False), (400, True)])
    def test_short_trials_have_no_room_for_what_is_missing_beside_a_gap(self, frames, also):
        gap, beside = Gap(0, 20, 22), Gap(1, 23, 24)
        hidden = moving(frames).hidden([gap, beside])
        hold_out = draw_hold_out_gaps(hidden, [gap], per_gap=3, seed=1)
        own = [test for test in hold_out.tests if test.own]
        others = [each for test in own for each in hold_out.copies[test.copy] if each.marker == 1]
        assert own and bool(others) == also

    def test_windows_are_known_and_do_not_overlap_in_a_copy(self):
        motion = moving(900, soft=3.0)
        gaps = [Gap(k, 100 * k + 20, 100 * k + 50) for k in range(8)]
        hidden = motion.hidden(gaps)
        hold_out = draw_hold_out_gaps(hidden, gaps, per_gap=4, seed=2)
        assert {t.of for t in hold_out.tests} == set(range(8))
        for number in range(len(hold_out.copies)):
            windows = sorted(t.window[1:] for t in hold_out.tests if t.copy == number)
            assert all(a[1] <= b[0] for a, b in pairwise(windows))
        for test in hold_out.tests:
            assert not np.isnan(hidden.xyz[test.window.marker, test.window.start : test.window.stop]).any()

    def test_tests_of_many_gaps_share_few_copies_and_still_do_not_overlap(self):
        motion = moving(2000)
        gaps = [Gap(k % 8, 45 * k + 20, 45 * k + 40) for k in range(40)]
        hidden = motion.hidden(gaps)
        hold_out = draw_hold_out_gaps(hidden, gaps, per_gap=1, seed=3)
        assert sorted(t.of for t in hold_out.tests) == list(range(40)) and len(hold_out.copies) <= 3
        for number in range(len(hold_out.copies)):
            windows = sorted(t.window[1:] for t in hold_out.tests if t.copy == number)
            assert all(a[1] <= b[0] for a, b in pairwise(windows))
        for test in hold_out.tests:
            assert not np.isnan(hidden.xyz[test.window.marker, test.window.start - 1 : test.window.stop + 1]).any()

    def test_a_gap_longer_than_what_is_left_is_tested_on_other_markers(self):
        motion, gap = moving(200), Gap(0, 50, 180)
        hold_out = draw_hold_out_gaps(motion.hidden([gap]), [gap], per_gap=3, seed=0)
        assert hold_out.tests and all(not t.own and t.window.length == gap.length for t in hold_out.tests)

    def test_on_another_marker_its_own_neighbours_are_hidden_too(self):
        xyz = np.tile(np.cumsum(np.full((10, 1, 1), 100.0), 0) * [1.0, 0, 0], (1, 200, 1))  # ten in a row
        motion = MarkerArray(xyz, 100.0, tuple(f"M{k}" for k in range(10)))
        gaps = [Gap(k, 50, 180) for k in (0, 1, 2)]
        hidden = motion.hidden(gaps)
        hold_out = draw_hold_out_gaps(hidden, gaps, per_gap=4, seed=0)
        tests = [test for test in hold_out.tests if test.of == 0 and test.window.marker > 5]
        assert tests
        for test in tests:
            copy = hidden.hidden(hold_out.copies[test.copy])
            near = np.argsort(np.abs(np.arange(10) - test.window.marker), kind="stable")[1:3]
            assert np.isnan(copy.xyz[near, 50:180]).all() and np.isnan(copy.xyz[:3, 50:180]).all()
            assert np.isfinite(copy.xyz[[k for k in (3, 4) if k not in near]]).all()

    def test_gaps_at_an_end_are_tested_by_hiding_all_to_that_end(self):
        motion, gap = moving(300), Gap(0, 260, 300)
        hold_out = draw_hold_out_gaps(motion.hidden([gap]), [gap], per_gap=3, seed=0)
        assert all(t.window.stop == 300 and t.keep[1] - t.keep[0] == 40 for t in hold_out.tests)
        results = run(motion.hidden([gap]), hold_out, filler_of(Body()), Body())
        assert all(t.error.shape == (40, 3) for t in results)

    def test_errors_are_those_of_the_filler(self):
        motion, gap = moving(300), Gap(0, 100, 110)
        hidden = motion.hidden([gap])
        hold_out = draw_hold_out_gaps(hidden, [gap], per_gap=2, seed=0)
        for results in run(hidden, hold_out, filler_of(Linear()), Linear()):
            window = results.test.window
            ends = motion.xyz[0, [window.start - 1, window.stop]]
            chord = ends[0] + (ends[1] - ends[0]) * np.arange(1, 11)[:, None] / 11
            assert np.allclose(results.error, chord - motion.xyz[0, window.start : window.stop])


def tries(n, sd, rng, *, prediction=1.0, length=20, spread=0.0, step=None):
    """n tests of one gap with errors of this sd times e^(spread N(0, 1)), and a method that claims `prediction`; a test
    every `step` frames, `length` when None."""
    step = length if step is None else step
    tests = [HoldOutGap(0, 0, Gap(0, k * step, k * step + length), (0, length), True) for k in range(n)]
    cov = np.tile(prediction**2 * np.eye(3), (length, 1, 1))
    sizes = sd * np.exp(spread * rng.normal(size=n))
    return [
        HoldOutResult(t, rng.normal(0, s, (length, 3)), cov, np.ones(length)) for t, s in zip(tests, sizes, strict=True)
    ]


class TestCalibration:
    @pytest.mark.parametrize("prediction", [0.2, 1.0, 30.0, np.nan])
    @pytest.mark.parametrize("n", [3, 12, 40])
    def test_intervals_hold_whatever_the_method_claims(self, prediction, n):
        rng, inside = np.random.default_rng(1), []
        for _ in range(100):
            results = tries(n, 2.0, rng, prediction=prediction, spread=0.5)
            (new,) = tries(1, 2.0, rng, prediction=prediction, spread=0.5)
            cov = ErrorCalibration(results).covariance(new, new.edge, np.ones(n))
            inside.append((np.abs(new.error) < 1.96 * np.sqrt(np.diagonal(cov, axis1=1, axis2=2))).mean())
        assert 0.92 < np.mean(inside) < 0.98

    def test_tests_that_overlap_are_fewer_than_they_look(self):
        rng = np.random.default_rng(5)
        apart, over = (tries(12, 2.0, rng, length=100, step=step) for step in (100, 10))
        over = [t._replace(error=a.error) for t, a in zip(over, apart, strict=True)]
        far, near = (
            ErrorCalibration(t).covariance(apart[0], apart[0].edge, np.ones(12))[0, 0, 0] for t in (apart, over)
        )
        assert near > 1.2 * far

    def test_luck_in_few_tests_is_no_reason_to_leave_a_method(self):
        rng, left = np.random.default_rng(6), []
        for sd in [2.0] * 100 + [1.4] * 100:
            old, new = MeasuredErrors(tries(6, 2.0, rng)), MeasuredErrors(tries(6, sd, rng))
            left.append(behind(new.logs, old.logs, new.same, np.ones(6)) < 0)
        assert np.mean(left[:100]) < 0.3 and np.mean(left[100:]) > 0.9  # half would go by the mean alone
        one = MeasuredErrors(tries(1, 2.0, rng))
        assert np.isinf(behind(one.logs, one.logs + 1, one.same, np.ones(1)))

    def test_what_all_tests_of_the_trial_say_stands_against_luck_in_the_few_of_a_gap(self):
        """The choice falls half as often on a method that is 5 % worse, and as often on one that is better."""
        rng, left = np.random.default_rng(18), []
        for sd in [2.1] * 150 + [1.4] * 50:
            old, new = MeasuredErrors(tries(60, 2.0, rng)), MeasuredErrors(tries(60, sd, rng))
            own = np.where(np.arange(60) < 6, 1.0, 0.0)
            left.append([behind(new.logs, old.logs, new.same, own, all_of) < 0 for all_of in (None, np.ones(60))])
        by_chance, better = np.mean(left[:150], axis=0), np.mean(left[150:], axis=0)
        assert 0 < by_chance[0] > 1.5 * by_chance[1] and better[1] > 0.95

    def test_a_silent_method_gets_errors_that_grow_from_the_edges(self):
        rng = np.random.default_rng(2)
        edge = np.minimum(np.arange(1, 41), np.arange(40, 0, -1)).astype(float)
        test = HoldOutGap(0, 0, Gap(0, 0, 40), (0, 40), True)
        nothing = np.full((40, 3, 3), np.nan)
        results = [HoldOutResult(test, rng.normal(0, edge[:, None], (40, 3)), nothing, edge) for _ in range(20)]
        cov = ErrorCalibration(results).covariance(results[0], edge, np.ones(20))
        sd = np.sqrt(cov[:, 0, 0])
        assert (np.diff(sd[:20]) >= 0).all() and sd[19] > 4 * sd[0]

    def test_tests_of_the_gap_itself_count_most(self):
        gaps = [Gap(0, 0, 20), Gap(0, 50, 70), Gap(3, 0, 20), Gap(3, 0, 200)]
        tests = [HoldOutGap(k, 0, Gap(g.marker, 0, g.length), (0, g.length), True) for k, g in enumerate(gaps)]
        w = hold_out_weights(tests, 0, gaps)
        assert w[0] > w[1] > w[2] > w[3] > 0

    def test_expected_error_is_the_mean_of_the_tests_for_a_method_that_claims_nothing(self):
        rng, n = np.random.default_rng(3), 200
        results = tries(n, 2.0, rng, prediction=np.nan)
        mean, typical = MeasuredErrors(results).expect(Prediction(np.zeros((20, 3)), results[0].cov), np.ones(n))
        assert np.isclose(mean, 2.0 * np.sqrt(8 / np.pi), rtol=0.02) and typical < mean  # of a normal error in space

    def test_a_gap_that_the_method_finds_harder_is_expected_to_be_worse(self):
        rng = np.random.default_rng(4)
        results = tries(10, 2.0, rng, prediction=1.0)
        same, worse = (
            MeasuredErrors(results).expect(Prediction(np.zeros((20, 3)), k * results[0].cov), np.ones(10))[0]
            for k in (1, 16)
        )
        assert np.isclose(worse, 4**SLOPE * same)  # all claim alike: nothing is learnt of how much a claim says

    def test_no_tests_no_error_and_no_answers_an_infinite_one(self):
        prediction = Prediction(np.zeros((4, 3)), np.full((4, 3, 3), np.nan))
        assert np.isnan(MeasuredErrors([]).expect(prediction, np.zeros(0))).all()
        results = [t._replace(error=t.error[:0]) for t in tries(3, 1.0, np.random.default_rng(0))]
        assert np.isinf(MeasuredErrors(results).expect(prediction, np.ones(3))).all()
