"""Joint angles in the studio: as the command line takes them, with cycles, what made a leap, and the three files."""

import base64
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.apps.studio.angles import _none_fits
from kinemark.data import Events, MarkerTrajectory, Trajectories, Trial
from kinemark.engine.angles.of_trial import AngleSettings, trial_angles
from kinemark.engine.um2as.flow import limb_angles
from kinemark.io.marker_sets import read_marker_set
from kinemark.io.model_toml import load_model, models
from kinemark.io.trial import read_trial, write_trial
from kinemark.io.um2as import read_angles
from kinemark.synth.arm import arm
from support.studio import Studio


@pytest.fixture
def eating(tmp_path):
    """A file of an arm that feeds; a wrist marker leaps in frame 81."""
    subject = arm(duration_s=3.0, seed=2)
    xyz = subject.xyz + 0.2 * np.random.default_rng(3).normal(size=subject.xyz.shape)
    xyz[subject.names.index("WRU5"), 80] += (30, -40, 20)
    paths = tuple(MarkerTrajectory.measured(n, x) for n, x in zip(subject.names, xyz, strict=True))
    events = Events(("Reach",) * 3, ("Right",) * 3, np.array([0.0, 1.0, 2.0]))
    path = tmp_path / "eating.c3d"
    write_trial(Trial("eating", Trajectories(paths, 50.0), events=events), path)
    return path


def numbers(text, *shape):
    return np.frombuffer(base64.b64decode(text), "<f4").reshape(shape)


def asked(studio, what="", **said):
    return studio.page.post(f"{studio.trial}/angles{what}", said)


def test_angles_are_those_of_the_library(eating):
    studio, model = Studio(eating), load_model("um2as")
    shown = asked(studio).json()
    assert [one["name"] for one in shown["models"] if one["fits"]] == ["um2as"] and shown["chosen"]["model"] == "um2as"
    truth = trial_angles(read_trial(eating), model=model)
    for joint in shown["joints"]:
        for curve in joint["curves"]:
            place = joint["index"], slice(None), curve["turn"]
            assert np.allclose(numbers(curve["deg"], -1), truth.angles.deg[place], atol=1e-3, equal_nan=True)
            assert np.allclose(numbers(curve["sd"], -1), truth.angles.sd[place], rtol=1e-3, equal_nan=True)
    assert shown["headline"] == truth.figures["verdict"]["headline"]
    assert {numbers(point["xyz"], -1, 3).shape for point in shown["limb"]} == {(150, 3)}


def test_the_error_of_markers_can_be_stated_on_the_screen(eating):
    """Angles sent users of a screen to an option of the command line, and said that noise was 0.0000 mm."""
    smooth = eating.with_name("smooth.c3d")
    trial = read_trial(eating)
    still = tuple(replace(p, xyz=arm(duration_s=3.0, seed=2).xyz[k]) for k, p in enumerate(trial.trajectories.paths))
    write_trial(replace(trial, trajectories=replace(trial.trajectories, paths=still)), smooth)
    studio = Studio(smooth)
    shown = asked(studio).json()
    (found,) = [one for one in shown["findings"] if "noise" in one["words"]]
    assert "(< 0.001\u00a0mm)" in found["words"] and "Markers' SD" in found["advice"] and not shown["errors_stated"]
    assert "e-0" not in " ".join(shown["sentences"])
    stated = asked(studio, marker_sd_mm=0.5).json()
    assert stated["chosen"]["marker_sd_mm"] == 0.5 and "assumed" in " ".join(f["words"] for f in stated["findings"])
    sd = [np.nanmedian(numbers(one["joints"][0]["curves"][0]["sd"], -1)) for one in (shown, stated)]
    assert sd[1] > 100 * sd[0]


