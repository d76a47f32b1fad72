"""`[gait]` of a session: from 2D points to one gait report of its walks."""

import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Analog, ForcePlate, KinemarkError, Trial
from kinemark.data.subject_measures import SIDES, LegMeasures, SubjectMeasures
from kinemark.engine.gait.of_session import update_gait
from kinemark.engine.session import Session
from kinemark.gait import marker_points
from kinemark.io.c3d import write_c3d
from kinemark.io.records import save
from kinemark.io.rig_toml import write_rig_toml
from kinemark.io.tdf import read_tdf
from kinemark.numerics.runs import true_runs
from kinemark.synth import WalkingBody, gait_laboratory, observe
from support.named_sessions import RIG, walk
from support.shared import shared_data

GAIT = """[gait]
uncertainty = false
[gait.measures]
mass_kg = 70
[gait.measures.left]
leg_mm = 890
knee_mm = 105
ankle_mm = 72
[gait.measures.right]
leg_mm = 890
knee_mm = 105
ankle_mm = 72
"""
HIPS = 'uncertainty = false\ntissue_mm = 1\nfunctional = "swings"\nmvc = "push"'
WALKS = {"walk01": {"seed": 2, "seconds": 2.6}, "walk02": {"seed": 3, "seconds": 2.6, "phase": 0.7}}


def session(folder, gait=GAIT, more=""):
    """Two walks that an earlier trial names."""
    write_rig_toml(folder / "rig.toml", RIG)
    write_c3d(folder / "earlier.c3d", Trial("earlier", walk(1, 1100.0, 0.8, 1.0).trajectories))
    rows = []
    for name, how in WALKS.items():
        save(folder / f"{name}.h5", observe(RIG, walk(**how), noise_px=0.1, seed=4).detections)
        rows.append(f'[[trials]]\nname = "{name}"\ndetections = "{name}.h5"\n')
    text = 'name = "s"\nmarker_set = "kiss-15"\n[calibration]\nfile = "rig.toml"\n[label]\ntemplate = ["earlier.c3d"]\n'
    (folder / "session.toml").write_text(text + gait + more + "".join(rows))
    return folder


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = session(tmp_path_factory.mktemp("gait"))
    opened = Session.open(folder)
    opened.run()
    return folder, opened


def test_a_session_ends_with_one_report_of_its_walks(done):
    folder, opened = done
    figures = opened.gait
    assert [trial["name"] for trial in figures["trials"]] == ["walk01", "walk02"]
    for side in ("left", "right"):
        assert figures["time_distance"][side]["speed"]["mean"] == pytest.approx(1000, rel=0.03)
    page = (folder / "results/gait/gait.html").read_text()
    assert "Knee flexion" in page
    index = (folder / "results/index.html").read_text()
    speed = np.mean([figures["time_distance"][side]["speed"]["mean"] for side in ("left", "right")]) / 1000
    assert 'href="gait/gait.html"' in index and f"{speed:.2f} m/s" in index.replace("\u00a0", " ")
    assert (folder / "results/gait/walk02_gait.c3d").is_file()


def test_it_is_made_again_where_something_changed_and_else_not(done):
    folder, opened = done
    path = folder / "results/gait/gait.json"
    before = path.stat().st_mtime_ns
    opened.run()
    assert path.stat().st_mtime_ns == before
    text = (folder / "session.toml").read_text()
    (folder / "session.toml").write_text(
        text.replace("mass_kg = 70", "mass_kg = 60").replace("[gait]", '[gait]\ntrials = ["walk02"]')
    )
    changed = Session.open(folder)
    assert changed.run(["walk01"]).keys() == {"walk01"}
    assert changed.gait["measures"]["mass_kg"] == 60
    assert [trial["name"] for trial in changed.gait["trials"]] == ["walk02"]
    (folder / "session.toml").write_text(text)


def test_without_what_it_wants_it_says_so_and_the_trials_stand(tmp_path):
    folder = session(tmp_path, gait='[gait]\nuncertainty = false\n[gait.markers]\nLHEE = "LTOE"\n')
    opened = Session.open(folder)
    opened.run(["walk01"])
    assert "LTOE" in opened.gait["not_computed"]
    assert not (folder / "results/gait/gait.html").exists()
    assert opened.gait["not_computed"].split(".")[0] in (folder / "results/index.html").read_text().replace(
        "&#39;", "'"
    )
    assert json.loads((folder / "results/walk01/quality.json").read_text())["trajectories"]["count"] == 15


