"""Another way of calibration for a session that exists."""

import shutil

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.engine.calibration_change import change_way, ways_of
from kinemark.engine.first_session import Role, propose
from kinemark.engine.first_session.calibration_way import MOVING
from kinemark.engine.session import Session
from kinemark.engine.session_changes import change_session
from kinemark.engine.simulate import Scene, simulate
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.video import write_video

SCENE = Scene(seconds=0.4, size_px=(376, 292), focal_px=385.0, noise=1.0, cameras=3)
COMMENT = "# of the knee study"


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """A session that is calibrated by hanging rods; in its folder are a calibration from elsewhere and a wand, too."""
    folder = tmp_path_factory.mktemp("ways") / "knee"
    simulate(folder, scene=SCENE)
    rig = Session.open(folder).calibrate().rig
    write_rig_toml(folder / "other.toml", rig)
    for name in rig.names:
        (folder / "wand").mkdir(exist_ok=True)
        write_video(folder / "wand" / f"{name}.mkv", np.zeros((MOVING, 8, 8), np.uint8), 50.0)
    file = folder / "session.toml"
    file.write_text(file.read_text("utf-8").replace("[calibration]", f"[calibration] {COMMENT}"), "utf-8")
    change_session(folder, {("calibration", "reference_marker"): {name: [[10.0, 20.0]] for name in rig.names}})
    return folder


@pytest.fixture
def folder(given, tmp_path):
    return shutil.copytree(given, tmp_path / "knee")


def test_each_recording_that_could_calibrate_is_offered_with_what_is_asked(folder):
    found = {(one.way.path, one.way.role): [ask.key for ask in one.open] for one in ways_of(folder)}
    assert found == {
        ("calib/{camera}.png", Role.CONTROL_FRAME): [],
        ("other.toml", Role.RIG): [],
        ("wand/{camera}.mkv", Role.WAND): ["calibration.wand.lengths_mm"],
    }


def test_recordings_are_looked_at_once_as_long_as_none_changes(folder, monkeypatch):
    looked, at = [], propose._pictured
    monkeypatch.setattr(propose, "_pictured", lambda *given: looked.append(given) or at(*given))
    ways_of(folder)
    change_way(folder, "other.toml", Role.RIG, {})
    assert len(ways_of(folder)) == 3 and len(looked) == 1, "session.toml is no recording"
    shutil.rmtree(folder / "wand")
    assert len(ways_of(folder)) == 2 and len(looked) == 2


def test_the_way_is_changed_and_changed_back_and_the_rest_of_the_file_stays(folder):
    before = Session.open(folder)
    P = before.calibrate().rig.P
    change_way(folder, "wand/{camera}.mkv", Role.WAND, {"calibration.wand.lengths_mm": "120 280"})
    settings = Session.open(folder).settings
    assert settings.calibration.way == "wand" and settings.calibration.wand.lengths_mm == (120.0, 280.0)
    assert settings.calibration.reference_marker["cam1"] == ((10.0, 20.0),), "fixed marks go with any way"
    assert settings.trials == before.settings.trials and settings.label == before.settings.label
    change_way(folder, "other.toml", Role.RIG, {})
    assert np.allclose(Session.open(folder).calibrate().rig.P, P)
    change_way(folder, "calib/{camera}.png", Role.CONTROL_FRAME, {})
    assert Session.open(folder).settings.calibration.way == "control_frame"


def test_what_is_asked_must_be_answered_and_a_method_of_the_former_way_goes_with_it(folder):
    text = (folder / "session.toml").read_text("utf-8")
    for answers, why in ({}, "Asked is"), ({"calibration.wand.lengths_mm": "wide"}, "wide"):
        with pytest.raises(KinemarkError, match=why):
            change_way(folder, "wand/{camera}.mkv", Role.WAND, answers)
    with pytest.raises(KinemarkError, match="cannot calibrate this session by wand"):
        change_way(folder, "walk01/{camera}.mkv", Role.WAND, {})
    assert (folder / "session.toml").read_text("utf-8") == text, "nothing was written"
    change_session(folder, {("calibrate", "method"): "dlt"})
    change_way(folder, "wand/{camera}.mkv", Role.WAND, {"calibration.wand.lengths_mm": "400"})
    assert "[calibrate]" not in (folder / "session.toml").read_text("utf-8")