def test_cycles_and_smoothing_follow_what_is_said(eating):
    studio, model = Studio(eating), load_model("um2as")
    settings = AngleSettings(cycle_event="Reach", cycle_side="Right", smoothing="butterworth", cutoff_hz=6.0)
    said = {"cycle_event": "Reach", "cycle_side": "Right", "smoothing": "butterworth", "cutoff_hz": 6.0}
    shown = asked(studio, **said).json()
    truth = trial_angles(read_trial(eating), model=model, settings=settings)
    curve = shown["joints"][1]["curves"][0]
    assert curve["cycles"]["n"] == 2 and shown["events"] == [{"label": "Reach", "side": "Right", "times": 3}]
    assert np.allclose(numbers(curve["cycles"]["mean"], 101), truth.cycles.mean[1, :, curve["turn"]], atol=1e-3)
    assert np.allclose(numbers(curve["deg"], -1), truth.angles.deg[1, :, curve["turn"]], atol=1e-3)
    assert asked(studio, cutoff_hz=30.0, smoothing="butterworth").json()["words"]
    assert asked(studio, cycle_event="Bite").json()["words"]


def test_what_is_said_of_the_trial_changes_its_angles(eating):
    studio = Studio(eating)
    before = asked(studio).json()
    studio.act(kind="erase", marker="WRU5", first=81, last=81)
    after = asked(studio).json()
    assert before["head"] != after["head"]
    gone = [numbers(one["joints"][2]["curves"][0]["deg"], -1)[80] for one in (before, after)]
    assert np.isfinite(gone[0]) and np.isnan(gone[1])


def test_a_leap_leads_to_its_frame_and_marker(eating):
    studio = Studio(eating)
    leaps = asked(studio, "/spike", joint=2, turn=0, frame=83).json()
    assert (leaps["frame"], leaps["marker"], leaps["camera"]) == (81, "WRU5", None)
    assert "not known" in leaps["words"]
    for wrong in ({"joint": 7, "turn": 0, "frame": 81}, {"joint": 0, "turn": 0, "frame": 10**9}):
        assert asked(studio, "/spike", **wrong).status == 422


def test_the_three_files_are_written_and_never_over_another(eating):
    studio = Studio(eating)
    (eating.parent / "eating.elb").write_text("mine")
    names = asked(studio, "/export", model="um2as").json()["names"]
    assert (eating.parent / "eating.elb").read_text() == "mine" and len(names) == 3
    truth = limb_angles(read_trial(eating).trajectories)
    for name, joint in zip(sorted(names), ("elbow", "shoulder", "wrist"), strict=True):
        found, wanted = read_angles(eating.parent / name), truth.deg[truth.joints.index(joint)]
        columns = [0, 2] if joint == "elbow" else [0, 1, 2]
        assert np.allclose(found[:, columns], wanted[:, columns], atol=0.006)


def test_models_are_known_by_name_and_never_by_path(eating, tmp_path):
    (tmp_path / "mine.toml").write_text("name = 'x'")
    studio = Studio(eating)
    for name in ("../mine.toml", str(tmp_path / "mine.toml"), "/etc/passwd", "mine"):
        for what in ("", "/export"):
            assert asked(studio, what, model=name).status == 404
    assert "wants" in asked(studio, model="isb_shoulder").json()["words"]


def test_where_no_model_fits_it_is_said_what_the_nearest_lacks():
    known, wanted = {name: name for name in models()}, load_model("um2as").markers
    assert f"; um2as lacks {wanted[-1]}. Name" in _none_fits(known, wanted[:-1])
    assert "lacks" not in _none_fits(known, wanted[:1])
    assert "session.toml" in _none_fits(known, wanted[:1])
    assert "session" not in (said := _none_fits(known, wanted[:1], of_file=True)) and "kinemark angles" in said


@pytest.mark.parametrize("called", [str, "Anna:{}".format, str.lower])
def test_where_the_markers_are_those_of_gait_the_gait_report_is_named(called):
    known, names = {name: name for name in models()}, read_marker_set("kiss-15").names
    assert "Home makes it" in _none_fits(known, [called(name) for name in names])
    assert "kinemark gait" in _none_fits(known, [called(name) for name in names], of_file=True)
    assert "gait" not in _none_fits(known, [called(name) for name in names if name != "LANK"])
