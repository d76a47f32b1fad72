"""A labelled trial is checked before a template learns from it: what contradicts the rest is left out, and said."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Trial
from kinemark.data.marker_sides import sides_by_name
from kinemark.engine.naming.check_files import check_by_itself
from kinemark.engine.naming.labelled_trials import agreeing
from kinemark.engine.naming.naming import learnt_frames, learnt_of
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.io.trial import write_trial
from kinemark.report.words import advice_of, text_of
from kinemark.synth import walking, with_markers

TWO, FIRST, STOP = ("LKNE", "LTIB"), 120, 260


@pytest.fixture(scope="module")
def right():
    return with_markers(walking(duration_s=4.0, rate=100.0, seed=1, wobble_mm=2.0), 39, seed=1).trajectories


def exchanged(trial, first, stop):
    two, xyz = list(map(trial.names.index, TWO)), trial.xyz.copy()
    xyz[two, first:stop] = xyz[two[::-1], first:stop]
    paths = tuple(replace(p, xyz=one) for p, one in zip(trial, xyz, strict=True))
    return replace(trial, paths=paths, first_frame=51)


@pytest.fixture(scope="module")
def wrong(right):
    return exchanged(right, FIRST, STOP)


def test_a_trial_whose_names_agree_is_learnt_as_it_is_and_nothing_is_said(right):
    kept = agreeing([right], ["walk.c3d"])
    assert not kept.findings
    assert all((a.xyz == b.xyz).all() for a, b in zip(kept.trials[0], right, strict=True))


def test_exchanged_names_are_left_out_and_said_with_the_frames_of_their_file(wrong):
    (said,) = agreeing([wrong], ["walk.c3d"]).findings
    assert set(said.markers) == set(TWO) and said.values["file"] == "walk.c3d"
    assert abs(said.values["first"] - (FIRST + 51)) <= 2 and abs(said.values["last"] - (STOP + 50)) <= 2
    assert "walk.c3d" in text_of(said) and str(said.values["first"]) in text_of(said) and advice_of(said)
    assert not agreeing([wrong], ["walk.c3d"], [name for name in wrong.names if name not in TWO]).findings


def test_frames_of_a_long_trial_of_which_some_were_kept_are_those_of_its_recording():
    """They were counted among the 300 kept."""
    long = with_markers(walking(duration_s=7.0, rate=100.0, seed=1, wobble_mm=2.0), 15, seed=1).trajectories
    trial = exchanged(long, 300, 500)
    frames = learnt_frames(trial)
    assert len(frames) == 300 and (frames[0], frames[-1]) == (51, 750)
    (said,) = agreeing([learnt_of(trial, True)], ["walk"], frames=[frames]).findings
    assert abs(said.values["first"] - (300 + 51)) <= 6 and abs(said.values["last"] - (500 + 50)) <= 6


@pytest.mark.parametrize("grown", [False, True], ids=["learnt", "grown"])
def test_a_template_is_that_of_right_names_where_a_few_frames_contradict_the_others(right, tmp_path, grown):
    """It was learnt without a word."""
    told, few = [], exchanged(right, 300, 330)
    for name, trial in (("right.c3d", right), ("few.c3d", few)):
        write_trial(Trial(name, trial), tmp_path / name)
    own = subject_template([tmp_path / "right.c3d"], Known(say=told.append)).template
    assert not told
    files = [tmp_path / "right.c3d", tmp_path / "few.c3d"] if grown else [tmp_path / "few.c3d"]
    found = subject_template(files, Known(say=told.append)).template
    assert len(told) == 1 and all(name in told[0] for name in (*TWO, "few.c3d", "of these frames"))
    order = [own.names.index(name) for name in found.names]
    assert sorted(order) == list(range(len(own)))
    off = np.abs(found.distance - own.distance[np.ix_(order, order)])
    assert np.nanmax(off) < 5.0


def test_a_template_learns_neither_of_two_where_nothing_tells_which_part_is_right(wrong, tmp_path):
    """Names by the longer part would be sure, and may be wrong."""
    write_trial(Trial("wrong", wrong), tmp_path / "wrong.c3d")
    told = []
    found = subject_template([tmp_path / "wrong.c3d"], Known(say=told.append)).template
    assert set(wrong.names) - set(found.names) == set(TWO) and len(told) == 1 and "neither" in told[0]


def test_of_several_trials_the_one_that_names_two_otherwise_is_said(right, wrong):
    others = [with_markers(walking(duration_s=4.0, rate=100.0, seed=k, wobble_mm=2.0), 39, seed=1) for k in (2, 3)]
    trials = [right, *(one.trajectories for one in others), exchanged(right, 0, 40)]
    kept = agreeing(trials, ["1", "2", "3", "4"])
    (said,) = kept.findings
    assert said.values["file"] == "4" and said.values["learnt"]


def test_without_a_template_a_trial_is_checked_by_itself(right, wrong):
    """Half of a trial that contradicts the other half was found by neither."""
    pairs = sides_by_name(right.names)
    assert check_by_itself(right, pairs).good
    (found,) = check_by_itself(wrong, pairs).exchanged
    assert set(found.markers) == set(TWO) and abs(found.first - FIRST) <= 2 and abs(found.stop - STOP) <= 2
