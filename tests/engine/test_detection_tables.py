"""Sessions whose trials are tables of 2D points."""

import json
from dataclasses import replace

import pytest

from kinemark.data import KinemarkError
from kinemark.engine.session import Session
from kinemark.io.detections_csv import write_detections_csv
from kinemark.synth.score import score
from support.findings import found
from support.sessions import POINTS, folder_of


def table_of(path, change, n_cameras=4):
    """A session whose trial is a table of changed detections."""
    folder, _, detections = folder_of(path, n_cameras)
    write_detections_csv(folder / "one.csv", change(detections))
    text = (folder / "session.toml").read_text().replace("one.h5", "one.csv")
    (folder / "session.toml").write_text("rate_hz = 100.0\n" + text)
    return Session.open(folder)


def test_a_camera_that_saw_nothing_need_not_be_in_a_table(tmp_path):
    session = table_of(tmp_path, lambda seen: seen.keep(seen.camera != 2))
    result = session.run()["one"]
    assert score(result.tracks, POINTS).recall > 0.99
    assert result.tracks.cloud.detection.shape[1] == 4
    quality = json.loads((result.folder / "quality.json").read_text("utf-8"))
    assert [one.cameras for one in found(quality, "camera_sees_nothing")] == [("c2",)]


def test_a_name_the_calibration_lacks_is_no_camera_that_saw_nothing(tmp_path):
    session = table_of(tmp_path, lambda seen: replace(seen, cameras=("c0", "c1", "left", "c3")))
    with pytest.raises(KinemarkError, match="and the calibration also c2"):
        session.run()
