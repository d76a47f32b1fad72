"""Two subjects in one volume, each with a template: every track has its own subject's name."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from labelling_shredded import shredded

from kinemark.data import KinemarkError, Trajectories
from kinemark.label import label_subjects, learn_template, subjects
from kinemark.synth import walking, with_markers


@cache
def walk(seed, n=15, size=1.0):
    trial = with_markers(walking(duration_s=2.0, rate=100.0, seed=seed, wobble_mm=1.0), n, seed=1).trajectories
    return replace(trial, paths=tuple(replace(path, xyz=size * path.xyz) for path in trial))


def together(one, other, shift):
    """Both in one volume, the other beside the first, with the subjects' names before the markers'."""
    first = [replace(path, name=f"A:{path.name}") for path in one]
    second = [replace(path, name=f"B:{path.name}", xyz=path.xyz + shift) for path in other]
    return Trajectories((*first, *second), one.rate)


@pytest.mark.parametrize(("n", "size", "pieces", "seed"), [(15, 0.85, 1, 1), (15, 0.9, 5, 2), (39, 0.92, 1, 3)])
def test_tracks_of_two_subjects_have_their_own_subjects_names(n, size, pieces, seed):
    """They wear the same set and pass each other at an arm's length."""
    both = together(walk(7, 15), walk(8, n, size), np.array([200.0, 700.0, 0.0]))
    parts = shredded(both, pieces, 2.0, seed)
    templates = {"A": learn_template(walk(1, 15)), "B": learn_template(walk(2, n, size))}
    found = label_subjects(parts.tracks, templates)
    assert found.undecided == ()
    seen = np.isfinite(parts.tracks.xyz[..., 0]).sum(1)
    sure = np.array([state == "sure" for state in found.labels.state])
    right = np.array([a == b and a is not None for a, b in zip(found.labels.names, parts.truth, strict=True)])
    real = np.array([name is not None for name in parts.truth])
    share = seen[sure & right].sum() / seen[real].sum()
    assert seen[sure & ~right].sum() == 0 and share > (0.99 if pieces == 1 else 0.9)


def test_twins_are_not_told_apart_and_none_of_their_names_is_sure():
    both = together(walk(7), walk(7), np.array([0.0, 900.0, 0.0]))
    template = learn_template(walk(1))
    found = label_subjects(shredded(both, 1, 0.0, 1).tracks, {"A": template, "B": template})
    assert found.undecided == (("A", "B"),) and "sure" not in found.labels.state
    assert all(name is not None for name in found.labels.names) and (found.labels.probability <= 0.5).all()


def test_a_subject_who_is_not_there_has_no_names_and_nobody_is_refused():
    found = label_subjects(walk(7), {"A": learn_template(walk(1)), "B": learn_template(walk(2, 39))})
    assert {name[:2] for name in found.labels.names if name} == {"A:"} and found.of["B"].names == (None,) * 15
    with pytest.raises(KinemarkError, match="wanted 1 to 4"):
        label_subjects(walk(7), {})


def test_what_was_stated_of_a_subject_is_kept_and_no_other_subject_takes_it():
    """A marker of B is stated to be A's knee, one of A to be B's, and one to be nobody's."""
    both = together(walk(7), walk(8, 15, 0.85), np.array([200.0, 700.0, 0.0]))
    stated = {"B:LKNE": "A:LKNE", "A:RTOE": "B:RTOE", "A:SACR": None}
    found = label_subjects(both, {"A": learn_template(walk(1)), "B": learn_template(walk(2, 15, 0.85))}, stated=stated)
    told = dict(zip(both.names, found.labels.names, strict=True))
    assert {track: told[track] for track in stated} == stated
    assert told["A:LKNE"] != "A:LKNE" and told["B:RTOE"] != "B:RTOE"
    rest = [name for name in both.names if name not in stated and name not in ("A:LKNE", "B:RTOE")]
    assert all(told[name] in (name, None) for name in rest) and sum(told[name] is None for name in rest) <= 4


def test_statements_tell_twins_apart_by_the_neighbours_of_what_was_stated():
    """Nothing else could: none of their names is sure without, and those that were stated are sure with it."""
    both = together(walk(7), walk(7), np.array([0.0, 900.0, 0.0]))
    template = learn_template(walk(1))
    found = label_subjects(both, {"A": template, "B": template}, stated={"A:LKNE": "A:LKNE", "B:SACR": "B:SACR"})
    assert found.labels.names == both.names and found.undecided == () and set(found.labels.state) == {"sure"}


def test_no_tracks_are_named_twice_for_one_subject(monkeypatch):
    """The orders in which subjects are named often leave one of them the same tracks."""
    asked = []
    own = subjects.label
    monkeypatch.setattr(subjects, "label", lambda *args, **more: asked.append(key(*args)) or own(*args, **more))

    def key(tracks, template, **more):
        return id(template), tracks.names

    both = together(walk(7), walk(8, 15, 0.85), np.array([200.0, 700.0, 0.0]))
    label_subjects(both, {"A": learn_template(walk(1)), "B": learn_template(walk(2, 15, 0.85))})
    assert len(asked) == len(set(asked)) < 8