def test_plates_recorded_beside_give_moments(tmp_path):
    folder = session(tmp_path, GAIT.replace("uncertainty = false", 'uncertainty = false\ntrials = ["walk01"]'))
    subject = walk(**WALKS["walk01"])
    paths = marker_points(Trial("walk", subject.trajectories))
    feet = {side: (paths[side + "HEE"] + paths[side + "TOE"]) / 2 for side in "LR"}
    still = np.linalg.norm(np.gradient(feet["L"], axis=0), axis=1) * 50.0 < 250.0
    first, stop = max(((a, b) for a, b in true_runs(still) if a > 5 and b < len(still) - 5), key=lambda r: r[1] - r[0])
    middle = feet["L"][first:stop].mean(0) * (1, 1, 0)
    corners = middle + np.array([[300.0, -200, 0], [300, 200, 0], [-300, 200, 0], [-300, -200, 0]])
    push = np.zeros((6, len(still)))
    push[2, first:stop] = -650.0
    plate = ForcePlate(2, corners, np.array([0.0, 0.0, -40.0]), tuple("123456"))
    analog = Analog(tuple("123456"), ("N",) * 3 + ("N·mm",) * 3, 50.0, push)
    write_c3d(folder / "plates.c3d", Trial("p", subject.trajectories.select(["SACR"]), (analog,), (plate,)))
    text = (folder / "session.toml").read_text()
    (folder / "session.toml").write_text(text.replace('"walk01.h5"', '"walk01.h5"\nanalog = "plates.c3d"'))
    opened = Session.open(folder)
    opened.run(["walk01"])
    assert [c["side"] for c in opened.gait["trials"][0]["contacts"]] == ["left"]
    assert next(c for c in opened.gait["curves"] if c["name"] == "LAnkleMoment")["strides"] == 1
    (folder / "plates.c3d").unlink()
    with pytest.raises(KinemarkError, match=r"plates\.c3d"):
        opened.run(["walk01"])


def test_trials_for_hips_and_muscles_are_no_walks_and_count(tmp_path):
    leg = LegMeasures(890.0, 105.0, 72.0)
    shift = {side: np.array([8.0, 6.0, -9.0]) for side in SIDES}
    lab = gait_laboratory(WalkingBody(SubjectMeasures(leg, leg, mass_kg=70.0), hip_error_mm=shift), rate=50.0)
    strong = replace(lab.walk, analog=tuple(replace(a, values=2 * a.values) for a in lab.walk.analog), plates=())
    for name, trial in {"walk": lab.walk, "stand": lab.static, "swings": lab.functional, "push": strong}.items():
        (tmp_path / "results" / name).mkdir(parents=True)
        write_c3d(tmp_path / "results" / name / f"{name}.c3d", trial)
    rows = "".join(f'[[trials]]\nname = "{n}"\ndetections = "{n}.h5"\n' for n in ("walk", "swings", "push"))
    rows += '[[trials]]\nname = "stand"\nkind = "static"\ndetections = "stand.h5"\n'
    table = GAIT.replace(
        "uncertainty = false", 'uncertainty = false\ntissue_mm = 1\nfunctional = "swings"\nmvc = "push"'
    )
    (tmp_path / "session.toml").write_text(f'name = "s"\n[calibration]\nfile = "rig.toml"\n{table}{rows}')
    settings = Session.open(tmp_path).settings
    figures = update_gait(tmp_path, tmp_path / "results", settings, self_contained=False)
    assert [one["name"] for one in figures["trials"]] == ["walk"], figures.get("not_computed")
    told = {f["kind"]: f["values"] for f in figures["findings"]}
    assert told["gait_hips_functional"]["trial"] == "swings"
    assert told["gait_hips_functional"]["away_mm"] == pytest.approx(np.linalg.norm(shift["left"]), abs=1)
    muscle = next(one for one in figures["curves"] if one["axes"][0] == "envelope")
    assert np.nanmax(np.array(muscle["mean"], float)[:, 0]) < 55 and figures["emg_whole"] == "push.c3d"
    (tmp_path / "results/push/push.c3d").unlink()
    without = update_gait(tmp_path, tmp_path / "results", settings, self_contained=False)
    assert "'push', which was not processed" in without["not_computed"]


