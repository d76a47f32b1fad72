"""Luck in the choice of a method: found where many methods are alike, and not where there is no choice."""

import numpy as np
import pytest

from kinemark.fill import Gap
from kinemark.fill.judge.expected_error import MeasuredErrors
from kinemark.fill.judge.hold_out import HoldOutGap, HoldOutResult
from kinemark.fill.judge.luck import luck

TESTS, SPREAD = 12, 0.7


def method(rng, typical=1.0):
    """Results of tests that share no frame, with errors about `typical` mm, e^SPREAD more or less, and none stated."""
    found = []
    for k in range(TESTS):
        error = typical * np.exp(SPREAD * rng.normal()) * np.array([[1.0, 0.0, 0.0]])
        test = HoldOutGap(0, 0, Gap(0, 10 * k, 10 * k + 1), (0, 1), True)
        found.append(HoldOutResult(test, error, np.full((1, 3, 3), np.nan), np.ones(1)))
    return MeasuredErrors(found)


def test_of_many_methods_that_are_alike_the_luckiest_is_known_to_be_lucky():
    """Truth: all have a mean ln error of 0, so that of the next gap exceeds what the luckiest had in the tests."""
    rng, excess, said = np.random.default_rng(0), [], []
    for _ in range(200):
        methods = [method(rng) for _ in range(12)]
        excess.append(-min(each.logs.mean() for each in methods))
        said.append(luck(methods, np.ones(TESTS)))
    assert np.mean(said) == pytest.approx(np.mean(excess), rel=0.3)


def test_a_method_that_is_far_better_was_not_lucky():
    rng = np.random.default_rng(1)
    said = [luck([method(rng), *(method(rng, 50.0) for _ in range(11))], np.ones(TESTS)) for _ in range(100)]
    assert np.mean(said) < 0.1


@pytest.mark.parametrize("weights", [np.zeros(TESTS), np.eye(TESTS)[0]])
def test_too_few_tests_tell_nothing(weights):
    rng = np.random.default_rng(2)
    assert luck([method(rng), method(rng)], weights) == 0 and luck([method(rng)], np.ones(TESTS)) == 0
