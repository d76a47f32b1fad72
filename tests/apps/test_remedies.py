"""What the command line offers for files that are silent, wrong or damaged, and what `info --json` says."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinemark.apps import cli
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.engine.describe import describe
from kinemark.io.c3d import document_of, encode_document
from kinemark.io.trial import read_trial, write_trial
from support.poses import made_poses
from support.trials import made_trial


def run(*arguments):
    return cli.app([str(a) for a in arguments], result_action="return_value")


@pytest.mark.parametrize("command", ["gait a.c3d", "angles a.c3d --model isb_shoulder", "pdf a.html", "fill a.c3d"])
def test_output_has_a_letter_in_every_command_that_has_it(command):
    _, bound, _ = cli.app.parse_args([*command.split(), "-o", "out"], exit_on_error=False, print_error=False)
    assert str(bound.arguments["output"]) == "out"


@pytest.fixture
def damaged(tmp_path):
    """A C3D file without its last frames."""
    raw = encode_document(document_of(made_trial()))
    (tmp_path / "cut.c3d").write_bytes(raw[: len(raw) - 3000])
    return tmp_path / "cut.c3d"


def test_every_command_reads_a_damaged_file_in_part(damaged, tmp_path, capsys):
    with pytest.raises(KinemarkError, match="--partial"):
        run("convert", damaged, tmp_path / "a.h5")
    run("convert", damaged, tmp_path / "a.h5", "--partial")
    assert "unreadable: frames" in capsys.readouterr().out
    run("fill", damaged, "-o", tmp_path / "b.c3d", "--partial", "--method", "linear")
    assert "unreadable: frames" in capsys.readouterr().out
    run("info", "--partial", damaged)
    assert "unreadable: frames" in capsys.readouterr().out
    n = read_trial(tmp_path / "a.h5").trajectories.n_frames
    assert 20 < n < 40 and read_trial(tmp_path / "b.c3d").trajectories.n_frames == n


@pytest.mark.parametrize("ending", [".c3d", ".trc"])
def test_unit_and_rate_can_be_stated(tmp_path, ending, capsys):
    xyz = np.random.default_rng(2).uniform(1, 2, (9, 3))
    write_trial(Trial("a", Trajectories((MarkerTrajectory.measured("m", xyz),), 50.0)), tmp_path / f"a{ending}")
    run("convert", tmp_path / f"a{ending}", tmp_path / "b.h5", "--length-unit", "m", "--rate-hz", "200")
    found = read_trial(tmp_path / "b.h5").trajectories
    assert found.rate == 200.0 and np.allclose(found.xyz[0], 1000 * xyz, rtol=1e-6)
    run("info", "--json", "--rate-hz", "200", tmp_path / f"a{ending}")
    out = capsys.readouterr().out
    facts = json.loads(out[out.index("{") :])[str(tmp_path / f"a{ending}")]
    assert (facts["rate_hz"], facts["duration_s"]) == (200.0, 9 / 200)


def test_info_as_json_is_data(tmp_path):
    trial = made_trial()
    write_trial(replace(trial, poses=(made_poses(),)), tmp_path / "a.c3d")
    facts = json.loads(json.dumps(describe(tmp_path / "a.c3d")))
    assert facts["markers"] == ["M0", "M1", "M2", "M3", "M4"]
    assert (facts["frames"], facts["first_frame"], facts["rate_hz"]) == (40, 7, 100.0)
    assert facts["gaps"] == {"count": 5, "longest_frames": 3}
    (channels,) = facts["analog"]
    assert (len(channels["channels"]), channels["rate_hz"], channels["samples"]) == (12, 400.0, 160)
    assert [plate["type"] for plate in facts["force_plates"]] == [2, 4]
    assert [(e["label"], e["side"], e["time_s"]) for e in facts["events"]] == [
        ("Foot Strike", "Left", 0.25), ("Foot Off", "Right", 61.5)
    ]  # fmt: skip
    assert facts["poses"] == [{"segments": ["pelvis", "thigh", "shank"], "rate_hz": 100.0}]


@pytest.mark.parametrize("command", ["audit", "edits list"])
def test_a_file_that_is_not_there_is_not_taken_for_a_trial_of_the_session_beside_it(tmp_path, command, capsys):
    (tmp_path / "session.toml").write_text('name = "a day"\n')
    with pytest.raises((KinemarkError, SystemExit)) as raised:
        run(*command.split(), tmp_path / "walk.c3d")
    said = f"{raised.value}{capsys.readouterr()}"
    assert "walk.c3d is not there" in said and "calibration" not in said


def test_what_is_not_there_or_no_table_of_ours_is_said_to_be_so(tmp_path, capsys):
    (tmp_path / "notes.csv").write_text("subject,height,mass\nA,1700,70\n")
    with pytest.raises(KinemarkError, match=r"line 1: 'subject,height,mass' is the heading of no table that is known"):
        run("convert", tmp_path / "notes.csv", tmp_path / "a.h5")
    with pytest.raises(KinemarkError, match="walk is not there"):
        run("convert", tmp_path / "walk", tmp_path / "a.h5")


def command(*arguments, **options):
    """The command in a process of its own: status, output and errors."""
    done = subprocess.run([sys.executable, "-m", "kinemark", *map(str, arguments)], capture_output=True, **options)
    return done.returncode, done.stdout, done.stderr.decode("utf-8", "replace")


def test_an_output_that_has_not_all_letters_is_written_without_them(tmp_path):
    write_trial(made_trial(), tmp_path / "é 膝.c3d")
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    status, out, _ = command("info", "é 膝.c3d", cwd=tmp_path, env=environment)
    assert status == 0 and b"holds: a trial" in out


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no full disk here")
@pytest.mark.parametrize("arguments", [["methods"], ["--help"]])
def test_a_full_disk_under_the_output_is_a_line(arguments):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "kinemark", *arguments], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode != 0 and "kinemark: " in done.stderr and "Traceback" not in done.stderr


def test_a_folder_that_may_not_be_written_is_a_line(monkeypatch, capsys):
    def refused():
        raise PermissionError(13, "Permission denied", "results/walk")

    monkeypatch.setattr(cli, "app", refused)
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 1 and "'results/walk'. Is there room, and may you" in capsys.readouterr().err
