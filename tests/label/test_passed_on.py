"""Names that a marker of no name passed on, up to one whose marker is absent, and taken back."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import learn_template, passed_on
from kinemark.label.evidence import PairScore
from kinemark.label.passed_on import likely_chains, passed_back
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


CHAINS = [(0, 2), (10, 3), (20, 2), (30, 4)]


@pytest.mark.parametrize(("first", "n"), CHAINS)
def test_names_that_an_extra_marker_passed_on_are_taken_back(first, n):
    tracks, right, moved = crowded(first, n)
    np.testing.assert_array_equal(taken_back(tracks, moved), right)
    np.testing.assert_array_equal(taken_back(tracks, right), right)


def test_what_was_stated_is_not_taken_back():
    tracks, _, moved = crowded(*CHAINS[0])
    np.testing.assert_array_equal(taken_back(tracks, moved, fixed=[3]), moved)


@pytest.mark.parametrize(("gain", "taken"), [(5.0, False), (12.0, True)])
def test_a_chain_that_gains_little_stays(gain, taken, monkeypatch):
    """Of other subjects' templates right names gained as much: by 4.3 and 4.6 nats three trials of four lost some."""
    tracks, _, moved = crowded(*CHAINS[0])
    gains = iter([gain])
    monkeypatch.setattr(passed_on, "undone", lambda _, now, *rest: (np.full_like(now, -1), next(gains, -np.inf)))
    assert (taken_back(tracks, moved) == -1).all() == taken


def test_chains_go_where_most_is_gained_and_end_where_nothing_is():
    gain = np.full((4, 4), -np.inf)
    gain[0, 1], gain[1, 2], gain[2, 3], gain[0, 3] = 1.0, 2.0, -1.0, -9.0
    found = likely_chains(gain)
    assert {(0, 1), (0, 1, 2), (1, 2)} == found
