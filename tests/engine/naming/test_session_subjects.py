"""Two subjects in a session: each by its own template, with its name before those of its markers everywhere."""

import json
from dataclasses import replace
from functools import cache

import pytest

from kinemark.data import KinemarkError, Trial
from kinemark.engine.naming.template_files import load_template
from kinemark.engine.session import Session
from kinemark.engine.settings import read_settings
from kinemark.io.c3d import prefixes_of, read_c3d, subject_of, write_c3d
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from kinemark.synth import combined_subjects, observe, ring, walking
from support.named_sessions import share_right
from support.schema import check_quality

RIG = ring(6, focal_px=900.0)
HEIGHT = {"A": 1730.0, "B": 1480.0}
BESIDE = {"A": 350.0, "B": 1050.0}
HEAD = 'name = "both"\nmarker_set = "kiss-15"\n[calibration]\nfile = "rig.toml"\n[label]\n'
EACH = "".join(f'[label.subjects.{s}]\ntemplate = ["{s}.c3d"]\n' for s in "AB")


@cache
def walker(s, seed, speed=1000.0, phase=0.3, seconds=0.8):
    return walking(
        duration_s=seconds, rate=50.0, seed=seed, wobble_mm=2.0, marker_radius_mm=7.0, speed_mm_s=speed, phase=phase,
        height_mm=HEIGHT[s], middle=(1200.0, BESIDE[s]),
    )  # fmt: skip


@cache
def both(phase=0.3):
    """The two side by side, out of step, with their names before the markers'."""
    pair = combined_subjects(walker("A", 2, phase=phase), walker("B", 3, phase=phase + 0.35))
    return replace(pair, names=tuple(name.replace("1 ", "A:").replace("2 ", "B:") for name in pair.names))


MOTIONS = {"walk01": both, "walk02": lambda: both(0.7), "alone": lambda: walker("B", 5)}


def session_of(folder, *names, label=EACH, top="", trials="", more=""):
    write_rig_toml(folder / "rig.toml", RIG)
    for s in "AB":
        write_c3d(folder / f"{s}.c3d", Trial(s, walker(s, 1, 1100.0, 0.8, 1.0).trajectories))
    rows = []
    for name in names:
        save(folder / f"{name}.h5", observe(RIG, MOTIONS[name](), noise_px=0.1, seed=4).detections)
        rows.append(f'[[trials]]\nname = "{name}"\ndetections = "{name}.h5"\n{trials}\n')
    (folder / "session.toml").write_text(f"{top}{HEAD}{label}{more}\n" + "".join(rows))
    return folder


def labels(folder, name):
    return json.loads((folder / "results" / name / "labels.json").read_text())["figures"]


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = session_of(tmp_path_factory.mktemp("both"), "walk01", "walk02")
    return folder, Session.open(folder).run(to="write")


def test_every_marker_has_its_own_subject_s_name(ran):
    folder, done = ran
    for name, trial in done.items():
        truth = MOTIONS[name]()
        assert set(truth.names) == {one for one in trial.trajectories.names if one[0] != "*"}
        assert share_right(trial.trajectories, truth) == 1.0
        check_quality(trial.quality)
        told = trial.quality["labels"]
        assert {one["name"] for one in told["markers"] if one["state"] == "sure"} == set(truth.names)
        assert told["subjects"] == ["A", "B"] and told["undecided"] == []
        assert "A:LKNE" in (folder / "results" / name / "report.html").read_text()
    assert done["walk01"].quality["identity"]["subject"] == "A, B"
    assert labels(folder, "walk02")["sources"] == ["A.c3d", "walk01", "B.c3d"]  # the first trial adds to both


def test_the_c3d_file_says_whose_the_markers_are(ran):
    folder, _ = ran
    written = read_c3d(folder / "results/walk01/walk01.c3d")
    assert set(both().names) <= set(written.trajectories.names)
    assert prefixes_of(written.source) == {"A": "A:", "B": "B:"} and subject_of(written.source) == "A, B"
    assert written.source.numbers("SUBJECTS", "USED").tolist() == [2.0]


