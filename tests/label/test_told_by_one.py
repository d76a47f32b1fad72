"""Markers that look alike, by a static trial without segments: what one other marker alone says of them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import learn_template
from kinemark.label import margin as of_margin
from kinemark.label.evidence import PairScore
from kinemark.label.margin import label_probability, margins
from kinemark.label.stretches import stretches_of
from kinemark.label.told_by_one import TIMES, at_most_tellers, told_by_none, told_by_one

WRIST = ("MEDIAL", "LATERAL")


@cache
def seated(frames):
    """Forty markers of a trunk that leans a little, and two of a wrist 0.4 m beside it, 50 mm apart."""
    rng, t = np.random.default_rng(4), np.linspace(0, 2, frames)
    trunk = np.array([0.0, 400.0, 0.0]) + rng.normal(0, 1.0, (40, 3)) * [60.0, 60.0, 120.0]
    trunk[:2, 2] = 900.0, -900.0  # of a body as tall as one
    wrist = np.array([[0.0, 25.0, 0.0], [0.0, -25.0, 0.0]])
    names = (*(f"T{k}" for k in range(40)), *WRIST)
    xyz = np.concatenate([trunk, wrist])[:, None] + 0 * t[:, None]
    xyz[:40, :, 0] += 8.0 * np.sin(3 * t) * trunk[:, 2:] / 120.0
    xyz = xyz + rng.normal(0, 0.5, xyz.shape)
    return Trajectories(tuple(MarkerTrajectory.measured(n, p) for n, p in zip(names, xyz, strict=True)), 50.0)


def by_one_posture(segments=None):
    return learn_template(seated(1), relative_spread=0.18, segments=segments)


def of_exchanged(monkeypatch, times):
    """What exchanging the wrist's markers loses, and how likely their names are; the forearm may have turned."""
    monkeypatch.setattr(of_margin, "TIMES", times)
    trial, template = seated(100), by_one_posture()
    called = np.array([template.names.index(name) for name in trial.names])
    about = margins(stretches_of(trial, template.size), called, template, PairScore.of_template(template))
    own = [trial.names.index(name) for name in WRIST]
    return about.exchange[own], label_probability(about)[own]


def test_two_markers_of_a_wrist_are_not_sure_where_a_trunk_alone_tells_them_apart(monkeypatch):
    lost, p = of_exchanged(monkeypatch, TIMES)
    assert (lost < 3).all() and (p < 0.99).all()
    lost, p = of_exchanged(monkeypatch, 1e6)
    assert (lost > 5).all() and (p > 0.99).all()


def test_one_other_marker_says_little_of_markers_that_look_alike_and_much_of_others():
    template, place = by_one_posture(), seated(1)
    y = np.stack([place[name].xyz for name in template.names], axis=1).astype(np.float32)
    a, b, far = (template.names.index(name) for name in (*WRIST, "T7"))
    alike, apart = told_by_one(y, PairScore.of_template(template), [(a, b), (a, far)])
    assert 0 < alike < 0.5 < 2 < apart


@pytest.mark.parametrize("segments", [None, {"forearm": WRIST}])
def test_their_own_distance_tells_nothing_of_two(segments):
    template = by_one_posture(segments)
    a, b = (template.names.index(name) for name in WRIST)
    assert told_by_none([(a, b)], template, np.ones(len(template), bool)).tolist() == [True]


def test_a_marker_whose_distance_keeps_tells_two_apart_where_it_is_seen():
    """Two of a racer's glove were surely exchanged where the one that tells them apart was not there: a forearm in a
    posture that its template never showed spoke for the exchange."""
    with_elbow = {"forearm": (*WRIST, "T0")}
    template = by_one_posture(with_elbow)
    a, b, elbow = (template.names.index(name) for name in (*WRIST, "T0"))
    there = np.ones(len(template), bool)
    mean = template.distance.copy()
    mean[a, elbow] = mean[elbow, a] = 1.5 * mean[b, elbow]
    told = replace(template, distance=mean)
    assert told_by_none([(a, b)], told, there).tolist() == [False]
    there[elbow] = False
    assert told_by_none([(a, b)], told, there).tolist() == [True]


def with_hand():
    """The same in one frame, 0.4 m further off, and two of a hand that lie as those of the wrist do, 35 mm beside."""
    place = seated(1)
    off = {name: np.array([0.0, -400.0, 0.0]) if name in WRIST else np.zeros(3) for name in place.names}
    hand = {f"H{name}": place[name].xyz + np.array([25.0, -400.0, -25.0]) for name in WRIST}
    xyz = {name: place[name].xyz + off[name] for name in place.names} | hand
    return Trajectories(tuple(MarkerTrajectory.measured(name, one) for name, one in xyz.items()), place.rate)


@pytest.mark.parametrize("of_wrist", [0.6, 0.999])
def test_a_name_is_at_most_as_sure_as_the_names_that_tell_it(of_wrist):
    """Those of a wrist may be exchanged together with those of its hand, and then tell that these are right."""
    trial = with_hand()
    template = learn_template(trial, relative_spread=0.18)
    label = np.array([template.names.index(name) for name in trial.names])
    p = np.array([of_wrist if name in WRIST else 0.998 for name in trial.names])
    stretches, pairs = stretches_of(trial, template.size), PairScore.of_template(template)
    found = dict(zip(trial.names, at_most_tellers(p, stretches, label, template, pairs), strict=True))
    assert found["HMEDIAL"] == found["HLATERAL"] == min(of_wrist, 0.998)
    assert all(found[f"T{k}"] == 0.998 for k in range(40)), "other trunk markers tell these"
