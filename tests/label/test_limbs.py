"""Limbs whose names are exchanged as wholes are found, and put back where that scores more."""

from functools import cache

import numpy as np
import pytest

import kinemark.label.solve as search
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import learn_template
from kinemark.label.claims import left_over
from kinemark.label.evidence import PairScore
from kinemark.label.limbs import near_turns, score_with_sides
from kinemark.label.side_pairs import mirrored
from kinemark.label.solve import Solution, Start, limbs_turned, solve
from kinemark.label.stretches import FREE, stretches_of
from kinemark.label.sweeps import places, total_score
from support.wearing import body_of, moving

LEG = ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")
ARM = ("UPA", "ELB", "FRM", "WRA", "WRB", "FIN")


@cache
def walk(seed):
    worn = read_marker_set("plug-in-gait-full")
    return moving(worn, body_of(worn, 4), seed, duration_s=0.6)


@cache
def known():
    return learn_template(walk(3)).of_another(1.02)


def named(limb):
    """Stretches and labels of another walk: true ones, and with the names of these limbs on the other side."""
    template, trial = known(), walk(13)
    truth = np.array([template.names.index(name) for name in trial.names])
    ends = [name for name in template.names if name.startswith(("L", "R")) and name[1:].startswith(limb)]
    assert len(ends) == 2 * len(limb)
    other, turn = mirrored(template.names), np.arange(len(template))
    at = [template.names.index(name) for name in ends]
    turn[at] = other[at]
    return stretches_of(trial, template.size), truth, turn[truth]


@pytest.mark.parametrize("limb", [LEG, ARM])
def test_limbs_with_each_others_names_are_put_back_and_right_ones_stay(limb):
    template, pairs = known(), PairScore.of_template(known())
    stretches, truth, exchanged = named(limb)
    for label in (truth, exchanged):
        found = Solution(label, *total_score(stretches, label, pairs))
        assert (limbs_turned(found, stretches, template, pairs, 0.3).label == truth).all()


def test_a_body_that_has_all_names_of_the_other_side_is_put_right_as_a_whole_before_it_is_learnt_from():
    """By one posture, whose distances tell little: before, none of the names was right."""
    template, trial = learn_template(walk(3).frames(0, 1), relative_spread=0.18), walk(13)
    pairs, stretches = PairScore.of_template(template), stretches_of(trial, template.size)
    truth = np.array([template.names.index(name) for name in trial.names])
    for label in (truth, mirrored(template.names)[truth]):
        found = search._whole(label, stretches, template, pairs, 10, 500, 0.3, {}).label
        assert (found == truth).mean() > 0.9 and not ((found >= 0) & (found != truth)).any()


def test_the_exchange_of_legs_that_are_exchanged_is_tried_and_right_ones_score_more():
    template, pairs = known(), PairScore.of_template(known())
    stretches, truth, exchanged = named(LEG)
    none = np.full(len(truth), FREE)
    turns = near_turns(places(stretches, exchanged, len(template)), template, pairs, none)
    assert any((turn[exchanged] == truth).all() for turn in turns)
    assert score_with_sides(stretches, truth, template, pairs) > score_with_sides(stretches, exchanged, template, pairs)


def test_stated_names_keep_their_side():
    template, pairs = known(), PairScore.of_template(known())
    stretches, _, exchanged = named(LEG)
    stated = np.array([template.names.index("LKNE")])
    for turn in near_turns(places(stretches, exchanged, len(template)), template, pairs, stated):
        assert turn[stated[0]] == stated[0]


def test_what_is_left_over_are_absent_labels_and_long_markers_without_name():
    stretches, truth, _ = named(LEG)
    L = len(known())
    assert left_over(stretches, truth, L) == (0, 0)
    without = np.where(truth == 5, -1, truth)
    assert left_over(stretches, without, L) == (1, 1)
    assert left_over(stretches, without, L + 1) == (2, 1)


@pytest.mark.parametrize("limb", [LEG, ARM, None])
def test_a_key_frame_that_scores_most_does_not_decide_where_another_suits_the_trial_better(limb, monkeypatch):
    """The first key frame has limbs, or the whole body, turned about, and is said to score more than the right one."""
    template, pairs = known(), PairScore.of_template(known())
    stretches, truth, exchanged = named(limb or LEG)
    turned = exchanged if limb else mirrored(template.names)[truth]
    every = np.arange(len(truth))
    starts = [Start(2.0, 0, every, turned), Start(1.0, 0, every, truth)]
    monkeypatch.setattr(search, "_starts", lambda *_: starts)
    as_it_is = lambda label, *_: Solution(label, *total_score(stretches, label, pairs))  # noqa: E731
    monkeypatch.setattr(search, "_whole", as_it_is)
    found = solve(stretches, template, pairs, key_frames=10, beam=1, least_fit=0.3)
    has = found.label >= 0
    assert (found.label == truth)[has].all() and has.mean() > 0.9


def test_what_settles_as_another_key_frame_does_is_not_searched_again(monkeypatch):
    template, pairs = known(), PairScore.of_template(known())
    stretches, truth, _ = named(LEG)
    few, every, went = truth.copy(), np.arange(len(truth)), []
    few[[4, 9, 20, 30]] = truth[[9, 4, 30, 20]]
    monkeypatch.setattr(search, "_starts", lambda *_: [Start(2.0, 0, every, truth), Start(1.0, 0, every, few)])
    monkeypatch.setattr(search, "FEW", 0.0)
    monkeypatch.setattr(search, "total_score", lambda _, label, __: (1.0 + (label == few).all(), 1.0))
    monkeypatch.setattr(search, "_settled", lambda *_: truth)
    monkeypatch.setattr(search, "limbs_turned", lambda found, *_: went.append(found) or found)
    assert (solve(stretches, template, pairs, key_frames=10, beam=1, least_fit=0.3).label == truth).all()
    assert len(went) == 1