def test_what_is_known_of_each_is_kept_and_names_another_session(ran, tmp_path):
    kept = {s: load_template(ran[0] / f"results/subject-{s}.template.h5") for s in "AB"}
    assert not (ran[0] / "results/subject.template.h5").exists()
    assert all(set(kept[s].template.names) == set(walker(s, 1).names) for s in "AB")
    assert kept["B"].subject == "B"
    sizes = kept["B"].template.size / kept["A"].template.size
    assert sizes == pytest.approx(HEIGHT["B"] / HEIGHT["A"], rel=0.05)
    said = "".join(f'[label.subjects.{s}]\ntemplate = ["{ran[0]}/results/subject-{s}.template.h5"]\n' for s in "AB")
    again = session_of(tmp_path, "walk02", label=said)
    assert share_right(Session.open(again).run(to="label")["walk02"].trajectories, both(0.7)) == 1.0
    assert len(labels(again, "walk02")["markers"]) == 30


def test_a_trial_of_one_of_them_has_that_one_s_names_alone(tmp_path):
    folder = session_of(tmp_path, "alone", trials='subject = "B"')
    found = Session.open(folder).run(to="label")["alone"].trajectories
    truth = walker("B", 5)
    assert {name for name in found.names if name[0] != "*"} == {f"B:{name}" for name in truth.names}
    bare = replace(found, paths=tuple(replace(path, name=path.name.removeprefix("B:")) for path in found))
    assert share_right(bare, truth) == 1.0


def test_a_trial_of_one_of_them_does_not_wait_for_the_files_of_the_others(tmp_path):
    """Who was recorded first is named before the other was."""
    folder = session_of(tmp_path, "alone", trials='subject = "B"')
    (folder / "A.c3d").unlink()
    assert Session.open(folder).run(to="label")["alone"].computed
    (folder / "B.c3d").unlink()
    with pytest.raises(KinemarkError, match=r"\[label\] names B\.c3d, which is not a file"):
        Session.open(folder).run(to="label")


def test_names_stated_with_a_subject_are_facts_by_which_the_others_are_found(tmp_path):
    """Templates of none: the statements alone name the first trial, and that the second, for each subject."""
    truth = both()
    places = zip(truth.names, truth.xyz[:, 5].tolist(), strict=True)
    rows = [f"walk01,6,{x},{y},{z},{name}" for name, (x, y, z) in places]
    (tmp_path / "names.csv").write_text("\n".join(["trial,frame,x_mm,y_mm,z_mm,name", *rows]))
    label = 'names = "names.csv"\n[label.subjects.A]\n[label.subjects.B]\n'
    folder = session_of(tmp_path, "walk01", "walk02", label=label)
    done = Session.open(folder).run(to="label")
    assert labels(folder, "walk01")["sources"] == [] and labels(folder, "walk02")["sources"] == ["walk01"]
    for name, trial in done.items():
        assert share_right(trial.trajectories, MOTIONS[name]()) == 1.0
        named = {one for one in trial.trajectories.names if one[0] != "*"}
        assert len(named) >= (30 if name == "walk01" else 24)  # the other half of a stride is not all sure


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ({"label": '[label.subjects."A:"]\n'}, "'A:' is no name of a subject"),
        ({"label": 'template = ["A.c3d"]\n[label.subjects.A]\n'}, r"give it in \[label.subjects.A\]"),
        ({"label": "".join(f"[label.subjects.S{k}]\n" for k in range(5))}, "at most 4"),
        ({"label": "[label.subjects.A]\ntemplates = []\n"}, "label_subjects.A.templates"),
        ({"label": "[label.subjects.A]\ntemplate_height_mm = 1700\n"}, "without height_mm"),
        ({"label": EACH, "trials": 'subject = "C"'}, "none of label.subjects"),
        ({"label": EACH, "top": 'subject = "Anna"\n'}, "leave it out"),
        ({"label": EACH, "more": '[angles]\nmodel = "um2as"\n'}, "of one subject"),
    ],
)
def test_what_does_not_go_with_several_subjects_is_refused(tmp_path, text, said):
    folder = session_of(tmp_path, **text)
    (folder / "session.toml").write_text(
        (folder / "session.toml").read_text() + f'[[trials]]\nname = "w"\ndetections = "w.h5"\n{text.get("trials", "")}'
    )
    with pytest.raises(KinemarkError, match=said):
        read_settings(folder / "session.toml")
