"""Sessions whose trials are tables of 2D points."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError
from kinemark.data.masks import Masks
from kinemark.engine.recordings import size_of_cameras
from kinemark.engine.session import Session
from kinemark.geometry import project
from kinemark.io.c3d import read_c3d
from kinemark.io.detections_csv import read_long, write_detections_csv
from kinemark.io.masks_toml import write_masks
from kinemark.io.rig_toml import write_rig_toml
from kinemark.synth.score import score
from support.findings import found
from support.laboratory import observe, ring
from support.motions import dance
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


def lamps_in_the_dance(path, more=""):
    """A session of eight dancing points before two lamps; the truth of the points, and the rig."""
    rig, moving = ring(5), dance(n=8, frames=120, seed=41)
    still = np.repeat(np.array([[[-900.0, 700, 2100]], [[800, -950, 1900]]]), 120, axis=1)
    seen, _ = observe(rig, np.concatenate([moving, still]), noise=0.2, cov=False)
    write_detections_csv(path / "one.csv", seen)
    write_rig_toml(path / "rig.toml", rig)
    (path / "session.toml").write_text(
        'name = "lamps"\nrate_hz = 100.0\n[calibration]\nfile = "rig.toml"\n'
        f'[[trials]]\nname = "one"\ndetections = "one.csv"\n{more}'
    )
    lamps = tuple(tuple(square(uv) for uv in project(camera, still[:, 0])) for camera in rig)
    write_masks(path / "masks.toml", Masks(rig.names, [camera.size for camera in rig], lamps))
    return Session.open(path), moving


def square(uv):
    """A polygon of 12 px about a place."""
    return uv + 6 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def test_lamps_are_told_from_markers_by_their_rest(tmp_path):
    session, moving = lamps_in_the_dance(tmp_path)
    result = session.run()["one"]
    quality = json.loads((result.folder / "quality.json").read_text("utf-8"))
    (still,) = found(quality, "tracks_still")
    of = {one["name"]: one["travel_mm"] for one in quality["trajectories"]["markers"]}
    assert still.severity == "info" and len(still.markers) == 2 and len(of) == len(moving) + 2
    assert max(of[name] for name in still.markers) < 0.5 and sorted(of.values())[2] > 100


def test_masks_hold_for_tables_too(tmp_path):
    session, moving = lamps_in_the_dance(tmp_path, '[masks]\nfile = "masks.toml"\n')
    result = session.run()["one"]
    assert len(read_c3d(result.folder / "one.c3d").trajectories) == len(moving)
    quality = json.loads((result.folder / "quality.json").read_text("utf-8"))
    assert not found(quality, "tracks_still")
    assert all(camera["invalid"]["masked"] > 100 for camera in quality["cameras"])


def test_a_mask_of_a_camera_that_is_not_there_is_an_error(tmp_path):
    session, _ = lamps_in_the_dance(tmp_path, '[masks]\nfile = "masks.toml"\n')
    text = (tmp_path / "masks.toml").read_text()
    (tmp_path / "masks.toml").write_text(text.replace('"c3"', '"c7"'))
    with pytest.raises(KinemarkError, match="masks of c7"):
        session.run()


def test_cameras_of_different_sizes_are_stated_by_name(tmp_path):
    folder, _, _ = folder_of(tmp_path, 3)
    text = (folder / "session.toml").read_text()
    head = '[cameras]\nnames = ["c0", "c1", "c2"]\nsize_px = { c2 = [640, 480], c0 = [4096, 2160], c1 = [640, 480] }\n'
    (folder / "session.toml").write_text(text.replace("[calibration]", f"{head}[calibration]"))
    settings = Session.open(folder).settings
    assert size_of_cameras(folder, settings, ("c0", "c2")).tolist() == [[4096, 2160], [640, 480]]
    with pytest.raises(KinemarkError, match="lacks c3"):
        size_of_cameras(folder, settings, ("c1", "c3"))


@pytest.mark.parametrize(("mark", "decimal"), [(";", ","), (";", "."), ("\t", ",")])
def test_tables_of_spreadsheets_that_write_decimal_commas_are_read(tmp_path, mark, decimal):
    cells = [
        ["camera", "frame", "u_px", "v_px", "marker"],
        ["c,1", "0", "1.25", "-2.5", "a,b"],
        ["c2", "3", "7", "8.5", ""],
    ]
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    with plain.open("w", newline="") as file:
        csv.writer(file).writerows(cells)
    rows = [[c if c in ("c,1", "a,b") else c.replace(".", decimal) for c in row] for row in cells]
    other.write_text("\ufeff" + "\r\n".join(mark.join(row) for row in rows) + "\r\n;\r\n".replace(";", mark * 4))
    a, b = (read_long(path, rate=50.0) for path in (plain, other))
    np.testing.assert_array_equal(a.detections.uv, b.detections.uv)
    assert (a.names, a.detections.cameras) == (b.names, b.detections.cameras) == (("a,b",), ("c,1", "c2"))
