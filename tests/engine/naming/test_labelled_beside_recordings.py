"""Labelled trials beside recordings: `kinemark init` proposes those that the markers can be named by."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.engine.first_session import Role, propose_session, session_text, with_role, write_first_session
from kinemark.engine.naming.subject_templates import Known, subject_template
from kinemark.engine.naming.template_files import save_template
from kinemark.engine.session import Session
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.trial import write_trial
from kinemark.synth import walking, with_markers
from support.laboratory import observe, ring
from support.motions import swarm


def walk(walked=1, n=15, *, seconds=1.5, placed=3, scale=1.0):
    """A labelled walk of one subject, who is `placed`."""
    trial = with_markers(walking(duration_s=seconds, rate=50.0, seed=walked), n, seed=placed).trajectories
    return scaled(trial, scale)


def scaled(trial, by):
    """Another one's, as tall as that."""
    paths = tuple(MarkerTrajectory.measured(path.name, path.xyz * by) for path in trial)
    return replace(trial, paths=paths)


def write_trajectories(path, trajectories):
    """As a file."""
    write_trial(Trial(path.stem, trajectories), path)


def renamed(trial, name):
    """With other names."""
    return replace(trial, paths=tuple(replace(path, name=name(k, path.name)) for k, path in enumerate(trial)))


@pytest.fixture
def folder(tmp_path):
    """The 2D points of one trial by two cameras, and their calibration."""
    rig = ring(2)
    write_rig_toml(tmp_path / "rig.toml", rig)
    write_detections_csv(tmp_path / "walk01.csv", observe(rig, swarm(6, frames=20, seed=1))[0])
    return tmp_path


def roles(folder):
    """Path → role and reason of all labelled trials."""
    found = propose_session(folder).recordings
    return {one.path: (one.role, one.why.kind) for one in found if one.content in ("trajectories", "template")}


def test_a_labelled_trial_names_the_markers(folder):
    write_trajectories(folder / "labelled.c3d", walk())
    write_first_session(propose_session(folder))
    assert Session.open(folder).settings.label.template == ("labelled.c3d",)
    assert Session.open(folder).settings.label.static == ()


def test_one_that_stands_still_is_static_whatever_its_name(folder):
    write_trajectories(folder / "walk.c3d", walk())
    still = walk().frames(0, 40)
    paths = tuple(MarkerTrajectory.measured(p.name, np.repeat(p.xyz[:1], 40, axis=0)) for p in still)
    write_trajectories(folder / "gait.c3d", replace(still, paths=paths))
    write_first_session(propose_session(folder))
    label = Session.open(folder).settings.label
    assert (label.template, label.static) == (("walk.c3d",), ("gait.c3d",))


def test_none_is_taken_that_names_nothing(folder):
    write_trajectories(folder / "tracks.c3d", renamed(walk(), lambda k, _: f"*{k}"))
    write_trajectories(folder / "few.c3d", walk().select(walk().names[:3]))
    assert set(roles(folder).values()) == {(Role.UNUSED, "few_names")}
    assert "template =" not in session_text(propose_session(folder))


def test_computed_points_are_no_markers(folder):
    turn = np.linspace(0, 1, 60)
    axes = 400 * np.stack([np.sin(turn), turn, 1 - turn**2], 1)
    x = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
    y = np.stack([-np.sin(turn), np.cos(turn), 0 * turn], 1)
    tips = {"O": axes, "A": axes + 100 * x, "P": axes + 100 * y, "L": axes + 100 * np.cross(x, y)}
    shift = {"PEL": 0 * axes, "FEM": 100 + axes[:, [2, 0, 1]]}
    segments = {f"{name}{tip}": xyz + by for name, by in shift.items() for tip, xyz in tips.items()}
    write_trajectories(
        folder / "model.c3d",
        Trajectories(tuple(MarkerTrajectory.measured(n, xyz) for n, xyz in segments.items()), 50.0),
    )
    assert roles(folder)["model.c3d"][0] is Role.UNUSED


def test_another_marker_set_is_not_mixed_in(folder):
    for k in (1, 2):
        write_trajectories(folder / f"walk{k}.c3d", walk(k))
    write_trajectories(folder / "arm.c3d", renamed(walk(), lambda k, name: f"OTHER{k}" if k > 4 else name))
    assert roles(folder)["arm.c3d"] == (Role.UNUSED, "other_markers")
    assert {roles(folder)[f"walk{k}.c3d"][0] for k in (1, 2)} == {Role.TEMPLATE}


def test_another_subject_is_not_mixed_in(folder):
    for k in (1, 2):
        write_trajectories(folder / f"walk{k}.c3d", walk(k))
    write_trajectories(folder / "child.c3d", walk(4, scale=0.7))
    assert roles(folder)["child.c3d"] == (Role.UNUSED, "other_subject")
    assert roles(folder)["walk1.c3d"][0] is Role.TEMPLATE


def test_of_two_subjects_none_is_guessed_and_a_person_says(folder):
    write_trajectories(folder / "one.c3d", walk(1))
    write_trajectories(folder / "other.c3d", walk(4, scale=0.7))
    assert set(roles(folder).values()) == {(Role.UNUSED, "which_subject")}
    said = with_role(propose_session(folder), "other.c3d", Role.TEMPLATE)
    assert 'template = ["other.c3d"]' in session_text(said)


def test_a_kept_template_names_the_markers(folder):
    write_trajectories(folder / "walk.c3d", walk())
    save_template(folder / "anna.template.h5", subject_template([folder / "walk.c3d"], Known()))
    (folder / "walk.c3d").unlink()
    write_first_session(propose_session(folder))
    assert Session.open(folder).settings.label.template == ("anna.template.h5",)


def test_images_name_nothing_and_labelled_trials_are_no_trials(folder):
    write_trajectories(folder / "walk.c3d", walk())
    proposal = propose_session(folder)
    with pytest.raises(ValueError, match=r"no labelled trial.*C3D"):
        with_role(proposal, "walk01.csv", Role.TEMPLATE)
    with pytest.raises(ValueError, match=r"holds no images.*template"):
        with_role(proposal, "walk.c3d", Role.TRIAL)
    unused = with_role(proposal, "walk.c3d", Role.UNUSED)
    assert "template =" not in session_text(unused)
