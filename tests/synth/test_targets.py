"""Calibration targets: where they are, and that a rod is known by its spacing from any side."""

import tomllib

import numpy as np
import pytest

from kinemark.geometry import project
from kinemark.synth import (
    VOLUME,
    calibration_box,
    control_frame,
    dot_grid,
    look_at,
    ring,
    rods_subject,
    rods_toml,
    stationary,
)


def cross_ratios(along):
    """(3) logarithms of the cross-ratios of each four markers in a row."""
    a, b, c, d = (along[i : i + 3] for i in range(4))
    return np.log((c - a) * (d - b) / ((d - a) * (c - b)))


def test_rods_enclose_the_volume_with_six_markers_each():
    rods = control_frame()
    assert rods.xyz.shape == (4, 6, 3)
    assert np.array_equal(rods.xyz.min((0, 1))[:2], VOLUME[0][:2])
    assert np.array_equal(rods.xyz.max((0, 1))[:2], VOLUME[1][:2])
    assert (np.diff(rods.xyz[..., 2]) < 0).all() and (rods.xyz[..., 2] > 100).all()
    assert (np.ptp(rods.xyz[..., :2], axis=1) == 0).all()  # they hang plumb


def test_every_spacing_is_unlike_the_others_either_way_up():
    z = control_frame().xyz[..., 2]
    known = np.array([cross_ratios(a) for a in z] + [cross_ratios(a[::-1]) for a in z])
    apart = np.abs(known[:, None] - known).max(-1) + 9 * np.eye(8)
    assert apart.min() > 0.29


def test_images_keep_the_cross_ratios():
    rods = control_frame()
    camera = ring(6)[2]
    for rod in rods.xyz:
        uv = project(camera, rod)
        along = (uv - uv[0]) @ (uv[-1] - uv[0])
        assert np.allclose(cross_ratios(along), cross_ratios(rod[:, 2]))


@pytest.mark.parametrize("n", [3, 4, 5, 6, 8])
def test_no_camera_of_a_ring_sees_two_markers_of_the_frame_as_one(n):
    frame = rods_subject(control_frame()).xyz[:, 0]
    for camera in ring(n):
        uv = project(camera, frame)
        apart = np.linalg.norm(uv[:, None] - uv, axis=-1) + 1e3 * np.eye(24)
        assert apart.min() > 15


def test_rods_as_toml_are_the_rods():
    rods = control_frame(marker_diameter=19.0)
    read = tomllib.loads(rods_toml(rods))
    assert read["units"] == "mm" and read["marker_diameter"] == 19.0
    assert np.array_equal([rod["markers"] for rod in read["rod"]], rods.xyz)


def test_rods_as_something_to_look_at():
    rods = control_frame()
    seen = rods_subject(rods)
    assert seen.names[6:8] == ("B1", "B2") and len(seen) == 24
    assert np.array_equal(seen.xyz[:, 0], rods.xyz.reshape(-1, 3))
    assert (seen.radius_mm == 12.5).all()


def test_frame_of_a_flat_volume_is_refused():
    with pytest.raises(ValueError, match="floor_gap"):
        control_frame([[0, 0, 0], [1000, 1000, 200]])


def test_control_balls_are_near_the_corners_of_their_box_and_not_on_planes():
    box = calibration_box(1000.0, corner=(100.0, 0.0, 50.0))
    place = (box.xyz[:, 0] - [100, 0, 50]) / 1000
    assert len(np.unique(np.round(place), axis=0)) == 8
    assert np.abs(place - np.round(place)).max() <= 0.121
    assert np.linalg.matrix_rank(place[place[:, 2] < 0.5] - place[0], tol=1e-3) == 3


def test_dots_read_in_order_from_the_top_left():
    grid = dot_grid(3, 4, pitch_mm=50.0, middle=(0, 0, 1000))
    uv = project(look_at("c", (0, -1500, 1000), (0, 0, 1000)), grid.xyz[:, 0]).reshape(3, 4, 2)
    assert (np.diff(uv[..., 0], axis=1) > 0).all() and (np.diff(uv[..., 1], axis=0) > 0).all()
    assert grid.names[:5] == ("r1c1", "r1c2", "r1c3", "r1c4", "r2c1")
    assert np.allclose(np.linalg.norm(np.diff(grid.xyz.reshape(3, 4, 3), axis=1), axis=-1), 50.0)
    with pytest.raises(ValueError, match="rows"):
        dot_grid(0, 4)


def test_stationary_points_stay():
    thing = stationary(("a", "b"), [[1, 2, 3], [4, 5, 6]], radius_mm=[5, 6], n_frames=7)
    assert thing.xyz.shape == (2, 7, 3) and np.ptp(thing.xyz, axis=1).max() == 0
