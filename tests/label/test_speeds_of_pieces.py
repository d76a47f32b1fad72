"""Pieces of one sample have no speed of their own: they go on from what moves, and are not at rest."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label.beside_gaps import Parts
from kinemark.label.stretches import speed_between, stretches_of
from kinemark.label.sweeps import GOES_ON

RATE, SIZE = 100.0, 1600.0
AT = 20


def swinging(gap=0):
    """A heel that swings at 4 m/s, as it goes on, one sample of it, and the rest; a gap of some frames about it."""
    t = np.arange(2 * AT + 1) / RATE
    heel = np.stack([4000.0 * t, 0 * t, 80.0 + 200.0 * np.sin(3 * t)], axis=1)
    pieces = []
    for own in (t < t[AT - gap], np.arange(len(t)) == AT, t > t[AT + gap]):
        pieces.append(np.where(own[:, None], heel, np.nan))
    return np.stack(pieces)


@pytest.mark.parametrize("gap", [0, 1])
@pytest.mark.parametrize("shift", [0.0, 5e6])
def test_one_sample_of_a_marker_that_moves_goes_on_from_it_and_into_it(gap, shift):
    paths = (MarkerTrajectory.measured(f"*{k}", xyz + shift) for k, xyz in enumerate(swinging(gap)))
    link = stretches_of(Trajectories(tuple(paths), RATE), SIZE).link.toarray()
    assert link[0, 1] > GOES_ON and link[1, 2] > GOES_ON


def test_the_same_beside_gaps():
    parts = Parts.of(swinging(2), RATE, SIZE)
    before, one, after = range(3)
    assert parts.motion(before, one) > GOES_ON and parts.motion(one, after) > GOES_ON


def test_a_speed_that_is_not_known_is_that_of_the_other_end():
    one, none = np.array([[1.0, 2.0, 3.0]]), np.full((1, 3), np.nan)
    assert speed_between(one, none).tolist() == speed_between(none, one).tolist() == one.tolist()
    assert speed_between(one, 3 * one).tolist() == (2 * one).tolist()
    assert not speed_between(none, none).any()
