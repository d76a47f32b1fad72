"""Rig files: TOML, DLT coefficients and DLTdv's points."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinemark.data import Camera, KinemarkError, Rig, same
from kinemark.io.dlt_csv import read_dlt_csv, read_dltdv_xy, read_dltdv_xyz, write_dlt_csv
from kinemark.io.rig_toml import read_rig_toml, write_rig_toml
from support.shared import shared_data

ANIPOSE = """
[cam_0]
name = "left"
size = [ 640, 480,]
matrix = [ [ 600.0, 0.0, 319.5,], [ 0.0, 610.0, 239.5,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.2, 0.1, 0.001, 0.002,]
rotation = [ 0.1, -0.2, 0.3,]
translation = [ 1.0, 2.0, 3.0,]
fisheye = false

[int_right]
matrix = [[600, 0, 319.5], [0, 610, 239.5], [0, 0, 1]]
distortions = [-0.2, 0.1, 0.001, 0.002, 0.05]
rotation = [0.0, 0.0, 0.0]
translation = [0.0, 0.0, 0.0]

[metadata]
adjusted = false
error = 0.0
"""


def random_rig(seed, n=3):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, 15, 15))
    cameras = tuple(
        Camera(
            name=['cam "1"', "kamera\n2 é", "\\3\x7f\t"][c],
            size=rng.integers(1, 4000, 2),
            K=np.array([[rng.uniform(500, 900), rng.normal(), 320], [0, -rng.uniform(500, 900), 240], [0, 0, 1]]),
            R=Rotation.random(rng=rng).as_matrix(),
            t=rng.normal(size=3) * 1000,
            distortion=rng.normal(size=5) / 10,
            cov=root[c] @ root[c].T,
            residual=[0.2, np.nan, 0.1][c],
        )
        for c in range(n)
    )
    return Rig(cameras, 'bundle "x"', rng.uniform(-1, 1, (2, 3)) if seed % 2 else np.full((2, 3), np.nan))


@pytest.mark.parametrize("seed", range(20))
def test_a_rig_comes_back_to_the_last_bit(tmp_path, seed):
    rig = random_rig(seed)
    write_rig_toml(tmp_path / "rig.toml", rig)
    assert same(read_rig_toml(tmp_path / "rig.toml"), rig)
    assert same(read_rig_toml(tmp_path / "rig.toml", "mm"), rig)


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1), ("cm", 10), ("m", 1000)])
def test_a_file_of_another_program(tmp_path, unit, factor):
    path = tmp_path / "calibration.toml"
    path.write_text(ANIPOSE)
    left, right = read_rig_toml(path, unit)
    assert (left.name, right.name) == ("left", "int_right")
    assert np.allclose(left.R, cv2.Rodrigues(np.array([0.1, -0.2, 0.3]))[0], atol=1e-12)
    assert np.array_equal(left.t, np.array([1.0, 2, 3]) * factor)
    assert left.distortion.tolist() == [-0.2, 0.1, 0.001, 0.002, 0] and right.distortion[4] == 0.05
    assert left.size.tolist() == [640, 480] and right.size.tolist() == [0, 0]


def test_a_file_without_units_asks_for_length_unit(tmp_path):
    path = tmp_path / "calibration.toml"
    path.write_text(ANIPOSE)
    with pytest.raises(KinemarkError, match=r"`length_unit` in \[calibration\]"):
        read_rig_toml(path)
    path.write_text(ANIPOSE + 'units = "m"\n')
    assert read_rig_toml(path)[0].t.tolist() == [1000, 2000, 3000]
    with pytest.raises(KinemarkError, match="units = 'm', wanted mm"):
        read_rig_toml(path, "mm")
    with pytest.raises(ValueError, match="inch"):
        read_rig_toml(path, "inch")


def test_an_edited_rotation_counts(tmp_path):
    path = tmp_path / "rig.toml"
    write_rig_toml(path, random_rig(0))
    text = path.read_text("utf-8")
    at = text.index("rotation = [")
    path.write_text(text[:at] + "rotation = [0.0, 0.0, 0.0]" + text[text.index("]", at) + 1 :], "utf-8")
    assert np.array_equal(read_rig_toml(path)[0].R, np.eye(3))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("fisheye = false", "fisheye = true", "fisheye"),
        ("0.001, 0.002,]", "0.001, 0.002, 0.0, 0.5]", "distortions"),
        ("0.001, 0.002,]", "]", "distortions"),
        ("rotation = [ 0.1, -0.2, 0.3,]\n", "", r"\[cam_0\]: rotation"),
        ("rotation = [ 0.1, -0.2, 0.3,]", "rotation = [0.1, nan, 0.3]", "not finite"),
        ("rotation = [ 0.1, -0.2, 0.3,]", "rotation = [0.1, 0.3]", "shape"),
        ("translation = [ 1.0, 2.0, 3.0,]", 'translation = "far"', "translation"),
        ("translation = [ 1.0, 2.0, 3.0,]", "translation = [[1.0], [2.0, 3.0], []]", "translation"),
        ("[ 640, 480,]", "[ 640.5, 480,]", "whole pixels"),
        ("[ 640, 480,]", "[ 640, 1e30,]", "whole pixels"),
        ("600.0, 0.0, 319.5", "0.0, 0.0, 319.5", "K must be finite"),
        ('"left"', '"int_right"', "names must differ"),
        ('"left"', '"left', "is no TOML"),
        ("matrix", "intrinsic", r"\[cam_0\]: matrix is 'absent'"),
        ("matrix = [ [ 600.0, 0.0, 319.5,], [ 0.0, 610.0, 239.5,], [ 0.0, 0.0, 1.0,],]\n", "", r"\[cam_0\]: matrix is"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, old, new, says):
    path = tmp_path / "calibration.toml"
    path.write_text(ANIPOSE.replace(old, new))
    with pytest.raises(KinemarkError, match=says):
        read_rig_toml(path, "m")


@pytest.mark.parametrize("data", [b"", b"\0", b"[" * 100000, b"x = " + b"[" * 100000, b"metadata = 3", b"\xff\xfe"])
def test_other_files_are_refused(tmp_path, data):
    path = tmp_path / "a.toml"
    path.write_bytes(data)
    for read in (lambda p: read_rig_toml(p, "m"), read_dlt_csv, read_dltdv_xy, read_dltdv_xyz):
        with pytest.raises(KinemarkError):
            read(path)


# --- DLT coefficients and digitised points ---------------------------------------------------------------------------


def test_dlt_coefficients_come_back(tmp_path):
    L = np.random.default_rng(0).normal(size=(4, 11)) * 1e3
    write_dlt_csv(tmp_path / "dlt.csv", L)
    assert np.array_equal(read_dlt_csv(tmp_path / "dlt.csv"), L)
    with pytest.raises(ValueError, match="L has shape"):
        write_dlt_csv(tmp_path / "dlt.csv", L.T)


def test_dltdv_files_agree_with_each_other():
    """Coefficients, pixels and points in space are one set: points from pixels by least squares are the stored ones."""
    folder = shared_data("cameras/dltdv_thermal_3cam")
    L = read_dlt_csv(folder / "2018-08-17_wand_dltCoefs_round4.csv")
    uv = read_dltdv_xy(folder / "DLTdv7_data_2018-08-17_P03_1000TMCxypts.csv")
    xyz = read_dltdv_xyz(folder / "DLTdv7_data_2018-08-17_P03_1000TMCxyzpts.csv")
    assert (L.shape, uv.shape, xyz.shape) == ((3, 11), (3, 1, 1500, 2), (1, 1500, 3))
    checked = 0
    for f in np.flatnonzero(np.isfinite(xyz[0]).all(1)):
        seen = np.isfinite(uv[:, 0, f]).all(1)
        rows = np.concatenate([L[seen, 4 * k : 4 * k + 3] - uv[seen, 0, f, k, None] * L[seen, 8:] for k in (0, 1)])
        right = np.concatenate([uv[seen, 0, f, k] - L[seen, 4 * k + 3] for k in (0, 1)])
        assert np.allclose(np.linalg.lstsq(rows, right)[0], xyz[0, f], atol=2e-6)
        checked += 1
    assert checked > 20


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1,2\n" * 10, "10 rows, wanted 11"),
        ("1,2\n" * 5 + "1\n" + "1,2\n" * 5, "line 6: has 1 cells, wanted 2"),
        ("1,2\n" * 5 + "1,\n" + "1,2\n" * 5, "line 6: a coefficient is missing"),
        ("1,2\n" * 5 + "1,inf\n" + "1,2\n" * 5, "line 6: a coefficient"),
        ("a,b\n" * 11, "line 1: .*a"),
    ],
)
def test_broken_coefficients_name_the_line(tmp_path, text, says):
    path = tmp_path / "dlt.csv"
    path.write_text(text)
    with pytest.raises(KinemarkError, match=says):
        read_dlt_csv(path)


def test_dltdv_points_are_put_where_their_heading_says(tmp_path):
    xy = np.arange(2 * 2 * 3 * 2.0).reshape(3, 2, 2, 2)  # frame, point, camera, axis
    heading = ",".join(f"pt{p}_cam{c}_{a}" for p in (1, 2) for c in (1, 2) for a in "XY")
    path = tmp_path / "xypts.csv"
    path.write_text(heading + "\n" + "".join(",".join(map(str, row.ravel())) + "\n" for row in xy))
    assert np.array_equal(read_dltdv_xy(path), xy.transpose(2, 1, 0, 3))
    path.write_text(heading.replace("pt2_cam1_X", "pt2_cam3_X") + "\n")
    with pytest.raises(KinemarkError, match="pt1_cam1_X"):
        read_dltdv_xy(path)
