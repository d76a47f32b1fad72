"""A session's cameras in the studio: calibrated, judged, compared; control balls pointed at; numbers stated."""

import csv
import json
import shutil
import time
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("fastapi", reason="the studio's dependencies are absent: pip install 'kinemark[studio]'")

from kinemark.engine.session import Session
from kinemark.engine.simulate import Scene, simulate
from kinemark.geometry import project, to_dlt
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from support.studio import Studio

SMALL = {"seconds": 0.3, "size_px": (376, 292), "focal_px": 385.0, "noise": 1.0, "cameras": 3}


@pytest.fixture(scope="module")
def rods(tmp_path_factory):
    """A session that hanging rods calibrate."""
    folder = tmp_path_factory.mktemp("rods") / "session"
    simulate(folder, scene=Scene(**SMALL))
    return folder


@pytest.fixture(scope="module")
def balls(tmp_path_factory):
    """One that eight control balls calibrate, whose images nobody pointed at yet; its file, and where they are."""
    folder = tmp_path_factory.mktemp("balls") / "session"
    simulate(folder, scene=Scene(**{**SMALL, "motion": "feeding", "barrel": 0.0}))
    return folder


@pytest.fixture
def unsaid(balls, tmp_path):
    """A copy in which no ball was pointed at; and the pixels that the simulation knows, by camera and ball."""
    folder = tmp_path / "session"
    shutil.copytree(balls, folder)
    table = Session.open(folder).settings.calibration.control_points
    path = folder / table.points
    rows = list(csv.DictReader(path.read_text().splitlines()))
    known = {
        camera: {row["name"]: (float(row[f"{camera}_u_px"]), float(row[f"{camera}_v_px"])) for row in rows}
        for camera in Session.open(folder).settings.cameras.names
    }
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, ["name", "x_mm", "y_mm", "z_mm"], extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    return folder, known, path


def only(studio):
    """Address of the only session."""
    return f"/api/sessions/{studio.page.get('/api/home').json()['sessions'][0]['id']}"


def calibrated(studio):
    """Calibrated by a job of the studio's own; the job."""
    job = studio.page.post(f"{only(studio)}/calibrate").json()
    began = time.monotonic()
    while (job := studio.page.get("/api/jobs").json()[-1])["state"] == "running":
        assert time.monotonic() - began < 120
        time.sleep(0.05)
    return job


def test_cameras_are_calibrated_and_judged_in_the_words_of_the_library(rods, tmp_path):
    studio = Studio(shutil.copytree(rods, tmp_path / "own"))
    before = studio.page.get(f"{only(studio)}/cameras").json()
    assert before["calibration"] is None and before["way"] == "control_frame"
    assert studio.page.get(f"{only(studio)}/calibration").status == 404
    job = calibrated(studio)
    assert job["state"] == "done" and job["trial"] == before["id"], job["words"]
    found = studio.page.get(f"{only(studio)}/cameras").json()["calibration"]
    figures = json.loads((tmp_path / "own" / "results" / "calibration.json").read_text())
    assert found["headline"] == figures["verdict"]["headline"] and found["grade"] == figures["verdict"]["grade"]
    assert found["residual_px"] == {one["name"]: one["residual_rms_px"] for one in figures["cameras"]}
    assert np.allclose(found["map"]["sd_mm"], np.array(figures["map"]["sd_mm"], float).reshape(-1), equal_nan=True)
    assert np.array(found["map"]["lost"]["cam2"]).size == np.array(figures["map"]["lost"]["sd_mm"]).size
    assert found["current"] and studio.page.get(f"{only(studio)}/calibration").status == 200
    L = next(one for one in found["tables"] if one["title"] == "L parameters")["rows"]
    rig = read_rig_toml(tmp_path / "own" / "results" / "rig.toml")
    assert np.allclose(np.array([row[1:] for row in L], float), to_dlt(rig.P), rtol=1e-5)


