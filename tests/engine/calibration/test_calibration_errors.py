"""Sessions whose calibration cannot be, contradicts itself or is of something else: refused or revealed, with why."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import KinemarkError, Rig
from kinemark.engine.session import Session
from kinemark.geometry import project_all
from kinemark.io.detections_csv import write_detections_csv
from kinemark.io.images import write_png
from kinemark.synth import Optics, control_frame, write_calibration
from support.calibrations import (
    BY_POINTS,
    BY_WAND,
    HEAD,
    L_FRAME,
    NAMES,
    POINTS,
    SMALL,
    detected,
    lay_out_wand,
    points_csv,
    session,
)
from support.findings import found, kinds


def test_a_session_without_a_way_of_calibration_is_told_of_that_alone(tmp_path):
    with pytest.raises(KinemarkError) as error:
        session(tmp_path, "")
    said = str(error.value).splitlines()
    assert said[1].endswith("found none") and len(said) == 3 and "Method" not in str(error.value)


@pytest.mark.parametrize(
    ("way", "said"),
    [
        (f"{BY_POINTS}\n{BY_WAND}", "found control_points and wand"),
        ("", "found none"),
        (f"{BY_POINTS}\n{L_FRAME}", "l_frame goes with wand or single_marker, not with control_points"),
        ('file = "rig.toml"\nlinearisation = { grid = [4, 4], pitch_mm = 1, images = "a" }', "linearisation goes with"),
        ('wand = { lengths_mm = [], detections = "wand.csv" }', "lengths_mm: wants at least one in it"),
        ('wand = { lengths_mm = [-5.0], detections = "wand.csv" }', "lengths_mm #1: should be greater than 0"),
        ("wand = { lengths_mm = [500.0] }", "wants either images or detections"),
        ('single_marker = { detections = "led.csv" }', "does not tell the scale"),
        (f'{BY_WAND}\n{L_FRAME}\nworld_points = {{ points = "p.csv" }}', "found both"),
        ('wand = { length_mm = [500.0], detections = "w.csv" }', r"did you mean 'lengths_mm'"),
        (f'{BY_WAND}\n[calibrate]\nmethod = "dlt"', "'dlt' is not for a calibration by wand; there is only wand"),
        (f'{BY_POINTS}\n[calibrate]\nmethod = "wand"', "there are control_points, dlt"),
        (f"{BY_POINTS}\n[masks]\ngrow_px = 2.0", "wants file, empty or both"),
    ],
)
def test_settings_that_contradict_are_explained(tmp_path, way, said):
    with pytest.raises(KinemarkError, match=said):
        session(tmp_path, way)


def test_the_way_chooses_the_method(tmp_path):
    points_csv(tmp_path)
    names = {"": "ControlPoints", '[calibrate]\nmethod = "dlt"': "Dlt", "[calibrate]\nradial = 2": "ControlPoints"}
    for table, name in names.items():
        assert type(session(tmp_path, f"{BY_POINTS}\n{table}").settings.calibrate).__name__ == name
    assert session(tmp_path, f"{BY_POINTS}\n[calibrate]\nradial = 2").settings.calibrate.radial == 2
    assert type(session(tmp_path, BY_WAND).settings.calibrate).__name__ == "Wand"
    with pytest.raises(KinemarkError, match="'most_poses' is not a parameter of control_points"):
        session(tmp_path, f"{BY_POINTS}\n[calibrate]\nmost_poses = 20")


def test_wand_lengths_in_metres_are_called_absurd(tmp_path):
    lay_out_wand(tmp_path / "s")
    metres = BY_WAND.replace("500.0", "0.5")
    with pytest.raises(KinemarkError, match="L-frame"):
        session(tmp_path / "s", f"{metres}\n{L_FRAME}").calibrate()
    made = session(tmp_path / "s", metres, HEAD.replace("volume_mm", "# volume_mm")).calibrate()
    assert made.figures["verdict"]["grade"] == "red"
    assert "cameras_distance_implausible" in kinds(made.figures, "red")


def test_one_cameras_images_given_for_another_are_revealed(tmp_path):
    """In the calibration the cameras then stand in one place."""
    uv = project_all(SMALL, POINTS)
    uv[1] = uv[0]
    points_csv(tmp_path, uv=uv + 0.05 * np.random.default_rng(0).normal(size=uv.shape))
    made = session(tmp_path, BY_POINTS).calibrate()
    assert made.figures["verdict"]["grade"] == "red"
    assert [one.cameras for one in found(made.figures, "cameras_at_one_place")] == [("cam1", "cam2")]


CROWD = np.random.default_rng(4).uniform([300, 200, 100], [2100, 1200, 1700], (12, 1, 3)) + np.zeros((1, 30, 1))


@pytest.mark.parametrize("pair", [None, (0, 1), (1, 3)])
def test_cameras_exchanged_in_a_trial_are_named(tmp_path, pair):
    points_csv(tmp_path)
    one = session(tmp_path, BY_POINTS)
    order = list(range(4))
    if pair:
        order[pair[0]], order[pair[1]] = pair[1], pair[0]
    seen = detected(CROWD, Rig(tuple(SMALL[c] for c in order)))
    write_detections_csv(one.root / "one.csv", replace(seen, cameras=SMALL.names))
    quality = one.run(to="quality")["one"].quality
    swapped = found(quality, "cameras_swapped")
    ordered = found(quality, "cameras_put_in_order")
    if pair is None:
        assert swapped == ordered == []
    elif pair == (0, 1):
        assert swapped == [] and ordered[0].cameras == SMALL.names[:2] and quality["verdict"]["grade"] == "amber"
    else:
        cameras = swapped[0].cameras
        assert (SMALL.names[pair[0]], SMALL.names[pair[1]]) in zip(cameras[::2], cameras[1::2], strict=True)
        assert (len(cameras) > 2) == (pair == (1, 3))  # turned by half a turn, a ring of four is the same again
        assert swapped[0].values["swapped_share"] > 0.7 > swapped[0].values["as_is_share"]
        assert ordered == [] and quality["verdict"]["grade"] == "red"


def test_rows_of_points_exchanged_between_cameras_are_revealed(tmp_path):
    uv = project_all(SMALL, POINTS)
    uv[[0, 1], :8] = uv[[1, 0], :8]
    points_csv(tmp_path, uv=uv)
    with pytest.raises(KinemarkError, match="Camera cam1"):
        session(tmp_path, BY_POINTS).calibrate()


def test_one_camera_no_images_and_no_sizes_are_explained(tmp_path):
    points_csv(tmp_path)
    with pytest.raises(KinemarkError, match="1 camera, and a point in space needs two"):
        session(tmp_path, BY_POINTS, HEAD.replace(NAMES, '"cam1"')).calibrate()
    with pytest.raises(KinemarkError, match=r"Camera 'cam1' of \[cameras\] has no usable images"):
        session(tmp_path, 'wand = { lengths_mm = [500.0], images = "wand/{camera}.mkv" }').calibrate()
    with pytest.raises(KinemarkError, match=r"nowhere\.csv"):
        session(tmp_path, BY_WAND.replace("wand.csv", "nowhere.csv")).calibrate()
    lay_out_wand(tmp_path)
    with pytest.raises(KinemarkError, match="Set size_px"):
        session(tmp_path, BY_WAND, HEAD.replace("size_px", "# size_px").replace("volume_mm", "# volume_mm")).calibrate()
    with pytest.raises(KinemarkError, match=r"has cameras cam1, cam2, cam3, cam4, not cam9"):
        session(tmp_path, BY_WAND, HEAD.replace(NAMES, '"cam1", "cam9"')).calibrate()
    assert not (tmp_path / "results/rig.toml").exists()


def test_images_of_another_size_are_refused(tmp_path):
    (tmp_path / "calib").mkdir()
    write_calibration(tmp_path, SMALL, control_frame(), write_image=write_png, optics=Optics(read_noise=1.0))
    head = HEAD.replace("size_px", "# size_px")
    one = session(tmp_path, 'control_frame = { rods = "rods.toml", images = "calib/{camera}.png" }', head)
    (tmp_path / "session.toml").write_text(
        (tmp_path / "session.toml").read_text().replace('detections = "one.csv"', 'images = "one/{camera}/*.png"')
    )
    for name in SMALL.names:
        (tmp_path / "one" / name).mkdir(parents=True)
        write_png(tmp_path / "one" / name / "0.png", np.zeros((400, 640), np.uint8))
    with pytest.raises(KinemarkError, match="calibrated at 640 × 480 px and its images are 640 × 400"):
        Session.open(one.root).run()


def test_a_volume_that_no_camera_sees_is_red(tmp_path):
    points_csv(tmp_path)
    far = HEAD.replace("[[0, 0, 0], [2400, 1400, 2000]]", "[[90000, 0, 0], [92400, 1400, 2000]]")
    made = session(tmp_path, BY_POINTS, far).calibrate()
    assert made.figures["verdict"]["grade"] == "red"
    assert made.figures["precision"]["sd_95_mm"] is None