def test_clusters_that_the_session_names_carry_what_walks_do_not_wear(tmp_path):
    leg = LegMeasures(890.0, 105.0, 72.0)
    body = WalkingBody(
        SubjectMeasures(leg, leg, mass_kg=70.0), plated=("left thigh", "pelvis"),
        unworn=("LKNE", "LTHI", "LASI", "RASI", "SACR"),
    )  # fmt: skip
    lab = gait_laboratory(body, rate=50.0, duration_s=2.4)
    for name, trial in {"walk": lab.walk, "stand": lab.static}.items():
        (tmp_path / "results" / name).mkdir(parents=True)
        write_c3d(tmp_path / "results" / name / f"{name}.c3d", trial)
    rows = '[[trials]]\nname = "walk"\ndetections = "w.h5"\n[[trials]]\nname = "stand"\nkind = "static"\n'
    rows += 'detections = "s.h5"\n'
    table = '[gait.clusters]\nleft_thigh = ["LTH1", "LTH2", "LTH3", "LTH4"]\npelvis = ["PV1", "PV2", "PV3", "PV4"]\n'
    (tmp_path / "session.toml").write_text(f'name = "s"\n[calibration]\nfile = "rig.toml"\n{GAIT}{table}{rows}')
    figures = update_gait(tmp_path, tmp_path / "results", Session.open(tmp_path).settings, self_contained=False)
    told = {f["kind"]: f["values"] for f in figures["findings"]}
    assert told["gait_clusters"]["segments_list"] == ["left thigh", "pelvis"], figures.get("not_computed")
    knee = next(c for c in figures["curves"] if c["name"] == "LKneeAngles")
    assert np.ptp(np.array(knee["mean"], float)[:, 0]) == pytest.approx(57, abs=4)


def test_a_clinical_recording_goes_from_cameras_to_gait(tmp_path):
    file = shared_data("cameras/gait9_bts/gait9.tdf")
    reference = read_tdf(file).trajectories
    write_c3d(tmp_path / "earlier.c3d", Trial("earlier", reference.frames(600, 900)))
    (tmp_path / "session.toml").write_text(
        f'name = "s"\n[calibration]\nfile = "{file}"\n[[trials]]\nname = "walk"\ndetections = "{file}"\n'
        '[label]\ntemplate = ["earlier.c3d"]\n'
        '[gait]\nuncertainty = false\n[gait.markers]\nRHEE = "Mk19"\nLHEE = "Mk23"\n'
    )
    opened = Session.open(tmp_path)
    opened.run()
    figures = opened.gait
    for side in ("left", "right"):
        own = figures["time_distance"][side]
        assert own["speed"]["mean"] == pytest.approx(760, abs=30) and own["speed"]["strides"] >= 2
        assert own["cadence"]["mean"] == pytest.approx(101, abs=4)
    assert figures["measures"]["mass_kg"] == pytest.approx(94.5, abs=3), "one foot's impulse"
    curves = {one["name"]: one for one in figures["curves"]}
    knee = np.array(curves["RKneeAngles"]["mean"])[:, 0]
    assert 50 < knee.max() < 75 and 65 < knee.argmax() < 80
    ankle = np.array(curves["RAnkleMoment"]["mean"], float)[:, 0]
    assert 0.8 < np.nanmax(ankle) < 2.2 and 20 < np.nanargmax(ankle) < 60
    assert sum(one["axes"][0] == "envelope" for one in figures["curves"]) == 6


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[gait]\ntrials = ["walk09"]\n', "walk09"),
        ("[gait]\nplacement_mm = -1\n", "placement_mm"),
        ('[gait.clusters]\nthigh = ["A", "B", "C"]\n', "left_thigh"),
        ("[gait.measures]\nmass_kg = 70\n", "left"),
        ('[gait]\nexports = "xls"\n', "xls"),
        ("[gait.measures.left]\nleg_mm = 89\nknee_mm = 100\nankle_mm = 70\n[gait.measures.right]\nleg_mm = 890\nknee_mm"
         " = 100\nankle_mm = 70\n", "millimetres"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_when_the_file_is_read(tmp_path, text, said):
    with pytest.raises(KinemarkError, match=said):
        Session.open(session_text(tmp_path, text))


def session_text(folder, gait):
    rows = "".join(f'[[trials]]\nname = "{name}"\ndetections = "{name}.h5"\n' for name in WALKS)
    (folder / "session.toml").write_text(f'name = "s"\n[calibration]\nfile = "rig.toml"\n{gait}{rows}')
    return folder
