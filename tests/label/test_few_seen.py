"""Few markers seen at a time, as from few cameras; pieces in a new posture; and extra markers beside absent ones."""

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label
from kinemark.label.evidence import PairScore
from kinemark.label.held import held
from kinemark.label.margin import margins
from kinemark.label.stretches import stretches_of
from kinemark.label.sweeps import expectation, sweep
from support.subject_walks import template, walk


def tracks(parts):
    """Of (F, 3) mm each, without names."""
    return Trajectories(tuple(MarkerTrajectory.measured(f"*{k}", xyz) for k, xyz in enumerate(parts, 1)), 100.0)


def only(xyz, first, stop):
    out = np.full_like(xyz, np.nan)
    out[first:stop] = xyz[first:stop]
    return out


@pytest.mark.parametrize("seed", [5, 8])
def test_both_sides_of_a_second_in_which_nothing_is_seen_are_named(seed):
    trial = walk(seed)
    parts = [only(path.xyz, *ends) for ends in ((0, 90), (190, 300)) for path in trial]
    found = label(tracks(parts), template())
    assert found.refused is None and found.names == (*trial.names, *trial.names)


def test_what_is_hidden_for_a_while_tells_nothing_of_a_template_and_what_is_absent_does():
    trial, pairs = walk(6), PairScore.of_template(template())
    rng = np.random.default_rng(1)
    true = np.array([template().names.index(name) for name in trial.names])
    firsts = rng.integers(0, 180, len(trial))
    stretches = stretches_of(tracks([only(p.xyz, a, a + 120) for p, a in zip(trial, firsts, strict=True)]), 1000.0)
    assert held(stretches, true, pairs) > 0.9
    assert held(stretches, np.where(np.arange(15) % 2 == 0, true, -1), pairs) < 0.65


def test_of_a_track_is_expected_what_is_seen_with_it():
    trial, pairs = walk(6), PairScore.of_template(template())
    true = np.array([template().names.index(name) for name in trial.names])
    whole = [path.xyz for path in trial]
    alone = [only(xyz, 0, 100) if k else xyz for k, xyz in enumerate(whole)]
    by_all = expectation(stretches_of(tracks(whole), 1000.0), true, pairs)
    np.testing.assert_allclose(by_all[0], pairs.expected.sum(1))
    third = expectation(stretches_of(tracks(alone), 1000.0), true, pairs)
    np.testing.assert_allclose(third[1], by_all[1])
    assert 0.25 < third[0, true[0]] / by_all[0, true[0]] < 0.4


def test_a_piece_that_goes_on_as_its_marker_keeps_the_name_where_its_distances_are_off():
    trial, pairs = walk(6), PairScore.of_template(template())
    true = np.array([template().names.index(name) for name in trial.names])
    own = trial.names.index("LTOE")
    xyz = trial["LTOE"].xyz.copy()
    xyz[100:140, 2] += 150 * np.sin(np.pi * np.arange(40) / 39) ** 2
    parts = [path.xyz for path in trial]
    parts[own] = only(xyz, 0, 112)
    given = tracks([*parts, only(xyz, 112, 128), only(xyz, 128, 300)])
    labels = np.append(true, [true[own], true[own]])
    assert sweep(stretches_of(given, template().size), labels, pairs, 0.3).tolist() == labels.tolist()


def test_a_marker_without_name_beside_one_that_has_its_name_leaves_that_no_margin():
    trial, pairs = walk(6), PairScore.of_template(template())
    true = np.array([template().names.index(name) for name in trial.names])
    own = trial.names.index("LTIB")
    beside = trial["LTIB"].xyz + 0.2 * (trial["LKNE"].xyz - trial["LTIB"].xyz)
    stretches = stretches_of(tracks([*(path.xyz for path in trial), beside]), template().size)
    taken = np.append(np.where(np.arange(15) == own, -1, true), true[own])
    found = margins(stretches, taken, template(), pairs)
    right = margins(stretches, np.append(true, -1), template(), pairs)
    assert found.track[15] < 0 < right.track[own]


@pytest.mark.parametrize("absent", ["RTIB", "RHEE"])
def test_an_extra_marker_beside_an_absent_one_does_not_take_its_name_surely(absent):
    trial = walk(6, 39)
    rest = [path for path in trial if path.name != absent]
    own = trial[absent].xyz
    near = sorted(rest, key=lambda path: np.linalg.norm(path.xyz - own, axis=1).mean())[:2]
    beside = own + 0.35 * (near[0].xyz - own) + 0.3 * (near[1].xyz - own)
    found = label(tracks([*(path.xyz for path in rest), beside]), template(39))
    assert found.names[:-1] == tuple(path.name for path in rest)
    assert found.state[-1] != "sure" and np.mean([state == "sure" for state in found.state[:-1]]) > 0.9