def test_former_calibrations_are_compared(rods, tmp_path):
    """A camera that was turned by half a degree since is told from the others."""
    folder = shutil.copytree(rods, tmp_path / "own")
    Session.open(folder).calibrate()
    rig = read_rig_toml(folder / "results" / "rig.toml")
    a = np.radians(0.5)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    moved = replace(rig, cameras=tuple(turned(c, turn) if c.name == "cam3" else c for c in rig))
    (folder / "results" / "calibrations").mkdir()
    write_rig_toml(folder / "results" / "calibrations" / "2020-01-02T03-04-05-rig.toml", moved)
    studio = Studio(folder)
    (earlier,) = studio.page.get(f"{only(studio)}/cameras").json()["earlier"]
    assert earlier["made"] == "2020-01-02T03-04-05"
    angles = {row[0]: float(row[2]) for row in earlier["table"]["rows"]}
    assert angles["cam3"] == pytest.approx(0.5, abs=0.02) and max(angles["cam1"], angles["cam2"]) < 0.02


def turned(camera, turn):
    """A camera that is turned about its own axis through its centre."""
    R = turn @ camera.R
    return replace(camera, R=R, t=-R @ camera.centre)


def test_balls_are_pointed_at_one_taken_back_and_calibrate(unsaid):
    """Clicks beside the centre count for the ball; a wrong one is undone; the file is what the command line reads."""
    folder, known, path = unsaid
    studio, rng = Studio(folder), np.random.default_rng(2)
    address = only(studio)
    control = studio.page.get(f"{address}/control").json()
    assert [one["name"] for one in control["points"]] == list(known["cam1"])
    assert all(ball["seen"] is None for camera in control["cameras"] for ball in camera["balls"])
    assert calibrated(studio)["state"] == "failed"
    wrong = known["cam1"]["CB2"]
    say = {"point": "CB1", "u": wrong[0], "v": wrong[1]}
    said = studio.page.post(f"{address}/control/cam1", say).json()["cameras"][0]["balls"][0]
    assert said["seen"] and abs(said["u"] - wrong[0]) < 1
    said = studio.page.post(f"{address}/control/cam1", {"point": "CB1", "forget": True}).json()
    assert said["cameras"][0]["balls"][0]["seen"] is None
    for camera, places in known.items():
        for name, (u, v) in places.items():
            du, dv = rng.uniform(-2, 2, 2)
            answer = studio.page.post(f"{address}/control/{camera}", {"point": name, "u": u + du, "v": v + dv})
            assert answer.status == 200, answer.body
            ball = next(
                one for one in answer.json()["cameras"][list(known).index(camera)]["balls"] if one["point"] == name
            )
            assert np.hypot(ball["u"] - u, ball["v"] - v) < 1
    assert calibrated(studio)["state"] == "done"
    rig = read_rig_toml(folder / "results" / "rig.toml")
    rows = list(csv.DictReader(path.read_text().splitlines()))
    xyz = np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in rows])
    for camera in rig:
        assert np.abs(project(camera, xyz) - np.array(list(known[camera.name].values()))).max() < 2


def test_not_seen_is_not_the_same_as_not_asked(unsaid):
    folder, _, _ = unsaid
    studio = Studio(folder)
    answer = studio.page.post(f"{only(studio)}/control/cam2", {"point": "CB3", "seen": False}).json()
    assert [ball["seen"] for ball in answer["cameras"][1]["balls"]][2:4] == [False, None]
    again = Studio(folder)  # after a restart
    assert again.page.get(f"{only(again)}/control").json() == answer


