"""Problems that are settled one after another leave the trial as it was before its faults."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory
from kinemark.engine.editing.editing import Editing
from kinemark.engine.editing.journal import Journal
from kinemark.engine.problems import problems
from support.walked import clean, exchanged, nearest, spiked, walk, with_xyz

P, AT = 9, 200


def editing_of(trajectories, folder):
    return Editing("walk", Journal.of(folder, "walk"), trajectories, by="EG")


def asked(editing):
    return [one for one in problems(editing).asked if one.wrong > 0.5]


def settled(editing, which=0, most=8):
    """The trial when all was settled as is proposed, and in how many acts."""
    for acts in range(most):
        if not (found := asked(editing)):
            return editing.edited().trajectories, acts
        editing.say(*found[which].alternatives[0].edits)
    raise AssertionError("there was always something to ask")


def is_given_back(now, trial):
    return all(np.array_equal(now[path.name].xyz, path.xyz) for path in trial)


@pytest.mark.parametrize("seed", [3, 5])
def test_three_markers_that_are_exchanged_in_a_ring_are_asked_about_until_all_are_right(seed, tmp_path):
    """Once two of them were exchanged, that one of these was still exchanged with the third was not asked about."""
    trial = clean(seed=seed)
    q = nearest(walk(seed=seed)[1], P, AT)
    r = nearest(np.where(np.arange(24)[:, None, None] == q, np.inf, walk(seed=seed)[1]), P, AT)
    now, acts = settled(editing_of(exchanged(exchanged(trial, P, q, AT), q, r, AT), tmp_path))
    assert acts == 2 and is_given_back(now, trial)


@pytest.mark.parametrize("which", [0, -1])
@pytest.mark.parametrize("frames", [4, 9, 15])
def test_two_markers_that_are_exchanged_for_some_frames_are_one_problem_and_lose_no_sample(frames, which, tmp_path):
    """They were two spikes, whose samples were erased, or an exchange there that hid the one back."""
    trial = clean()
    q = nearest(walk()[1], P, AT)
    editing = editing_of(exchanged(trial, P, q, AT, AT + frames), tmp_path)
    (one,) = asked(editing)
    assert (one.kind, {*one.tracks}) == ("swap", {trial.names[P], trial.names[q]})
    assert (one.first, one.last, one.at_stake) == (AT + 1, AT + frames, 2 * frames)
    assert [way.action for way in one.alternatives] == ["exchange", "erase", "keep"]
    assert sum(way.probability for way in one.alternatives) == pytest.approx(1)
    now, acts = settled(editing, which)
    assert acts == 1 and is_given_back(now, trial)


def test_an_exchange_for_some_frames_that_is_kept_is_not_asked_again(tmp_path):
    editing = editing_of(exchanged(clean(), P, nearest(walk()[1], P, AT), AT, AT + 9), tmp_path)
    editing.say(*next(way for way in asked(editing)[0].alternatives if way.action == "keep").edits)
    assert not asked(editing)


def test_two_markers_that_stand_off_at_once_are_no_exchange(tmp_path):
    trial = spiked(spiked(clean(), P, AT, AT + 3), 2, AT, AT + 3, mm=-40.0)
    assert [one.kind for one in asked(editing_of(trial, tmp_path))] == ["spike", "spike"]


def test_a_piece_that_is_joined_gets_no_spike_back_that_was_taken_away(tmp_path):
    """The claim of the whole piece took its three wrong samples along, and they were not asked about again."""
    trial = clean()
    before, after = (trial.paths[P].xyz.copy() for _ in range(2))
    before[AT:], after[: AT + 6] = np.nan, np.nan
    piece = MarkerTrajectory.measured("*77", after)
    whole = with_xyz(trial, {P: before})
    whole = replace(whole, paths=(*whole.paths, piece))
    editing = editing_of(spiked(whole, len(trial), AT + 30, AT + 33), tmp_path)
    kinds = []
    while found := asked(editing):
        one = min(found, key=lambda one: one.kind != "spike")
        kinds.append(one.kind)
        editing.say(*one.alternatives[0].edits)
    now = editing.edited().trajectories[trial.names[P]].xyz
    assert kinds == ["spike", "join"] and np.isnan(now[AT + 30 : AT + 33]).all()
    there = np.isfinite(now[:, 0])
    assert there.sum() == len(now) - 9 and np.array_equal(now[there], trial.paths[P].xyz[there])
