"""Folders where files of trajectories are wanted."""

import csv
import json
import shutil

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.engine.describe import described
from kinemark.engine.fill_files import targets_of
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


def test_a_tsv_counts_where_it_has_markers(folder):
    """Qualisys exports markers, analog signals and forces as files that end alike."""
    (folder / "c.tsv").write_text("NO_OF_FRAMES\t1\nMARKER_NAMES\tLASI\n1\t2\t3\n")
    (folder / "c_a.tsv").write_text("NO_OF_SAMPLES\t1\nCHANNEL_NAMES\tFx\n1\n")
    assert [path.name for path in trials_in([folder])] == ["a.c3d", "b.c3d", "c.tsv"]


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
    (beside,) = targets_of((tmp_path / name,), alone=True).values()
    assert beside == tmp_path / {"a.c3d": "a_filled.c3d", "walk.tdf": "walk_filled.c3d"}.get(name, "walk_filled.trc")


def test_each_of_two_folders_has_its_own_results(folder):
    """Subjects' folders hold files of the same names."""
    shutil.copytree(folder, folder / "other")
    app(["fill", str(folder), str(folder / "other"), "--method", "quintic"], result_action="return_value")
    assert all((one / "filled" / f"{name}.c3d").is_file() for one in (folder, folder / "other") for name in "ab")


def test_info_and_audit_take_a_folder(folder, capsys):
    app(["info", str(folder), "--json"], result_action="return_value")
    told = json.loads(capsys.readouterr().out)
    assert [one["gaps"] for one in told.values()] and set(told) == {str(folder / "a.c3d"), str(folder / "b.c3d")}
    app(["audit", str(folder), "--json"], result_action="return_value")
    assert set(json.loads(capsys.readouterr().out)) == set(told)


def test_a_trial_of_a_session_is_no_folder_of_files_where_its_images_lie_in_one(folder):
    (folder / "session.toml").write_text('[[trials]]\nname = "one"\n')
    (folder / "one").mkdir()
    assert trials_in([folder / "one", folder / "older"]) == (folder / "one", folder / "older" / "c.c3d")
    with pytest.raises(KinemarkError, match=r"session\.toml has settings that are not understood"):
        app(["audit", str(folder / "one")], result_action="return_value")


def test_results_and_hidden_files_of_a_folder_are_no_recordings(folder):
    for name in ("a_filled.c3d", "a_filled_filled.c3d", "b_gait.c3d", "c_filled.c3d", "b_gait.trc", "._a.c3d"):
        shutil.copy(folder / "a.c3d", folder / name)
    said = []
    found = trials_in([folder, folder / "older", folder], say=said.append)
    assert [one.name for one in found] == ["a.c3d", "b.c3d", "b_gait.trc", "c_filled.c3d", "c.c3d"]
    results = ", ".join(str(folder / name) for name in ("a_filled.c3d", "a_filled_filled.c3d", "b_gait.c3d"))
    assert said == [f"left out, as results of files beside them: {results}"]
    assert trials_in([folder / "a_filled.c3d"], say=said.append) == (folder / "a_filled.c3d",) and len(said) == 1


@pytest.mark.parametrize("command", ["info", "audit", "fill --method=quintic"])
def test_an_empty_folder_keeps_nobody_from_the_others(folder, command, capsys):
    empty = folder / "empty"
    empty.mkdir()
    with pytest.raises(SystemExit) as end:
        app([*command.split(), str(empty), str(folder / "a.c3d"), "--json"], result_action="return_value")
    out, err = capsys.readouterr()
    assert end.value.code == 1 and str(folder / "a.c3d") in json.loads(out)
    assert f"{empty} has no file that ends with .c3d" in out + err


def test_a_table_takes_the_place_of_an_earlier_table_and_of_nothing_else(folder):
    def run(table, *words, source="a.c3d"):
        app(["fill", str(folder / source), "--method", "quintic", "--table", str(folder / table), *words],
            result_action="return_value")  # fmt: skip

    recording, ours, theirs = folder / "a.c3d", folder / "gaps.csv", folder / "study.csv"
    before = recording.read_bytes()
    theirs.write_text("subject,height\n")
    for table, words, said in (
        ("a.c3d", (), "ends with .csv"), ("b.txt", (), "ends with .csv"), ("study.csv", (), "is no table of gaps"),
        ("out.csv", ("-o", str(folder / "out.csv")), "also a trial"),
        ("still.csv", ("--static", str(folder / "still.csv")), "also a trial"),
    ):  # fmt: skip
        with pytest.raises(KinemarkError, match=said):
            run(table, *words)
    with pytest.raises(KinemarkError, match="also a trial"):
        run("walk.csv", source="walk.csv")
    assert recording.read_bytes() == before and theirs.read_text() == "subject,height\n"
    assert not [*folder.glob("*_filled*"), *folder.glob("out*")]
    run("gaps.csv")
    run("gaps.csv", source="b.c3d")
    assert "b.c3d" in ours.read_text() and "a.c3d" not in ours.read_text()


def test_info_counts_signals_by_their_kind():
    signals = [{"kind": kind} for kind in ("angle", "angle", "scalar", "emg", "emg")]
    assert described({"signals": signals}) == ["signals: 2 angles, 1 scalar, 2 EMG channels"]


def test_a_folder_of_images_is_told_how_to_begin(tmp_path):
    """It was said what it lacks, and not what to do."""
    (tmp_path / "of the day").mkdir()
    (tmp_path / "of the day" / "cam1.PNG").write_bytes(b"")
    with pytest.raises(KinemarkError, match=r"kinemark init '.*of the day'"):
        trials_in([tmp_path / "of the day"])
    (tmp_path / "of the day" / "cam1.PNG").rename(tmp_path / "of the day" / "cam1.txt")
    with pytest.raises(KinemarkError, match=r"no session\.toml\.$"):
        trials_in([tmp_path / "of the day"])
