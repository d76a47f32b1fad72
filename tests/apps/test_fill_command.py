"""Filling as users meet it: files of other systems, sessions, the command, and the page."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.apps.cli import app
from kinemark.data import KinemarkError, Origin, Trajectories, Trial, same
from kinemark.engine.fill_files import fill_file, fill_method
from kinemark.engine.session import Session
from kinemark.fill import Linear, RigidBody
from kinemark.io.c3d import read_c3d, write_c3d
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.trc import read_trc
from kinemark.report.terminal_summary import filling_summary
from support.filling import GAP, segment, trial_of, with_gap
from support.laboratory import observe, ring
from support.motions import body
from support.schema import check_quality
from support.sessions import OF_FILE
from support.shared import shared_data
from support.trials import made_trial


@pytest.fixture
def file(tmp_path):
    """A C3D file with one gap in it, channels, plates and events."""
    xyz = segment(frames=40 * 5)
    made = made_trial(n=200, m=1)
    write_c3d(tmp_path / "in.c3d", replace(made, trajectories=trial_of(with_gap(xyz)).trajectories))
    return tmp_path / "in.c3d", xyz


def test_a_file_comes_back_with_its_gaps_filled_and_nothing_else_changed(file, tmp_path):
    source, truth = file
    given = source.read_bytes()
    done = fill_file(source, tmp_path / "out.c3d", method=RigidBody(), name="rigid_body", report=tmp_path / "out.html")
    before, after = read_c3d(source), read_c3d(tmp_path / "out.c3d")
    found = after.trajectories["A"]
    assert (found.origin[GAP] == Origin.FILLED).all() and (found.origin == Origin.FILLED).sum() == 20
    off = np.linalg.norm(found.xyz[GAP] - truth[0, GAP], axis=1)
    (gap,) = done.figures["list"]
    assert off.mean() < 1.5 and 0.4 * off.mean() < gap["expected_mm"] < 2.5 * off.mean()
    assert (gap["first_frame"], gap["last_frame"]) == (45, 64)
    for name in "BCDE":
        assert same(before.trajectories[name], after.trajectories[name])
    seen = before.trajectories["A"].origin == Origin.MEASURED
    assert np.array_equal(before.trajectories["A"].xyz[seen], found.xyz[seen])
    assert all(same(a, b) for a, b in zip(before.analog, after.analog, strict=True))
    assert before.events.label == after.events.label and len(after.plates) == 2
    assert source.read_bytes() == given
    page = (tmp_path / "out.html").read_text()
    assert "All gaps are filled" in page and page.count("<svg") == 1 and "Plotly" not in page.split("<main>")[1][:1000]


def test_a_limit_leaves_gaps_open_and_says_why(file, tmp_path):
    source, _ = file
    done = fill_file(source, tmp_path / "out.trc", method=Linear(), name="linear", limit_mm=2.0)
    (gap,) = done.figures["list"]
    assert not gap["method"] and gap["state"] == "above_limit"
    assert "more than the limit of 2 mm" in filling_summary(done.figures)
    assert done.figures["verdict"]["grade"] == "red"
    assert np.isnan(read_trc(tmp_path / "out.trc")["A"].xyz[GAP]).all()


def test_what_cannot_be_done_is_said(file, tmp_path, capsys):
    source, _ = file
    with pytest.raises(KinemarkError, match="nothing is overwritten"):
        fill_file(source, source)
    with pytest.raises(KinemarkError, match="one of the endings"):
        fill_file(source, tmp_path / "out.xlsx")
    with pytest.raises(KinemarkError, match="did you mean 'body'"):
        fill_method("bdy")
    with pytest.raises(KinemarkError, match="not a parameter of pca"):
        fill_method("pca", ["marker=3"])
    with pytest.raises(KinemarkError, match=r"most_markers: .* found 'x'"):
        fill_method("pca", ["most_markers=x"])
    write_c3d(tmp_path / "none.c3d", Trial("n", Trajectories((), 100.0)))
    with pytest.raises(KinemarkError, match="no markers"):
        fill_file(tmp_path / "none.c3d", tmp_path / "out.c3d")


def test_the_command_prints_what_became_of_every_gap(file, tmp_path, capsys):
    source, _ = file
    app(
        ["fill", str(source), "-o", str(tmp_path / "a.c3d"), "--method", "rigid_body", "--json"],
        result_action="return_value",
    )
    figures = json.loads(capsys.readouterr().out)
    assert figures["filled"] == 1 and figures["list"][0]["method"] == "rigid_body"
    words = ["fill", str(source), "-o", str(tmp_path / "b.c3d"), "--method", "linear", "--limit-mm", "2", "--report"]
    app(words, result_action="return_value")
    out = capsys.readouterr().out
    assert "open: A, frames 45–64" in out and (tmp_path / "b.html").is_file()


# A session

SETTINGS = OF_FILE + '[fill]\nmethod = "rigid_body"\n'


@pytest.fixture
def session(tmp_path):
    """Six markers of a body; for 45 frames one of them is seen by one camera alone."""
    rig, xyz = ring(6), body(130)
    detections, shown = observe(rig, xyz, noise=0.1)
    hidden = (shown == 0) & (detections.frame >= 40) & (detections.frame < 85)
    write_rig_toml(tmp_path / "rig.toml", rig)
    write_detections_csv(tmp_path / "one.csv", detections.keep(~hidden | (detections.camera == 1)))
    (tmp_path / "session.toml").write_text(SETTINGS)
    return tmp_path, rig, xyz


def filled_of(result):
    """The trajectory that has filled samples."""
    (path,) = [path for path in result.trajectories if (path.origin == Origin.FILLED).any()]
    return path


def test_a_session_fills_its_gaps_with_the_help_of_single_cameras(session):
    folder, rig, xyz = session
    result = Session.open(folder).run()["one"]
    path = filled_of(result)
    filled = np.flatnonzero(path.origin == Origin.FILLED)
    assert len(filled) > 20 and filled.min() >= 40 and filled.max() < 85
    off = path.xyz[filled] - xyz[0, filled]
    assert np.linalg.norm(off, axis=1).max() < 3
    assert (path.cameras[filled] == 2).mean() > 0.8
    ray = (rig[1].centre - xyz[0, filled]) / np.linalg.norm(rig[1].centre - xyz[0, filled], axis=1, keepdims=True)
    sd_along = np.sqrt(np.einsum("ni,nij,nj->n", ray, path.cov[filled], ray))
    assert (np.sqrt(np.trace(path.cov[filled], axis1=1, axis2=2)) < 2.5 * sd_along + 0.5).all()
    figures = json.loads((folder / "results/one/quality.json").read_text())
    check_quality(figures)
    assert figures["filling"]["filled"] == 1 and "gaps.html" in (folder / "results/one/report.html").read_text()
    assert "<svg" in (folder / "results/one/gaps.html").read_text()
    assert (read_c3d(folder / "results/one/one.c3d").trajectories[path.name].origin[filled] == Origin.FILLED).all()


def test_a_session_that_is_run_again_fills_only_what_changed(session):
    folder, _, _ = session
    first = Session.open(folder).run()["one"]
    again = Session.open(folder).run()["one"]
    assert "fill" in first.computed and again.computed == ()
    assert same(first.trajectories, again.trajectories)
    closed = Session.open(folder, overrides=["fill.limit_mm=0.001"]).run()["one"]
    assert (
        closed.computed == ("fill", "quality", "write")
        and "stayed open" in (folder / "results/one/gaps.html").read_text()
    )
    without = Session.open(folder, overrides=["fill.rays=false"]).run(to="fill")["one"]
    assert not filled_of(without).cameras[filled_of(without).origin == Origin.FILLED].any()


def test_settings_of_filling_are_checked(session):
    folder, _, _ = session
    for text, said in (("fill.method=rigid", "did you mean 'rigid_body'"), ("fill.limit_mm=-1", "limit_mm"),
                       ("fill.limits=3", "not a parameter")):  # fmt: skip
        with pytest.raises(KinemarkError, match=said):
            Session.open(folder, overrides=[text])


def test_of_many_what_cannot_be_filled_is_named_once(file, tmp_path, capsys):
    source, _ = file
    (tmp_path / "torn.c3d").write_bytes(source.read_bytes()[:300])
    with pytest.raises(SystemExit):
        app(["fill", str(source), str(tmp_path / "torn.c3d"), "-o", str(tmp_path / "out"), "--method", "linear"])
    out, said = capsys.readouterr()
    assert "torn.c3d" not in out
    assert said.count("torn.c3d") == 1
    assert out.splitlines()[-1] == "2 files: 1 had gaps, 0 of 1 gaps filled; 1 could not be used."
    with pytest.raises(KinemarkError, match=r"is a folder.*Name the files in it"):
        fill_file(tmp_path, tmp_path / "out.c3d", method=Linear(), name="linear")


# Real gaps


def test_the_gaps_of_an_arm_lifting_a_box(tmp_path):
    source = shared_data("mocap3d/arm_box_lift_gaps/Vicon.c3d")
    done = fill_file(source, tmp_path / "out.c3d", method=RigidBody(), name="rigid_body", report=tmp_path / "out.html")
    assert done.figures["gaps"] == 34 and done.figures["filled"] + done.figures["open"] == 34
    before, after = read_c3d(source), read_c3d(tmp_path / "out.c3d")
    assert all(same(a, b) for a, b in zip(before.analog, after.analog, strict=True))
    assert len(before.trajectories) == len(after.trajectories) == 51
    assert all(gap["state"] != "filled" for gap in done.figures["list"] if not gap["method"])
