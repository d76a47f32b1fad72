"""Assignments of the least sum of costs."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from kinemark import native


@pytest.mark.parametrize("seed", range(300))
@pytest.mark.parametrize("maximize", [False, True])
def test_assignments_are_those_of_scipy_also_where_costs_are_equal(seed: int, maximize: bool) -> None:
    rng = np.random.default_rng(seed)
    n, m = rng.integers(0, 12, 2)
    cost = rng.integers(0, 4, (n, m)).astype(float) if seed % 2 else rng.normal(size=(n, m))
    found, wanted = native.assign(cost, maximize=maximize), scipy.optimize.linear_sum_assignment(cost, maximize)
    assert [part.tolist() for part in found] == [part.tolist() for part in wanted]


def test_pairs_of_each_group_have_the_greatest_sum() -> None:
    a, b = np.array([7, 7, 8, 3, 3]), np.array([1, 2, 1, 5, 6])
    score = np.array([5.0, 4.0, 4.0, 1.0, 2.0])  # 7 with 1 is the best pair, and 7 with 2 and 8 with 1 are better
    chosen = native.assign_pairs(np.array([0, 3, 5]), a, b, score)
    assert chosen.tolist() == [False, True, True, False, True]


def test_a_group_of_many_finds_room() -> None:
    score = np.random.default_rng(1).random(400) + 1.0
    a, b = np.divmod(np.arange(400), 20)
    chosen = native.assign_pairs(np.array([0, 400]), a, b, score)
    best = scipy.optimize.linear_sum_assignment(score.reshape(20, 20), maximize=True)
    assert np.flatnonzero(chosen).tolist() == (best[0] * 20 + best[1]).tolist()


@pytest.mark.parametrize("cost", [np.nan, np.inf])
def test_costs_that_are_no_numbers_are_refused(cost: float) -> None:
    with pytest.raises(ValueError, match="not finite"):
        native.assign(np.array([[cost, 1.0]]))


def test_groups_that_do_not_follow_each_other_are_refused() -> None:
    one = np.array([0, 1])
    for start in ([0, 3], [1, 2], [0, 2, 1, 2], []):
        with pytest.raises(ValueError, match="rising"):
            native.assign_pairs(np.array(start, np.int64), one, one, np.ones(2))
    with pytest.raises(ValueError, match="positive"):
        native.assign_pairs(np.array([0, 2]), one, one, np.zeros(2))
