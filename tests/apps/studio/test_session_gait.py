"""The gait report of a session is made and shown on Home."""

import pytest

from kinemark.apps.studio import session_gait
from kinemark.data import KinemarkError
from kinemark.engine.gait import of_session
from kinemark.engine.session import Session
from kinemark.io.files import write_json
from kinemark.io.trial import write_trial
from kinemark.synth import WalkingBody, gait_laboratory
from support.shift_gait import MEASURES

SESSION = """\
name = "walks" # of Monday
rate_hz = 100.0

[cameras]
names = ["a", "b"]

[calibration]
file = "rig.toml"

[[trials]]
name = "walk"
detections = "walk.csv"

[[trials]]
name = "standing"
kind = "static"
detections = "standing.csv"
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "session.toml").write_text(SESSION)
    lab = gait_laboratory(WalkingBody(MEASURES), duration_s=2.6)
    for name, trial in (("walk", lab.walk), ("standing", lab.static)):
        (tmp_path / "results" / name).mkdir(parents=True)
        write_trial(trial, tmp_path / "results" / name / f"{name}.c3d")
        markers = [{"name": path.name} for path in trial.trajectories]
        write_json(tmp_path / "results" / name / "quality.json", {"trajectories": {"markers": markers}})
    return tmp_path


def test_it_is_made_by_a_button_and_then_shown(folder):
    """Who sat before the screen was told to write into session.toml."""
    assert session_gait.state(Session.open(folder)) == "possible"
    assert session_gait.make(folder).startswith("1 left and 2 right strides")
    text = (folder / "session.toml").read_text()
    assert "[gait]" in text and "# of Monday" in text
    assert session_gait.state(Session.open(folder)) == "there"
    assert "<html" in session_gait.page(folder) and of_session.gait_page(folder / "results") is not None


def test_trials_without_the_models_markers_have_none(folder):
    write_json(folder / "results" / "walk" / "quality.json", {"trajectories": {"markers": [{"name": "*1"}]}})
    assert session_gait.state(Session.open(folder)) == ""


def test_why_it_cannot_be_made_is_said(folder):
    (folder / "results" / "walk" / "walk.c3d").unlink()
    with pytest.raises(KinemarkError, match="run"):
        session_gait.make(folder)
