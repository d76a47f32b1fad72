"""A session names its markers: by templates, by earlier trials in a fixed order, by statements, or as it is told."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, Origin
from kinemark.engine.editing.editing import Editing
from kinemark.engine.naming.template_files import load_template
from kinemark.engine.session import Session
from kinemark.io.c3d import read_c3d
from kinemark.io.records import save
from kinemark.synth import observe
from support.findings import kinds
from support.named_sessions import RIG, motion, session_of, share_right, walk
from support.schema import check_quality


def labels(folder, name):
    return json.loads((folder / "results" / name / "labels.json").read_text())


def run(folder, *names, to="label"):
    return Session.open(folder).run(names, to=to)


def test_names_stand_in_every_file_of_a_session(tmp_path):
    folder = session_of(tmp_path, "walk01", more="[fill]\n")
    trial = run(folder, to="write")["walk01"]
    truth = motion("walk01")
    assert set(truth.names) <= set(trial.trajectories.names)
    assert share_right(trial.trajectories, truth) == 1.0
    written = read_c3d(folder / "results/walk01/walk01.c3d").trajectories
    assert written.names == trial.trajectories.names
    figures = trial.quality
    check_quality(figures)
    assert {one["name"] for one in figures["labels"]["markers"] if one["state"] == "sure"} == set(truth.names)
    assert "unnamed_trajectories" not in kinds(figures)
    assert ">Names<" in (folder / "results/walk01/report.html").read_text()
    assert "15 of 15" in (folder / "results/index.html").read_text()
    assert set(load_template(folder / "results/subject.template.h5").template.names) == set(truth.names)
    assert Session.open(folder).run(to="write")["walk01"].computed == ()
    (folder / "earlier.c3d").write_bytes((folder / "earlier.c3d").read_bytes() + b"\0" * 512)
    assert "label" in Session.open(folder).run(to="write")["walk01"].computed


def test_what_a_trial_is_called_does_not_depend_on_what_was_run_when(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    trials = ("walk01", "walk02", "stand")
    all_at_once, one = (session_of(tmp_path / x, *trials, first=("stand",)) for x in "ab")
    run(all_at_once)
    run(one, "walk02")
    assert labels(all_at_once, "walk02") == labels(one, "walk02")
    assert labels(one, "walk02")["figures"]["sources"] == ["earlier.c3d", "walk01"]
    assert labels(one, "walk01")["figures"]["sources"] == ["earlier.c3d"]
    before = [(all_at_once / "results" / name / "named.h5").read_bytes() for name in trials]
    run(all_at_once, "stand")
    assert [(all_at_once / "results" / name / "named.h5").read_bytes() for name in trials] == before


def test_without_growing_only_trials_that_are_declared_help(tmp_path):
    label = 'template = ["earlier.c3d"]\ngrow = false'
    folder = session_of(tmp_path, "walk01", "walk02", label=label)
    run(folder, "walk02")
    assert not (folder / "results/walk01").exists()


def test_names_stated_by_hand_are_facts_and_name_the_other_trials(tmp_path):
    truth = motion("walk02")
    places = zip(truth.names, truth.xyz[:, 5].tolist(), strict=True)
    rows = [f"walk02,6,{x},{y},{z},{name}" for name, (x, y, z) in places]
    (tmp_path / "names.csv").write_text("\n".join(["trial,frame,x_mm,y_mm,z_mm,name", *rows, "walk02,6,0,0,9000,XX"]))
    folder = session_of(tmp_path, "walk01", "walk02", label='names = "names.csv"', first=("walk02",))
    done = run(folder)
    assert set(truth.names) <= set(done["walk02"].trajectories.names)
    assert share_right(done["walk02"].trajectories, truth) == 1.0
    assert [one["kind"] for one in labels(folder, "walk02")["findings"]] == ["stated_names_lost"]
    assert labels(folder, "walk01")["figures"]["sources"] == ["walk02"]
    assert set(truth.names) <= set(done["walk01"].trajectories.names)
    assert share_right(done["walk01"].trajectories, motion("walk01")) == 1.0


def test_a_statement_goes_before_the_template(tmp_path):
    x, y, z = motion("walk01").xyz[motion("walk01").names.index("LKNE"), 9]
    (tmp_path / "names.csv").write_text(f"trial,frame,x_mm,y_mm,z_mm,name\nwalk01,10,{x},{y},{z},WAND\n")
    folder = session_of(tmp_path, "walk01", label='template = ["earlier.c3d"]\nnames = "names.csv"')
    done = run(folder)["walk01"].trajectories
    assert np.linalg.norm(done["WAND"].xyz[9] - (x, y, z)) < 5
    assert "LKNE" not in done.names


def test_a_claim_in_the_journal_is_a_fact_for_the_names_until_it_is_undone(tmp_path):
    folder = session_of(tmp_path, "walk01", label='template = ["earlier.c3d"]')
    trial = run(folder, to="quality")["walk01"]
    before = trial.trajectories
    assert labels(folder, "walk01")["figures"]["claimed"] == 0
    Editing.of_trial(trial).claim("LKNE", "WAND")
    again = run(folder, to="quality")["walk01"]
    assert {"label", "edit"} <= set(again.computed) and "track" not in again.computed
    figures = labels(folder, "walk01")["figures"]
    assert figures["claimed"] == 1 and {"WAND"} < {one["name"] for one in figures["markers"]}
    assert "LKNE" not in again.trajectories.names
    np.testing.assert_array_equal(again.trajectories["WAND"].xyz, before["LKNE"].xyz)
    editing = Editing.of_trial(again)
    assert [one.outcome for one in editing.edited().applied] == ["held"] and not editing.outdated
    check_quality(again.quality)
    editing.journal.undo()
    assert editing.outdated  # its names are still by the claim
    back = run(folder, to="quality")["walk01"]
    assert back.trajectories.names == before.names and labels(folder, "walk01")["figures"]["claimed"] == 0


def test_a_claim_that_confirms_a_name_holds_as_it_does_when_the_trial_is_named_again(tmp_path):
    """Without it another template may call the track otherwise: it is no idle word, though no sample changes by it."""
    trial = run(session_of(tmp_path, "walk01", label='template = ["earlier.c3d"]'), to="label")["walk01"]
    assert [one.outcome for one in Editing.of_trial(trial).claim("LKNE", "LKNE").applied] == ["held"]


def test_a_claim_of_some_frames_names_its_piece_and_the_rest_of_the_track_stays_what_it_is(tmp_path):
    folder = session_of(tmp_path, "walk01", label='template = ["earlier.c3d"]')
    trial = run(folder)["walk01"]
    Editing.of_trial(trial).claim("LKNE", None, first=10, last=20)
    again = run(folder, to="edit")["walk01"]
    left = np.isfinite(again.trajectories["LKNE"].xyz[:, 0])
    assert not left[9:20].any() and left[20:].all() and left[:9].all()


def test_a_trial_that_nothing_names_says_so_and_is_else_the_same(tmp_path):
    folder = session_of(tmp_path, "walk01", label="")
    trial = run(folder, to="quality")["walk01"]
    assert "labels_without_template" in kinds(trial.quality)
    assert trial.trajectories.names == tuple(f"*{k + 1}" for k in range(len(trial.trajectories)))
    file = folder / "session.toml"
    file.write_text(file.read_text().replace("[label]\n", ""))
    plain = run(folder, to="track")["walk01"]
    assert (plain.tracks.id == trial.tracks.id).all()


@pytest.mark.parametrize("by", ["claims", "file"])
def test_whichever_trial_is_named_by_hand_names_the_others(tmp_path, by):
    """Nothing else names them: no template, no static trial, and the one that is named is not the first."""
    folder = session_of(tmp_path, "walk01", "walk02", label='names = "names.csv"' if by == "file" else "")
    (folder / "names.csv").write_text("trial,frame,x_mm,y_mm,z_mm,name\n")
    last = run(folder, to="quality")["walk02"]
    assert "labels_without_template" in kinds(last.quality)
    assert "unnamed_trajectories" not in kinds(last.quality)
    truth = motion("walk02")
    if by == "file":
        rows = [
            f"walk02,20,{x:.1f},{y:.1f},{z:.1f},{n}" for n, (x, y, z) in zip(truth.names, truth.xyz[:, 19], strict=True)
        ]
        (folder / "names.csv").write_text("\n".join(["trial,frame,x_mm,y_mm,z_mm,name", *rows]))
    else:
        for path in reversed(last.trajectories.paths):
            own = truth.names[int(np.nanmedian(np.linalg.norm(path.xyz - truth.xyz, axis=2), axis=1).argmin())]
            Editing.of_trial(last).claim(path.name, own)
    first = run(folder)["walk01"]
    assert set(first.trajectories.names) == set(truth.names)
    assert share_right(first.trajectories, motion("walk01")) == 1.0


@pytest.mark.parametrize("kind", ["range_of_motion", "static", "motion"])
def test_naming_that_has_only_begun_stops_no_trial(tmp_path, kind):
    """Three names make no template: the other trials stay without names, and are else as they were."""
    truth = motion("walk01")
    rows = [
        f"walk01,20,{x:.1f},{y:.1f},{z:.1f},{n}" for n, (x, y, z) in zip(truth.names, truth.xyz[:, 19], strict=True)
    ]
    (tmp_path / "names.csv").write_text("\n".join(["trial,frame,x_mm,y_mm,z_mm,name", *rows[3:6]]))
    folder = session_of(tmp_path, "walk01", "walk02", label='names = "names.csv"')
    file = folder / "session.toml"
    file.write_text(file.read_text().replace('"motion"', f'"{kind}"', 1))
    done = run(folder, to="quality")
    assert set(truth.names[3:6]) <= set(done["walk01"].trajectories.names)
    assert "labels_without_template" in kinds(done["walk02"].quality)
    assert len(done["walk02"].trajectories) == 15


def test_a_template_of_another_size_needs_both_heights(tmp_path):
    folder = session_of(tmp_path, "walk01", label="template_height_mm = 1700")
    with pytest.raises(KinemarkError, match=r"template_height_mm is given without height_mm"):
        Session.open(folder)


def test_a_trial_that_cannot_be_read_names_nobody_and_stops_nobody(tmp_path):
    folder = session_of(tmp_path, "walk01", "walk02")
    (folder / "walk01.h5").write_bytes(b"nothing")
    run(folder, "walk02")
    assert labels(folder, "walk02")["figures"]["sources"] == ["earlier.c3d"]


MODEL = """
name = "left shank"
[[segment]]
name = "pelvis"
first = { axis = "y", vector = ["RASI", "LASI"] }
second = { axis = "x", vector = ["SACR", "LASI"] }
[[segment]]
name = "shank"
first = { axis = "z", vector = ["LANK", "LKNE"] }
second = { axis = "y", vector = ["LANK", "LTIB"] }
[[joint]]
name = "leg"
parent = "pelvis"
child = "shank"
sequence = "yxz"
angles = [{}, {}, {}]
"""


def test_joint_angles_follow_at_the_end_or_it_is_said_why_not(tmp_path):
    (tmp_path / "leg.toml").write_text(MODEL)
    folder = session_of(tmp_path, "walk01", more='[fill]\n[angles]\nmodel = "leg.toml"\nmarker_sd_mm = 0.5\n')
    trial = run(folder, to="quality")["walk01"]
    figures = json.loads((folder / "results/walk01/angles/angles.json").read_text())
    assert {joint["name"] for joint in figures["joints"]} == {"leg"}
    assert (folder / "results/walk01/angles/angles.html").is_file()
    assert "angles_not_computed" not in kinds(trial.quality)
    (tmp_path / "leg.toml").write_text(MODEL.replace("LTIB", "LMED"))
    changed = run(folder, to="quality")["walk01"]
    assert changed.computed == ("angles", "quality")
    assert "angles_not_computed" in kinds(changed.quality)
    assert not (folder / "results/walk01/angles/angles.html").exists()


def test_a_marker_that_the_trial_never_shows_is_placed_from_the_static_trial(tmp_path):
    folder = session_of(tmp_path, "stand", label='template = ["earlier.c3d"]\nunsure = true', first=("stand",))
    walk01 = motion("walk01")
    away = replace(walk01, xyz=np.where(np.array(walk01.names)[:, None, None] == "LTIB", np.nan, walk01.xyz))
    save(folder / "walk01.h5", observe(RIG, away, noise_px=0.1, seed=4).detections)
    with (folder / "session.toml").open("a") as file:
        file.write('[[trials]]\nname = "walk01"\ndetections = "walk01.h5"\n[fill]\nlimit_mm = 300\n')
    trial = run(folder, "walk01", to="quality")["walk01"]
    placed = trial.trajectories["LTIB"]
    off = np.linalg.norm(placed.xyz - walk01.xyz[walk01.names.index("LTIB")], axis=1)
    assert (placed.origin[np.isfinite(off)] == Origin.FILLED).all()
    (gap,) = (gap for gap in trial.quality["filling"]["list"] if gap["marker"] == "LTIB")
    assert np.nanmean(off) < 2 * gap["expected_mm"]
    assert trial.quality["filling"]["by_method"]["static"] == 1


def test_names_of_the_recording_are_kept_and_name_other_trials(tmp_path):
    folder = session_of(tmp_path, "walk01", label="")
    seen = observe(RIG, walk(9), noise_px=0.1, least_visible=0.3, seed=4)
    rows, cameras = seen.detections, RIG.names
    lines = ["frame,camera,u,v,marker"]
    for k, marker in enumerate(seen.marker.tolist()):
        u, v = rows.uv[k]
        lines.append(f"{rows.frame[k]},{cameras[rows.camera[k]]},{u},{v},{walk(9).names[marker]}")
    (folder / "named.csv").write_text("\n".join(lines) + "\n")
    with (folder / "session.toml").open("a") as file:
        file.write('[[trials]]\nname = "named"\ndetections = "named.csv"\nkind = "range_of_motion"\n')
    file = folder / "session.toml"
    file.write_text(file.read_text().replace('name = "named"\nmarker', 'rate_hz = 50.0\nname = "named"\nmarker'))
    done = run(folder)
    assert set(done["named"].trajectories.names) == set(walk(9).names)
    assert labels(folder, "walk01")["figures"]["sources"] == ["named"]
    assert share_right(done["walk01"].trajectories, motion("walk01")) == 1.0
