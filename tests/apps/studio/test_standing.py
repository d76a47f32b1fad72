"""Whether a trial can be shown, and run: asked by the page before it is."""

import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.data import Trajectories, Trial
from kinemark.io.trial import write_trial
from support.studio import Studio, file_in


def standing(studio, screen="trial"):
    return studio.page.get(f"{studio.trial}/standing?screen={screen}").json()


def test_a_file_is_shown_and_cannot_be_run(tmp_path):
    studio = Studio(file_in(tmp_path))
    assert standing(studio) == {"ready": True, "words": "", "runs": False}
    found = standing(studio, "detect")
    assert (found["ready"], found["runs"]) == (False, False) and "no images" in found["words"]


def test_a_file_without_markers_is_told_and_not_called_whole(tmp_path):
    write_trial(Trial("signals", Trajectories((), 100.0)), tmp_path / "signals.c3d")
    found = standing(Studio(tmp_path / "signals.c3d"))
    assert not found["ready"] and "no trajectories of markers" in found["words"]


def test_a_file_that_cannot_be_read_is_told_why(tmp_path):
    path = file_in(tmp_path)
    path.write_bytes(path.read_bytes()[:700])
    found = standing(Studio(path))
    assert (found["ready"], found["runs"]) == (False, False) and "walk.c3d" in found["words"]
