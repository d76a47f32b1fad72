"""Samples that are nowhere, and spans that tell of another unit, are told when a file is read."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.io.c3d import write_c3d
from kinemark.io.formats import read_file
from kinemark.io.possible_places import with_possible_places
from kinemark.io.trajectories_csv import write_trajectories_csv
from kinemark.io.trial import read_trial
from kinemark.synth import walking


def walk(scale=1.0):
    subject = walking(duration_s=0.4, rate=50.0, seed=1)
    paths = (MarkerTrajectory.measured(n, scale * x) for n, x in zip(subject.names, subject.xyz, strict=True))
    return Trial("walk", Trajectories(tuple(paths), 50.0))


def test_a_person_is_as_it_was():
    assert with_possible_places(trial := walk()) is trial
    tool = replace(trial := walk(0.001), trajectories=Trajectories(trial.trajectories.paths[:4], 50.0))
    assert with_possible_places(tool) is tool  # four markers may be as near as they like


@pytest.mark.parametrize(("scale", "unit"), [(0.001, "m"), (1000.0, "mm")])
def test_a_span_of_another_unit_is_noted_and_what_to_state(tmp_path, scale, unit):
    write_c3d(tmp_path / "walk.c3d", walk(scale))
    (note,) = read_trial(tmp_path / "walk.c3d").notes
    assert note.endswith(f"state the unit with --length-unit {unit}")


@pytest.mark.parametrize("ending", ["c3d", "csv"])
def test_samples_that_are_nowhere_are_missing_and_counted(tmp_path, ending):
    trial = walk()
    xyz = np.array(trial.trajectories.paths[2].xyz)
    xyz[3:5, 1] = 1e30
    far = MarkerTrajectory.measured(trial.trajectories.names[2], xyz)
    paths = (*trial.trajectories.paths[:2], far, *trial.trajectories.paths[3:])
    path, trial = tmp_path / f"walk.{ending}", replace(trial, trajectories=Trajectories(paths, 50.0))
    write_c3d(path, trial) if ending == "c3d" else write_trajectories_csv(path, trial.trajectories)
    found = read_trial(path)
    assert np.isnan(found.trajectories.paths[2].xyz[3:5]).all()
    assert np.isfinite(found.trajectories.paths[2].xyz[:3]).all()
    assert any(note.startswith("2 samples are farther than 1000 km") for note in found.notes)


def test_a_row_that_is_short_and_a_table_without_rows_say_what_to_do(tmp_path):
    write_trajectories_csv(tmp_path / "walk.csv", walk().trajectories)
    lines = (tmp_path / "walk.csv").read_text().splitlines()
    (tmp_path / "short.csv").write_text("\n".join([*lines[:4], "1,2"]))
    with pytest.raises(KinemarkError, match="line 5: has 2 cells, wanted 47"):
        read_trial(tmp_path / "short.csv")
    (tmp_path / "none.csv").write_text(lines[0])
    with pytest.raises(KinemarkError, match="a heading and no frames"):
        read_trial(tmp_path / "none.csv")


def test_a_session_is_not_said_to_be_none(tmp_path):
    (tmp_path / "session.toml").write_text("")
    with pytest.raises(KinemarkError, match="is a session"):
        read_file(tmp_path)
