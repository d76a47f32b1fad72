"""Chains of names that moved up one place are moved back as one; what goes on is."""

from dataclasses import replace
from functools import cache

import numpy as np
from labelling_shredded import shredded

from kinemark.data import MarkerTrajectory
from kinemark.label import learn_template
from kinemark.label.anatomy import Anatomy
from kinemark.label.chains import rechained
from kinemark.label.claims import lost_to_claims
from kinemark.label.evidence import PairScore
from kinemark.label.margin import margins, probability
from kinemark.label.side_pairs import mirrored
from kinemark.label.solve import Solution, _gone_on, _turned
from kinemark.label.stretches import stretches_of
from kinemark.label.sweeps import evidence, total_score
from kinemark.synth import walking, with_markers


@cache
def walk(seed, n=39):
    return with_markers(walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories


def line_of_markers(n, off):
    """Nats of markers on a line that fit label k best at place k, by how many places they are off."""
    worth = 5.0 - off * np.abs(np.arange(n)[:, None] - np.arange(n + 1)[None]).astype(float)

    def nats(now):
        return worth

    def score(now):
        own = np.flatnonzero(now >= 0)
        return float(worth[own, now[own]].sum()) - 10.0 * (n + 1 - len(own))

    return nats, score


def test_names_that_all_moved_up_one_place_move_back_as_one():
    """Five markers have the next one's name each, the last that of an absent label."""
    nats, score = line_of_markers(5, 8.0)
    found = rechained(np.arange(5) + 1, nats, score, score, least=-2.0, absent=10.0)
    np.testing.assert_array_equal(found, np.arange(5))
    two = np.array([0, 1, 3, 2, 4])
    np.testing.assert_array_equal(rechained(two, nats, score, score, least=-2.0, absent=10.0), np.arange(5))


def test_a_chain_is_found_that_seems_to_lose_on_its_way():
    """Where a marker takes a name, the places by which it is judged are still those of wrong names."""
    nats, score = line_of_markers(5, 8.0)

    def misled(now):
        return nats(now) - 40.0 * (np.arange(6) == 0)

    found = rechained(np.arange(5) + 1, misled, score, score, least=-2.0, absent=10.0)
    np.testing.assert_array_equal(found, np.arange(5))


def test_no_chain_begins_where_all_markers_fit_and_none_is_taken_that_scores_less():
    nats, score = line_of_markers(5, 8.0)
    up = np.arange(5) + 1
    np.testing.assert_array_equal(rechained(up, nats, score, score, least=-4.0, absent=10.0), up)
    np.testing.assert_array_equal(rechained(up, nats, score, lambda now: 0.0, least=-2.0, absent=10.0), up)
    given = up.copy()
    rechained(given, nats, score, score, least=-2.0, absent=10.0)
    np.testing.assert_array_equal(given, up)  # what was given is left as it is


def test_a_piece_without_name_goes_on_as_its_marker_and_a_ghost_does_not():
    parts, names = shredded(walk(7), 6, 2.0, 3), walk(7).names
    stretches = stretches_of(parts.tracks, learn_template(walk(1)).size)
    true = np.array([-1 if name is None else names.index(name) for name in parts.truth])
    rng = np.random.default_rng(0)
    lost = np.zeros(len(true), bool)
    for a in range(0, 39, 3):
        lost[rng.choice(np.flatnonzero(true == a))] = True
    found = _gone_on(stretches, np.where(lost, -1, true), 39)
    assert (found[lost] == true[lost]).mean() > 0.8
    assert (found[lost & (found >= 0)] == true[lost & (found >= 0)]).all()
    np.testing.assert_array_equal(found[~lost], true[~lost])  # ghosts have none, others keep theirs


def test_a_piece_whose_name_is_taken_does_not_get_it_twice():
    parts, names = shredded(walk(7), 3, 0.0, 3), walk(7).names
    stretches = stretches_of(parts.tracks, learn_template(walk(1)).size)
    true = np.array([names.index(name) for name in parts.truth])
    piece = np.flatnonzero(true == 5)[0]
    other = next(t for t in np.flatnonzero(true == 9) if (stretches.seen[t] & stretches.seen[piece]).any())
    label = np.where(np.isin(np.arange(len(true)), np.flatnonzero(true == 9)), -1, true)
    label[[piece, other]] = -1, 5
    assert _gone_on(stretches, label, 39)[piece] == -1


def test_the_body_of_another_subject_that_was_named_turned_about_is_turned_back():
    """Left names on the right all over, as a search of a body that the template hardly knows can end."""
    template = learn_template(walk(1)).of_another(1.05)
    pairs = PairScore.of_template(template)
    stretches = stretches_of(walk(7).frames(0, 40), template.size)
    true = np.array([template.names.index(name) for name in walk(7).names])
    wrong = mirrored(template.names)[true]
    given = Solution(wrong, *total_score(stretches, wrong, pairs), pairs)
    turned = _turned(given, mirrored(template.names), stretches, template, pairs, 0.3)
    np.testing.assert_array_equal(turned.label, true)
    right = Solution(true, *total_score(stretches, true, pairs), pairs)
    assert _turned(right, mirrored(template.names), stretches, template, pairs, 0.3) is right


def test_a_name_that_an_extra_marker_beside_could_bear_as_well_is_not_sure_and_a_far_one_changes_nothing():
    """The right one with its name, an extra one a few millimetres beside it, and one a metre away."""
    template, names = learn_template(walk(1)), walk(7).names
    pairs, a = PairScore.of_template(template), names.index("LKNE")
    true = np.array([template.names.index(name) for name in names])
    found = {}
    for mm in (2.0, 1000.0):
        extra = MarkerTrajectory.measured("extra", walk(7).xyz[a] + mm)
        stretches = stretches_of(replace(walk(7), paths=(*walk(7), extra)), template.size)
        label = np.r_[true, -1]
        found[mm] = lost_to_claims(stretches, label, evidence(stretches, label, pairs))
        p = probability(margins(stretches, label, template, pairs), stretches.weight)
        assert (p[a] < 0.99) == (mm == 2.0) and np.median(p[:-1]) > 0.99
    assert np.isinf(found[1000.0]).all() and found[2.0][true[a]] < 10
    assert np.isinf(np.delete(found[2.0], true[a])).mean() > 0.9


def test_feet_and_pelvis_tell_the_front_also_where_some_markers_are_absent():
    trial = walk(7)
    y, anatomy = np.moveaxis(trial.xyz, 1, 0).copy(), Anatomy.of(trial.names)
    whole = anatomy.agreement(y)
    for gone in (("LTOE", "RKNE"), ("RHEE", "X3", "LTIB"), ("LHEE", "X10", "RTHI", "X21")):
        some = y.copy()
        some[:, [trial.names.index(name) for name in gone]] = np.nan
        assert abs(anatomy.agreement(some) - whole) < 0.3
        assert anatomy.gain(some, mirrored(trial.names)) < -10
