"""What else names of whole markers could be: chains and rings, and what they lose."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from kinemark.label import learn_template
from kinemark.label.evidence import PairScore
from kinemark.label.margin import margins
from kinemark.label.rivals import lost_to_rivals, rivals
from kinemark.label.stretches import FREE, stretches_of
from kinemark.synth import walking, with_markers


@cache
def walk(seed):
    return with_markers(walking(duration_s=1.0, rate=100.0, seed=seed, wobble_mm=1.0), 39, seed=1).trajectories


@cache
def template():
    return learn_template(walk(1)).of_another(1.0)


def lost(label, names, fixed=()):
    """(39) nats, where tracks that have these names are labelled so."""
    known = template()
    stated = np.full(len(names), FREE)
    stated[list(fixed)] = label[list(fixed)]
    stretches = stretches_of(walk(7).select(names), known.size, stated)
    return lost_to_rivals(stretches, label, known, PairScore.of_template(known))


def on_a_line(n, of):
    """Worth of n markers as labels in a row, by how far they are off."""
    return 12.0 - 4.0 * np.abs(np.arange(n)[:, None] - np.arange(of)[None]).astype(float)


def test_each_marker_is_denied_its_name_and_what_hangs_on_it_moves():
    worth = on_a_line(4, 5)
    found = {tuple(one.tolist()) for one in rivals(np.arange(4), [worth])}
    assert (0, 1, 2, 4) in found  # the last takes the name that is free
    assert all((np.array(one) != np.arange(4)).any() for one in found)
    up = {tuple(one.tolist()) for one in rivals(np.arange(4) + 1, [worth])}
    assert (0, 1, 2, 3) in up  # all have moved up, and back as one
    turned = {tuple(one.tolist()) for one in rivals(np.array([0, 2, 1, 3]), [on_a_line(4, 4)])}
    assert (0, 1, 2, 3) in turned  # a ring of two
    given = np.arange(4)
    rivals(given, [worth])
    np.testing.assert_array_equal(given, np.arange(4))


def test_what_does_not_hang_on_a_marker_stays():
    """Two exchanges that have nothing to do with each other: each rival undoes one of them, or does worse."""
    worth = np.zeros((4, 4))
    worth[:2, :2], worth[2:, 2:] = 5.0, 5.0
    worth[range(4), [1, 0, 3, 2]] = 9.0
    found = {tuple(one.tolist()) for one in rivals(np.arange(4), [worth])}
    assert found == {(1, 0, 2, 3), (0, 1, 3, 2)}


def test_right_names_lose_to_all_rivals_and_exchanged_and_moved_ones_to_none():
    names = template().names
    right = lost(np.arange(39), names)
    assert right.min() > 3 and np.median(right) > 10
    a = 20
    b = int(np.nanargmin(template().distance[a] + np.where(np.arange(39) == a, np.inf, 0.0)))
    turned = np.arange(39)
    turned[[a, b]] = b, a
    wrong = lost(turned, names)
    assert wrong[[a, b]].max() == 0 < np.median(np.delete(wrong, [a, b]))


def test_names_that_moved_up_to_one_that_is_absent_lose_nothing():
    names, d = template().names, template().distance
    chain = [0]
    for _ in range(3):
        chain.append(int(np.argmin(np.where(np.isin(np.arange(39), chain), np.inf, d[chain[-1]]))))
    there = [k for k in range(39) if k != chain[-1]]  # the last of the chain has no marker: each takes the next one's
    label = np.array([dict(pairwise(chain)).get(k, k) for k in there])
    found = lost(label, [names[k] for k in there])
    assert found[chain[1:]].max() == 0 and np.isinf(found[chain[0]])
    assert np.median(np.delete(found, chain)) > 5


def test_stated_names_have_no_rivals_and_who_would_take_them_has_others():
    names = template().names
    found = lost(np.arange(39), names, fixed=(3, 4))
    assert np.isinf(found[[3, 4]]).all() and np.isfinite(np.delete(found, [3, 4])).mean() > 0.9


@pytest.mark.parametrize("known", [learn_template(walk(1)), template()])
def test_right_names_lose_to_their_rivals_by_any_template(known):
    stretches = stretches_of(walk(7).select(known.names), known.size)
    found = margins(stretches, np.arange(39), known, PairScore.of_template(known))
    assert (found.rival > 0).all()
    plain = margins(stretches, np.arange(39), known, PairScore.of_template(known), exchanges=False)
    assert (plain.rival == 0).all()
