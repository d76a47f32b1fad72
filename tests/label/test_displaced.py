"""A marker worn beside the place of an absent one, and what is put on anew from day to day."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, learn_template
from kinemark.label.displaced import nats_beside_place, place_odds
from kinemark.label.stretches import stretches_of
from kinemark.synth import walking, with_markers


@cache
def walk(seed):
    """A walker of 39 markers."""
    return with_markers(walking(duration_s=1.0, rate=100.0, seed=seed, wobble_mm=1.0), 39, seed=1).trajectories


@cache
def template():
    return learn_template(walk(1))


def put_elsewhere(trial, mm, only=None):
    """Markers, all or one, fixed so far beside their places to three that keep their distance to each."""
    rng, xyz, paths = np.random.default_rng(3), trial.xyz, []
    for i, path in enumerate(trial):
        if only is not None and path.name != only:
            paths.append(path)
            continue
        p = xyz[np.argsort(np.linalg.norm(xyz - xyz[i], axis=2).std(1))[1:4]]  # the first is the marker itself
        x = p[1] - p[0]
        z = np.cross(x, p[2] - p[0])
        axes = np.stack([one / np.linalg.norm(one, axis=1, keepdims=True) for one in (x, np.cross(z, x), z)])
        u = rng.normal(size=3)
        off = np.einsum("i,ifj->fj", mm * u / np.linalg.norm(u), axes)
        paths.append(MarkerTrajectory.measured(path.name, path.xyz + off))
    return replace(trial, paths=tuple(paths))


def beside(trial, by):
    """Nats of each label, by its right names."""
    label_of = np.array([by.names.index(name) for name in trial.names])
    return nats_beside_place(stretches_of(trial, by.size), label_of, by)


@pytest.mark.parametrize("name", ["LASI", "RHEE", "LTIB"])
def test_a_marker_that_sits_beside_its_place_is_not_sure_and_the_others_are(name):
    trial = put_elsewhere(walk(2), 30.0, name)
    nats = beside(trial, template())
    assert nats.argmax() == template().names.index(name) and (np.sort(nats)[:-1] < 2).all()
    found = label(trial, template())
    states = dict(zip(trial.names, found.state, strict=True))
    assert states.pop(name) == "unsure" and set(states.values()) == {"sure"}
    at = trial.names.index(name)
    assert found.names[at] == name and found.probability[at] > 0.4


def test_markers_that_are_where_they_were_or_were_all_put_on_anew_are_sure():
    for trial in (walk(2), put_elsewhere(walk(2), 10.0)):
        assert (beside(trial, template()) < 2).all()
        assert set(label(trial, template()).state) == {"sure"}


def test_a_marker_that_a_person_named_is_where_it_is():
    trial = put_elsewhere(walk(2), 30.0, "LTIB")
    assert set(label(trial, template(), stated={"LTIB": "LTIB"}).state) == {"sure"}


def test_another_subjects_template_tells_no_displacement():
    trial = put_elsewhere(walk(2), 30.0, "LTIB")
    assert (beside(trial, template().of_another(1.0)) == 0).all()


def test_nothing_is_told_of_labels_without_a_marker_nor_where_too_few_are_seen():
    trial, by = walk(2), template()
    few = Trajectories(trial.paths[:3], trial.rate)
    assert (beside(few, by) == 0).all()
    nobody = np.full(len(trial), -1)
    assert (nats_beside_place(stretches_of(trial, by.size), nobody, by) == 0).all()


def test_the_same_marker_put_on_anew_is_as_likely_as_another_at_the_least():
    odds = place_odds(np.array([-5.0, 0.0, 2.0, 50.0]))
    assert (np.diff(odds) <= 0).all() and odds[1] > 0.99 > odds[2] - 0.001 and odds[3] == pytest.approx(0.5)