def test_clicks_on_nothing_are_refused_and_change_nothing(unsaid):
    folder, _, path = unsaid
    studio, before = Studio(folder), path.read_bytes()
    for body in (
        {"point": "CB1", "u": 1, "v": 1}, {"point": "CB1", "u": -50, "v": 10}, {"point": "CB1", "u": 1e9, "v": 10},
        {"point": "99", "u": 10, "v": 10}, {"point": "CB1"}, {"point": "CB1", "file": "../../etc/passwd"},
        {"point": "reference marker", "file": "../session.toml"},
    ):  # fmt: skip
        answer = studio.page.post(f"{only(studio)}/control/cam1", body)
        assert answer.status == 422 and answer.json()["words"], body
    assert studio.page.post(f"{only(studio)}/control/cam9", {"point": "CB1", "seen": False}).status == 422
    assert studio.page.get(f"{only(studio)}/control/..%2Fcam1/image").status in (404, 422)
    assert path.read_bytes() == before


def test_the_reference_marker_goes_into_the_session_and_comments_stay(unsaid):
    """By a click and by a file of UM²AS; balls and marker in one pass."""
    folder, known, _ = unsaid
    file = folder / "session.toml"
    file.write_text("# who may read this: all\n" + file.read_text())
    (folder / "box.rf2").write_text("111.5\t222.25\n")
    studio = Studio(folder)
    u, v = known["cam1"]["CB5"]
    answer = studio.page.post(f"{only(studio)}/control/cam1", {"point": "reference marker", "u": u + 1, "v": v})
    assert answer.json()["reference_files"] == ["box.rf2"]
    by_file = {"point": "reference marker", "file": "box.rf2"}
    answer = studio.page.post(f"{only(studio)}/control/cam2", by_file).json()
    assert [one["reference"]["seen"] for one in answer["cameras"]] == [True, True, None]
    marks = Session.open(folder).settings.calibration.reference_marker
    assert np.hypot(marks["cam1"][0][0] - u, marks["cam1"][0][1] - v) < 1 and marks["cam2"] == ((111.5, 222.25),)
    assert file.read_text().startswith("# who may read this: all\n")
    studio.page.post(f"{only(studio)}/control/cam1", {"point": "reference marker", "forget": True})
    assert set(Session.open(folder).settings.calibration.reference_marker) == {"cam2"}


def test_the_threshold_is_tried_and_then_kept(unsaid):
    folder, _, _ = unsaid
    studio = Studio(folder)
    tried = [studio.page.get(f"{only(studio)}/control/cam1/white?threshold={level}").json() for level in (100, 254)]
    assert len(tried[0]["centroids"]) >= 8 and len(tried[1]["centroids"]) < len(tried[0]["centroids"])
    assert studio.page.post(f"{only(studio)}/threshold", {"camera": "cam1", "threshold": 77}).status == 200
    settings = Session.open(folder).settings
    assert settings.detect_cameras["cam1"].threshold == 77 and settings.detect.threshold != 77
    assert studio.page.post(f"{only(studio)}/threshold", {"camera": "cam9", "threshold": 77}).status == 422
    answer = studio.page.post(f"{only(studio)}/threshold", {"threshold": 66}).json()
    assert [camera["threshold"] for camera in answer["cameras"]] == [77, 66, 66]


def test_numbers_are_stated_and_nothing_that_the_session_would_not_understand(unsaid):
    folder, _, _ = unsaid
    studio, file = Studio(folder), folder / "session.toml"
    (number,) = [
        one for one in studio.page.get(f"{only(studio)}/cameras").json()["numbers"] if "diameter" in one["key"]
    ]
    said = studio.page.post(f"{only(studio)}/numbers", {"numbers": {number["key"]: [12.5]}}).json()
    assert said["numbers"][0]["values"] == [12.5]
    assert Session.open(folder).settings.calibration.control_points.marker_diameter_mm == 12.5
    before = file.read_bytes()
    for wrong in ({number["key"]: [1, 2]}, {"wand.lengths_mm": [500]}, {number["key"]: [-1]}, {"../x": [1]}):
        assert studio.page.post(f"{only(studio)}/numbers", {"numbers": wrong}).status == 422
    assert file.read_bytes() == before
    studio.page.post(f"{only(studio)}/numbers", {"numbers": {number["key"]: []}})
    assert Session.open(folder).settings.calibration.control_points.marker_diameter_mm is None
