"""Laws of choosing and judging that the whole of `fill` hardly shows: weights, few tests, ends, time, limits."""

import numpy as np
import pytest
from test_filling import segment, trial_of

from kinemark.fill import Gap, LimbAngles, Linear, Motion, Prediction, fill
from kinemark.fill.calibration import Calibration
from kinemark.fill.combine import close_ones
from kinemark.fill.hiding import HiddenTest, Tried, plan
from kinemark.fill.methods import affordable


def test_methods_that_do_alike_are_weighed_by_their_precision():
    weights = close_ones([1.0, 1.2, 9.0])
    assert weights == pytest.approx({0: 1.44 / 2.44, 1: 1 / 2.44})
    assert close_ones([1.0, 9.0]) == {}


def test_few_tests_make_wider_bands():
    def band(n):
        rng = np.random.default_rng(0)
        tests = [HiddenTest(0, k, Gap(0, 40 * k + 10, 40 * k + 30), (0, 20), True) for k in range(n)]
        tried = [Tried(t, rng.normal(0, 1, (20, 3)), np.tile(np.eye(3), (20, 1, 1)), np.ones(20)) for t in tests]
        said = Prediction(np.zeros((20, 3)), np.tile(np.eye(3), (20, 1, 1)))
        return Calibration(tried).covariance(said, np.ones(20), np.ones(n))[0, 0, 0] ** 0.5

    assert band(100) == pytest.approx(1.0, abs=0.1)
    assert band(2) > 1.4 and 1.0 < band(10) < 1.5


def test_the_tests_of_an_end_hide_all_to_that_end():
    motion = Motion(segment(200), 100.0, tuple("ABCDE"))
    first, last = Gap(1, 0, 20), Gap(2, 180, 200)
    for gap, end in ((first, "start"), (last, "stop")):
        tests = plan(motion.hidden([gap]), [gap], per_gap=6, seed=0).tests
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
    assert placed.method == "static" and tight.method == "" and "more than the limit" in tight.reason
