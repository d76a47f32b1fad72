"""Names that a marker of no name passed on, up to one whose marker is absent, and taken back."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template
from kinemark.label.evidence import PairScore
from kinemark.label.passed_on import at_most_passed_on, likely_chains, passed_back
from kinemark.label.stretches import FREE, stretches_of
from kinemark.synth import walking, with_markers

BESIDE = 0.3
"""How far the extra marker sits from the first of the chain, as a share of the way away from the second."""


@cache
def walk(seed):
    return with_markers(walking(duration_s=1.0, rate=100.0, seed=seed, wobble_mm=1.0), 39, seed=1).trajectories


@cache
def template():
    return learn_template(walk(1)).of_another(1.0)


def chain_from(first, n):
    """Labels, each nearest to the one before."""
    d, chain = template().distance, [first]
    for _ in range(n):
        chain.append(int(np.argmin(np.where(np.isin(np.arange(39), chain), np.inf, d[chain[-1]]))))
    return chain


@cache
def crowded(first, n):
    """A trial whose chain of labels ends at an absent marker and begins beside an extra one: tracks, right labels and
    those that have all moved up one place."""
    chain, trial = chain_from(first, n), walk(7)
    xyz = dict(zip(trial.names, trial.xyz, strict=True))
    a, b = (xyz[template().names[k]] for k in chain[:2])
    there = [k for k in range(39) if k != chain[-1]]
    paths = [MarkerTrajectory.measured(f"*{k}", xyz[template().names[k]]) for k in there]
    tracks = Trajectories((*paths, MarkerTrajectory.measured("*extra", a + BESIDE * (a - b))), trial.rate)
    moved = [dict(pairwise(chain)).get(k, k) for k in there]
    return tracks, np.array([*there, -1]), np.array([*moved, chain[0]])


def taken_back(tracks, label, fixed=()):
    stated = np.full(len(label), FREE)
    stated[list(fixed)] = label[list(fixed)]
    stretches = stretches_of(tracks, template().size, stated)
    return passed_back(stretches, label, template(), PairScore.of_template(template()))


def most(tracks, label, by):
    """Probabilities that are left of names that were sure."""
    stretches = stretches_of(tracks, by.size)
    return at_most_passed_on(np.where(label >= 0, 1.0, 0.0), stretches, label, by, PairScore.of_template(by))


CHAINS = [(0, 2), (10, 3), (20, 2), (30, 4)]


@pytest.mark.parametrize(("first", "n"), CHAINS)
def test_names_that_an_extra_marker_passed_on_are_taken_back(first, n):
    tracks, right, moved = crowded(first, n)
    np.testing.assert_array_equal(taken_back(tracks, moved), right)
    np.testing.assert_array_equal(taken_back(tracks, right), right)


@pytest.mark.parametrize(("first", "n"), CHAINS)
def test_names_that_may_have_been_passed_on_are_not_sure(first, n):
    tracks, right, moved = crowded(first, n)
    assert most(tracks, moved, template())[right != moved].max() < 0.5
    p = most(tracks, right, template())
    assert np.mean(p[right >= 0] >= 0.99) > 0.9 and p[right < 0] == 0


def test_what_was_stated_is_not_taken_back():
    tracks, _, moved = crowded(*CHAINS[0])
    np.testing.assert_array_equal(taken_back(tracks, moved, fixed=[3]), moved)


def test_names_by_the_subjects_own_template_stay_as_sure_as_they_were():
    tracks, _, moved = crowded(*CHAINS[0])
    assert (most(tracks, moved, learn_template(walk(1))) == 1).all()


@pytest.mark.parametrize(("first", "n"), CHAINS)
def test_no_name_is_sure_and_wrong_beside_an_extra_marker(first, n):
    tracks, right, _ = crowded(first, n)
    found = label(tracks, template())
    wrong = [
        name
        for name, state, a in zip(found.names, found.state, right.tolist(), strict=True)
        if state == "sure" and name != (template().names[a] if a >= 0 else None)
    ]
    assert not wrong and sum(one == "sure" for one in found.state) > 25


def test_chains_go_where_most_is_gained_and_end_where_nothing_is():
    gain = np.full((4, 4), -np.inf)
    gain[0, 1], gain[1, 2], gain[2, 3], gain[0, 3] = 1.0, 2.0, -1.0, -9.0
    found = likely_chains(gain)
    assert {(0, 1), (0, 1, 2), (1, 2), (2, 3)} == found
