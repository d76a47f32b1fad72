"""Limbs whose names are exchanged as wholes are found, and put back where that scores more."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import kinemark.label.solve as search
from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.marker_sides import sides_by_name
from kinemark.io.marker_sets import read_marker_set
from kinemark.label import label as label_trial
from kinemark.label import learn_template
from kinemark.label.claims import left_over
from kinemark.label.evidence import PairScore
from kinemark.label.exchange import Exchanger
from kinemark.label.limbs import exchange_of, gain_by_the_rest, near_turns, score_with_sides
from kinemark.label.side_pairs import mirrored
from kinemark.label.solve import Solution, Start, limbs_turned, solve
from kinemark.label.stretches import FREE, stretches_of
from kinemark.label.sweeps import places, total_score
from support.wearing import body_of, moving

LEG = ("THI", "KNE", "TIB", "ANK", "HEE", "TOE")
ARM = ("UPA", "ELB", "FRM", "WRA", "WRB", "FIN")

TRUNK = {
    "SACR": (-90, 0, 50), "LASI": (90, 110, 60), "RASI": (90, -115, 55), "C7": (-60, 10, 500), "CLAV": (60, 0, 450),
    "STRN": (90, 5, 300), "T10": (-90, -10, 250), "RBAK": (-100, -70, 350),
}  # fmt: skip
OUTER = {
    "ANK": (-20, -820), "STL": (10, -850), "P5M": (60, -870), "D5M": (120, -880), "TIB": (0, -650), "KNE": (10, -420),
    "HFB": (0, -470), "HEE": (-70, -860),
}  # fmt: skip
INNER = {"ANK": "MED", "STL": "NAV", "P5M": "P1M", "D5M": "D1M", "TIB": "SHN", "KNE": "KNM", "HFB": "TUB"}


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


def legs_that_swing(seed):
    """Below a trunk, about hips at height 0, mm; each marker of the outer side has one of the inner side beside it."""
    rng, t = np.random.default_rng(seed), np.arange(30) / 30
    paths = {name: np.tile(np.array(place, float), (30, 1)) for name, place in TRUNK.items()}
    for side, sign in (("L", 1), ("R", -1)):
        angle = 0.4 * sign * np.sin(2 * np.pi * t + seed)
        for name, (x, z) in OUTER.items():
            paths[side + name] = swung(angle, x, sign * 135.0, z)
            if name in INNER:
                paths[side + INNER[name]] = swung(angle, x + 8, sign * 72.0, z + 10)
    tracks = (MarkerTrajectory.measured(name, xyz + rng.normal(size=xyz.shape)) for name, xyz in paths.items())
    return Trajectories(tuple(tracks), 30.0)


def swung(angle, x, y, z):
    """(F, 3) of a point that turns about an axis from side to side."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x - s * z, np.full(len(angle), y), s * x + c * z], axis=1)


def test_legs_whose_exchanged_names_settled_within_them_are_put_back():
    """Quadruples make outer markers inner ones, and the exchange of whole legs then loses far more than others do."""
    template, trial = learn_template(legs_that_swing(1)).of_another(1.0), legs_that_swing(2)
    pairs, stretches = PairScore.of_template(template), stretches_of(trial, template.size)
    truth = np.array([template.names.index(name) for name in trial.names])
    sides = [pair for pair in sides_by_name(template.names) if pair[0] != "LASI"]
    legs, turn = exchange_of(template, sides), np.arange(len(template))
    turn[list(legs[0])] = legs[1]
    wrong = search._settled(stretches, turn[truth], template, pairs, 0.3)
    y = places(stretches, wrong, len(template))
    assert Exchanger.of(template, pairs).gains(y, [legs])[0] < -500 and gain_by_the_rest(y, pairs, legs) > 0
    for label in (truth, wrong):
        found = Solution(label, *total_score(stretches, label, pairs))
        assert (limbs_turned(found, stretches, template, pairs, 0.3).label == truth).all()


@pytest.mark.parametrize("limb", [LEG, ARM])
def test_limbs_with_each_others_names_are_put_back_and_right_ones_stay(limb):
    template, pairs = known(), PairScore.of_template(known())
    stretches, truth, exchanged = named(limb)
    for label in (truth, exchanged):
        found = Solution(label, *total_score(stretches, label, pairs))
        assert (limbs_turned(found, stretches, template, pairs, 0.3).label == truth).all()


def test_a_body_that_the_search_turns_about_has_its_own_sides_at_the_end(monkeypatch):
    """By one posture, whose distances tell little."""
    template, trial = learn_template(walk(3).frames(0, 1), relative_spread=0.18), walk(13)
    truth = np.array([template.names.index(name) for name in trial.names])
    for start in (truth, mirrored(template.names)[truth]):
        monkeypatch.setattr(search, "_outwards", lambda *_, start=start: [start])
        found = label_trial(trial, template)
        right = [one == name for one, name in zip(found.names, trial.names, strict=True)]
        wrong = [one not in (None, name) for one, name in zip(found.names, trial.names, strict=True)]
        assert np.mean(right) > 0.9 and not any(wrong)


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


def test_by_another_subjects_template_places_must_agree_that_other_names_are_better(monkeypatch):
    """Distances carry a chain of wrong names: one of 39 markers, with a label absent, had 1609 nats for 1556."""
    stretches, truth, _ = named(LEG)
    chain = truth.copy()
    chain[[4, 9, 20]] = truth[[9, 20, 4]]
    for template, wanted in ((replace(known(), doubt=None), [True, True]), (known(), [False, True])):
        found = []
        for other, label in ((chain, truth), (truth, chain)):
            scores = iter((100.0, 50.0))
            monkeypatch.setattr(search, "score_with_sides", lambda *_, scores=scores: next(scores))
            found.append(search._clearly_better(other, label, stretches, template, PairScore.of_template(template)))
        assert found == wanted


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
