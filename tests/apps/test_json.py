"""What commands print for a machine."""

import json

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, MarkerTrajectory, Trajectories, Trial
from kinemark.io.c3d import write_c3d

TALK = {"schema", "studio", "snap", "reference", "calibrate", "coordinates", "angles", "view"}
"""Prints JSON anyway, serves a browser, or is one of the menu's items of UM²AS, which write the thesis' own files."""


def commands(of, before=()):
    """Every command as words, with its options."""
    for name in of:
        if name.startswith("-"):
            continue
        sub = of[name]
        if sub.default_command is not None:
            yield (*before, name), {option for one in sub.assemble_argument_collection() for option in one.names}
        yield from commands(sub, (*before, name))


def test_every_command_that_prints_results_does_so_for_a_machine_too():
    found = dict(commands(app))
    silent = [words for words, options in found.items() if "--json" not in options]
    assert len(found) > 50
    assert not [words for words in silent if not (words[-1] in TALK and (len(words) == 1 or words[0] == "um2as"))]


@pytest.fixture
def trial(tmp_path):
    """A C3D file of one marker, with a covariance that a TRC file has no place for."""
    xyz = np.cumsum(np.random.default_rng(0).normal(size=(1, 9, 3)), axis=1) + 500
    path = MarkerTrajectory.measured("hip", xyz[0], cov=np.tile(np.eye(3), (9, 1, 1)))
    write_c3d(tmp_path / "trial.c3d", Trial("trial", Trajectories((path,), 100.0)))
    return tmp_path / "trial.c3d"


def printed(capsys, *words):
    """What a command prints, read as JSON."""
    app(list(map(str, words)), result_action="return_value")
    return json.loads(capsys.readouterr().out)


def test_a_conversion_says_what_it_could_not_keep(trial, capsys):
    found = printed(capsys, "convert", trial, trial.with_suffix(".trc"), "--json")
    assert found["written"] == str(trial.with_suffix(".trc"))
    assert {note["kind"] for note in found["notes"]} == {"not_written"}
    assert "covariance" in found["notes"][0]["text"]


def test_a_simulation_says_its_scene(tmp_path, capsys):
    words = ("--seconds", 0.1, "--size-px", 188, 146, "--cameras", 2, "--motion", "circle", "--json")
    found = printed(capsys, "simulate", tmp_path / "s", *words)
    assert (tmp_path / "s/session.toml").samefile(found["written"])
    assert found["scene"]["cameras"] == 2 and found["scene"]["c3d"] is None


def test_references_are_data(capsys):
    found = printed(capsys, "cite", "Woltring", "--json")
    assert all("Woltring" in str(entry["author"]) for entry in found.values()) and found
    with pytest.raises(KinemarkError, match="--bibtex and --json"):
        printed(capsys, "cite", "--json", "--bibtex")
