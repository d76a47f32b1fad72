"""Stitches that are considered: those of one table of all tracks, which only short recordings have room for."""

import numpy as np
import scipy

from kinemark.track.simultaneous import Simultaneous
from kinemark.track.simultaneous.following.kalman_states import initial_states
from kinemark.track.simultaneous.joining.stitch import NEVER, Ends, best_stitches, possible


def some_ends(n=80, seed=0):
    """Ends of tracks of 5 to 20 frames in 300, one in ten without a point."""
    rng = np.random.default_rng(seed)
    first = rng.integers(0, 300, n)
    last, never = first + rng.integers(5, 20, n), rng.random(n) < 0.1
    xyz = rng.normal(scale=300, size=(2, 3, n))
    motion = [initial_states(x, np.tile(np.eye(3)[..., None], n), speed=1.0, acceleration=1.0) for x in xyz]
    return Ends(np.where(never, NEVER, first), np.where(never, -NEVER, last), *motion)


def test_pairs_that_may_be_stitched_are_those_of_the_table():
    ends, T, method = some_ends(), 0.01, Simultaneous(max_gap=0.3)
    gap = ends.first - ends.last[:, None]
    apart = np.linalg.norm(ends.begin.position[:, None] - ends.end.position[:, :, None], axis=0)
    near = apart < 3 * method.velocity_sd * T * gap + method.uncertain_sd
    expected = np.nonzero((gap > 0) & (gap * T <= method.max_gap) & near)
    np.testing.assert_array_equal(possible(ends, T, method), expected)
    assert 20 < len(expected[0]) < 600


def test_the_best_stitches_of_each_group_of_tracks_are_those_of_all():
    ends, rng = some_ends(), np.random.default_rng(1)
    a, b = possible(ends, 0.01, Simultaneous(max_gap=0.1))
    score = rng.normal(10, 10, len(a))
    table = np.zeros((80, 80))
    table[a, b] = np.maximum(score, 0.0)
    pairs = np.array(scipy.optimize.linear_sum_assignment(table, maximize=True))
    pairs = pairs[:, table[*pairs] > 0]
    found = best_stitches(ends, a, b, score, np.ones(len(a)))
    np.testing.assert_array_equal([(one.before, one.after) for one in found], pairs.T)
    for one in found:
        rivals = np.concatenate([np.delete(table[one.before], one.after), np.delete(table[:, one.after], one.before)])
        assert one.score == table[one.before, one.after] and one.margin == one.score - rivals.max()
    assert len(found) > 10


def test_without_pairs_nothing_is_stitched():
    none = np.zeros(0, np.int64)
    assert best_stitches(some_ends(), none, none, np.zeros(0), np.zeros(0)) == []
