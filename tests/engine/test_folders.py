"""Folders where files of trajectories are wanted."""

import csv
import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.engine.fill_files import output_beside
from kinemark.engine.folders import trials_in
from kinemark.io.c3d import write_c3d
from kinemark.io.trial import read_trial
from kinemark.synth import walking


@pytest.fixture
def folder(tmp_path):
    """Two walks with a gap, a text, and a folder with another file."""
    walk = walking(duration_s=1.5, rate=50.0, seed=1)
    xyz = walk.xyz.copy()
    xyz[walk.names.index("LKNE"), 20:26] = np.nan
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(walk.names, xyz, strict=True))
    (tmp_path / "older").mkdir()
    for name in ("b", "a", "older/c"):
        write_c3d(tmp_path / f"{name}.c3d", Trial(name, Trajectories(paths, walk.rate)))
    (tmp_path / "notes.txt").write_text("nothing")
    return tmp_path


def test_a_folder_stands_for_its_recordings_in_their_order(folder):
    both = (folder / "a.c3d", folder / "b.c3d")
    assert trials_in([folder]) == both
    assert trials_in([folder / "b.c3d", folder]) == both[::-1]
    assert trials_in([folder], besides=(folder / "a.c3d", None)) == both[1:]
    assert trials_in([folder / "a.c3d"], besides=(folder / "a.c3d",)) == both[:1]  # said is said
    assert trials_in([folder / "notes.txt", folder / "absent.c3d"]) == (folder / "notes.txt", folder / "absent.c3d")
    (folder / "session.toml").write_text("")
    assert trials_in([folder]) == (folder,)


def test_a_folder_without_recordings_says_where_some_are(folder):
    for name in ("a", "b"):
        (folder / f"{name}.c3d").unlink()
    with pytest.raises(KinemarkError, match=r"no file that ends with \.c3d.*older: name those folders"):
        trials_in([folder])


def test_fill_takes_a_folder_and_needs_no_output(folder, capsys):
    app(["fill", str(folder), "--method", "quintic", "--table", str(folder / "gaps.csv")], result_action="return_value")
    assert sorted(p.name for p in (folder / "filled").iterdir()) == ["a.c3d", "b.c3d"]
    assert not read_trial(folder / "filled" / "a.c3d").trajectories["LKNE"].gaps
    with (folder / "gaps.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(r["file"], r["marker"], r["first_frame"], r["state"]) for r in rows] == [
        (str(folder / f"{name}.c3d"), "LKNE", "21", "filled") for name in "ab"
    ]
    assert all(float(r["expected_mm"]) > 0 and r["method"] == "quintic" for r in rows)


@pytest.mark.parametrize("name", ["a.c3d", "walk.tdf", "walk.trc"])
def test_of_one_file_the_result_stands_beside_it(tmp_path, name):
    beside = output_beside(tmp_path / name, (tmp_path / name,))
    assert beside == tmp_path / {"a.c3d": "a_filled.c3d", "walk.tdf": "walk_filled.c3d"}.get(name, "walk_filled.trc")
    assert output_beside(tmp_path / name, (tmp_path / name, tmp_path / "b.c3d")) == tmp_path / "filled"


def test_info_and_audit_take_a_folder(folder, capsys):
    app(["info", str(folder), "--json"], result_action="return_value")
    told = json.loads(capsys.readouterr().out)
    assert [one["gaps"] for one in told.values()] and set(told) == {str(folder / "a.c3d"), str(folder / "b.c3d")}
    app(["audit", str(folder), "--json"], result_action="return_value")
    assert set(json.loads(capsys.readouterr().out)) == set(told)
