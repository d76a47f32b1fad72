"""`kinemark edits` at the command line: what it answers."""

import numpy as np
import pytest

from kinemark.apps import cli
from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.data.edits import Erase, Trim
from kinemark.engine.editing.journal import Journal
from kinemark.io.trial import write_trial
from kinemark.report.words.problems import action_text, problem_text


def run(capsys, *arguments):
    cli.app([str(a) for a in arguments], result_action="return_value")
    return capsys.readouterr().out


def test_undo_and_redo_say_which_entry_counts(tmp_path, capsys):
    rng = np.random.default_rng(0)
    paths = tuple(MarkerTrajectory.measured(name, rng.uniform(0, 900, (30, 3))) for name in ("LKNE", "*1"))
    file = tmp_path / "walk.c3d"
    write_trial(Trial("walk", Trajectories(paths, 100.0)), file)
    run(capsys, "edits", "erase", file, "LKNE", "--frames", "3-5")
    assert "entry 1 undone" in run(capsys, "edits", "undo", file)
    assert "entry 1 done again" in run(capsys, "edits", "redo", file)
    assert "entry 1 undone" in run(capsys, "edits", "undo", file, "1")


def test_an_entry_is_shown_with_its_witnesses_and_one_of_an_older_journal_without(tmp_path, capsys):
    rng = np.random.default_rng(0)
    file, xyz = tmp_path / "walk.c3d", rng.uniform(0, 900, (30, 3))
    write_trial(Trial("walk", Trajectories((MarkerTrajectory.measured("LKNE", xyz),), 100.0)), file)
    run(capsys, "edits", "erase", file, "LKNE", "--frames", "3-5")
    Journal.of(tmp_path, "walk").append([Erase("LKNE", 9, 10), Trim(2, 29)])
    assert run(capsys, "edits", "show", file, "1").count("witness: frame") == 3
    shown = run(capsys, "edits", "show", file, "2")
    assert "witness" not in shown and "held" in shown


@pytest.mark.parametrize(("mm", "said"), [(0.47, "0.5 mm"), (12.3, "12 mm"), (67356.0, "more than 10 m")])
def test_distances_of_problems_are_such_as_a_person_reads(mm, said):
    assert said in problem_text("spike", ("LKNE",), 3, 5, mm)
    assert f"(a jump of {said})" in action_text("keep", ("LKNE",), 3, mm)
