"""A marker worn beside the place of an absent one, and what is put on anew from day to day."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.label import label, label_subjects, learn_template
from kinemark.label.displaced import TOLD, beside_places, markers_beside
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
    """Of each label, by its right names."""
    label_of = np.array([by.names.index(name) for name in trial.names])
    return beside_places(stretches_of(trial, by.size), label_of, by)


@cache
def labels_of_one_beside():
    """Of a trial with LTIB 15 mm beside its place."""
    return label(put_elsewhere(walk(2), 15.0, "LTIB"), template())


def test_a_marker_that_sits_beside_its_place_is_told_with_mm_and_its_name_stays_sure():
    found = labels_of_one_beside()
    [(told, mm)] = found.displaced
    assert told == "LTIB" and mm == pytest.approx(15.0, abs=2.0)
    assert found.names == walk(2).names and set(found.state) == {"sure"}


@pytest.mark.parametrize("mm", [15.0, 20.0, 30.0])
@pytest.mark.parametrize("name", ["LASI", "RHEE", "LTIB", "LKNE", "RTHI"])
def test_the_displacement_is_right_and_the_neighbours_are_not_told(name, mm):
    found, a = beside(put_elsewhere(walk(2), mm, name), template()), template().names.index(name)
    assert np.flatnonzero(found.nats > TOLD).tolist() == [a]
    assert found.mm[a] == pytest.approx(mm, abs=2.5)


def test_of_markers_that_are_where_they_were_or_were_all_put_on_anew_nothing_is_told():
    for trial in (walk(2), put_elsewhere(walk(2), 10.0)):
        assert (beside(trial, template()).nats < TOLD).all()
    assert label(walk(2), template()).displaced == ()


def test_a_marker_that_a_person_named_is_where_it_is():
    trial, found = put_elsewhere(walk(2), 15.0, "LTIB"), labels_of_one_beside()
    assert markers_beside(trial, found, template(), {"LTIB"}) == ()
    assert markers_beside(trial, found, template(), {"RTIB"}) == found.displaced


def test_of_several_subjects_the_marker_is_told_by_its_whole_name():
    found = label_subjects(put_elsewhere(walk(2), 15.0, "LTIB"), {"A": template()}).labels
    assert [name for name, _ in found.displaced] == ["A:LTIB"]


def test_by_another_subjects_template_nothing_is_told():
    trial, found = put_elsewhere(walk(2), 15.0, "LTIB"), labels_of_one_beside()
    assert (beside(trial, template().of_another(1.0)).nats == 0).all()
    assert markers_beside(trial, replace(found, another=1.1), template()) == ()


def test_nothing_is_told_of_labels_without_a_marker_nor_where_too_few_are_seen():
    trial, by = walk(2), template()
    few = Trajectories(trial.paths[:3], trial.rate)
    assert (beside(few, by).nats == 0).all()
    nobody = np.full(len(trial), -1)
    assert (beside_places(stretches_of(trial, by.size), nobody, by).nats == 0).all()
