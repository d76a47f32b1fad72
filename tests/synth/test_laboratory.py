"""A session folder holds what the architecture says, is whole, and gives the truth back."""

import csv
import tomllib

import numpy as np
import pytest

from kinemark.data import KinemarkError, same
from kinemark.geometry import project
from kinemark.io.rods_toml import read_rods
from kinemark.synth import arm, calibration_box, control_frame, look_at, render, ring, truth, walking, write_session
from kinemark.synth.optics import Optics

QUIET = Optics(read_noise=0.0)


def write_frames(path, frames, rate):
    images = np.array(list(frames))
    with path.open("wb") as file:
        np.savez_compressed(file, images=images, rate=rate)


def write_image(path, image):
    with path.open("wb") as file:
        np.save(file, image)


def session(folder, subject, rig, **options):
    return write_session(folder, subject, rig, write_frames=write_frames, write_image=write_image, **options)


@pytest.fixture
def rig():
    return ring(2, size=(320, 256), focal_px=320.0)


def test_session_names_its_files(tmp_path, rig):
    subject = walking(duration_s=0.06)
    told = []
    path = session(tmp_path / "s", subject, rig, optics=QUIET, progress=lambda done, of: told.append((done, of)))
    text = tomllib.loads(path.read_text())
    assert text["rate_hz"] == 50.0 and text["cameras"] == {"names": ["cam1", "cam2"], "interlaced": False}
    assert text["volume_mm"] == [[0, 0, 0], [2400, 1400, 2000]]
    frame, trial = text["calibration"]["control_frame"], text["trials"][0]
    for c, camera in enumerate(rig):
        image = np.load(path.parent / frame["images"].format(camera=camera.name))
        assert image.shape == (256, 320) and image.max() > 100
        film = np.load(path.parent / trial["images"].format(camera=camera.name))
        assert film["rate"] == 50.0
        expected = render(camera, subject.xyz[:, 2], 12.5, capsules=subject.capsules, frame=2, optics=QUIET)
        assert np.array_equal(film["images"][2], expected)
        assert expected.max() > 100 and told[c] == (c + 1, 2)
    assert same(read_rods(path.parent / frame["rods"]), control_frame())


def test_truth_is_complete(tmp_path, rig):
    subject = arm(duration_s=0.06)
    folder = session(tmp_path / "s", subject, rig, optics=QUIET).parent
    held = np.load(folder / "truth.npz", allow_pickle=False)
    sight = truth(rig, subject)
    assert tuple(held["names"]) == subject.names and np.array_equal(held["xyz"], subject.xyz)
    assert np.array_equal(held["uv"], sight.uv) and np.array_equal(held["visible"], sight.visible)
    assert np.array_equal(held["angles_deg"], subject.angles.deg)
    P = held["K"] @ np.concatenate([held["R"], held["t"][..., None]], -1)
    assert np.array_equal(P, rig.P)


def test_control_points_are_pointed_at(tmp_path):
    rig = ring(2, radius=2000.0, target=(500, 500, 500), focal_px=500.0, size=(640, 480), sweep_deg=90)
    box = calibration_box()
    path = session(tmp_path / "s", arm(duration_s=0.02), rig, target=box, optics=QUIET)
    way = tomllib.loads(path.read_text())["calibration"]["control_points"]
    with (path.parent / way["points"]).open() as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == list(box.names)
    xyz = np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in rows])
    assert np.array_equal(xyz, box.xyz[:, 0])
    for camera in rig:
        uv = np.array([[float(row[f"{camera.name}_{axis}_px"] or "nan") for axis in "uv"] for row in rows])
        off = uv - project(camera, xyz)
        assert np.isfinite(off).all() and np.abs(off).max() <= 0.5


def test_what_a_camera_does_not_see_is_an_empty_cell(tmp_path):
    away = type(ring(1))((look_at("back", (500, -2000, 500), (500, -4000, 500)),))
    path = session(tmp_path / "s", arm(duration_s=0.02), away, target=calibration_box(), optics=QUIET)
    lines = (path.parent / "points.csv").read_text().splitlines()
    assert lines[0] == "name,x_mm,y_mm,z_mm,back_u_px,back_v_px"
    assert all(line.endswith(",,") for line in lines[1:])


def test_interlaced_films_have_half_the_images(tmp_path, rig):
    path = session(tmp_path / "s", walking(duration_s=0.08), rig, interlaced=True, optics=QUIET)
    assert tomllib.loads(path.read_text())["cameras"]["interlaced"] is True
    film = np.load(path.parent / "walk01/cam1.mkv")
    assert film["rate"] == 25.0 and len(film["images"]) == 2


def test_same_seed_same_session(tmp_path, rig):
    def pixels(name, seed):
        folder = session(tmp_path / name, walking(duration_s=0.04), rig, seed=seed).parent
        return np.load(folder / "walk01/cam2.mkv")["images"], np.load(folder / "calib/cam2.png")

    one, two, three = pixels("a", 1), pixels("b", 1), pixels("c", 2)
    for k in range(2):
        assert np.array_equal(one[k], two[k]) and not np.array_equal(one[k], three[k])


def test_nothing_is_overwritten_and_nothing_half_written(tmp_path, rig):
    folder = tmp_path / "s"
    folder.mkdir()
    (folder / "mine.txt").write_text("mine")
    with pytest.raises(KinemarkError, match="nothing in it is overwritten"):
        session(folder, walking(duration_s=0.02), rig)
    assert [p.name for p in folder.iterdir()] == ["mine.txt"]
    done = session(tmp_path / "t", walking(duration_s=0.02), rig, optics=QUIET).parent
    assert not list(done.rglob("*.part"))


def test_hostile_names_stay_in_their_place(tmp_path, rig):
    for trial in ("../up", "", "a/b", "calib"):
        with pytest.raises(ValueError, match="folder of its own"):
            session(tmp_path / "s", walking(duration_s=0.02), rig, trial=trial)
    path = session(tmp_path / "q", walking(duration_s=0.02), rig, name='a "quoted" \\ name', optics=QUIET)
    assert tomllib.loads(path.read_text())["name"] == 'a "quoted" \\ name'
