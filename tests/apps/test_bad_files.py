"""Every command that reads a file says of a bad one what is wrong, in a line, and leaves everything as it was."""

import contextlib

import numpy as np
import pytest

from kinemark.apps.cli import app, error_text
from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.io.c3d import write_c3d
from kinemark.io.trajectories_csv import write_trajectories_csv
from kinemark.io.trc import write_trc
from kinemark.synth import walking

GARBAGE = np.random.default_rng(0).bytes(3000)
ENDINGS = ("c3d", "trc", "csv", "tdf", "toml", "h5", "mkv", "json", "xyz")
COMMANDS = {
    "info": "info BAD",
    "convert": "convert BAD out.h5",
    "fill": "fill BAD -o out.c3d",
    "fill --static": "fill good.c3d --static BAD -o out.c3d",
    "angles": "angles BAD --model um2as -o out",
    "velocities": "velocities BAD out.csv",
    "gait": "gait BAD -o out",
    "gait --static": "gait good.c3d --static BAD -o out",
    "gait-reference": "gait-reference BAD BAD -o out.json",
    "audit": "audit BAD",
    "label": "label BAD -t good.c3d -o out.c3d",
    "label -t": "label good.c3d -t BAD -o out.c3d",
    "template": "template learn BAD -o out.template.h5",
    "marker-set": "marker-set FROM BAD -o out.toml",
    "edits": "edits problems BAD",
    "run": "run BAD",
    "plan": "plan out --given BAD --cameras 8",
    "starts": "starts BAD good.c3d",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A good trial, and bad files under a space and letters that are not Latin."""
    folder = tmp_path_factory.mktemp("bad")
    bad = folder / "bad files Ωß"
    bad.mkdir()
    walk = walking(duration_s=0.4, rate=50.0, seed=1)
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(walk.names, walk.xyz, strict=True))
    trial = Trial("good", Trajectories(paths, 50.0))
    write_c3d(folder / "good.c3d", trial)
    write_trc(bad / "cut.trc", trial.trajectories)
    write_trajectories_csv(bad / "cut.csv", trial.trajectories)
    (bad / "cut.c3d").write_bytes((folder / "good.c3d").read_bytes())
    for name in ("cut.trc", "cut.csv", "cut.c3d"):
        whole = (bad / name).read_bytes()
        (bad / name).write_bytes(whole[: 2 * len(whole) // 3])
    for ending in ENDINGS:
        (bad / f"empty.{ending}").write_bytes(b"")
        (bad / f"garbage.{ending}").write_bytes(GARBAGE)
    return folder


def said(words):
    """The status that a command ends with, and its error where it is one of the user's; its own faults are raised."""
    try:
        app(words)
    except SystemExit as stop:
        return stop.code, ""
    except Exception as error:
        text = error_text(error)
        if text is None:
            raise
        return 1, text
    return 0, ""


@pytest.mark.parametrize("command", COMMANDS)
def test_a_bad_file_is_a_line_and_nothing_is_written(command, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    for bad in sorted((folder / "bad files Ωß").iterdir()):
        status, error = said([str(bad) if word == "BAD" else word for word in COMMANDS[command].split()])
        with contextlib.suppress(ValueError):
            shown = capsys.readouterr()
            error = error + shown.out + shown.err
        assert status, f"{command} takes {bad.name}"
        told = " ".join(error.split())
        assert bad.stem in told and "Traceback" not in told, told
        assert told.count(". ") + told.endswith(".") >= 1, f"{told}: what to do?"
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
