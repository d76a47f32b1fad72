"""Placing cameras: what is looked at is in the middle, upright, and angles turn as they say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinemark.geometry import project
from kinemark.synth import VOLUME, focal_pixels, look_at, place_camera, ring

coordinate = st.floats(-5000, 5000, allow_nan=False)
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)


@given(point, point, st.floats(-180, 180))
def test_target_is_in_the_centre_whatever_the_roll(position, target, roll):
    if np.linalg.norm(position - target) < 1:
        return
    camera = look_at("c", position, target, roll_deg=roll, distortion=(-0.2, 0.1, 0.001, 0.002, 0.0))
    assert np.allclose(project(camera, target), [639.5, 511.5], atol=1e-6)
    assert np.allclose(camera.centre, position)


@given(st.floats(-180, 180), st.floats(-85, 85))
def test_world_up_is_image_up_without_roll(heading, elevation):
    h, e = np.radians([heading, elevation])
    ahead = np.array([np.cos(h) * np.cos(e), np.sin(h) * np.cos(e), np.sin(e)])
    camera = look_at("c", np.zeros(3), 1000 * ahead)
    here, above = project(camera, 1000 * ahead), project(camera, 1000 * ahead + [0, 0, 1])
    assert above[1] < here[1] and abs(above[0] - here[0]) < 1e-9


def test_zero_angles_look_along_y_with_x_to_the_right_and_z_up():
    camera = place_camera("c", (10, 20, 30), (0, 0, 0), focal_px=1000)
    uv = project(camera, np.array([[10, 1020, 30], [11, 1020, 30], [10, 1020, 31]], float))
    assert np.allclose(uv - uv[0], [[0, 0], [1, 0], [0, -1]])


@pytest.mark.parametrize(
    ("angles", "ahead", "up"),
    [((0, 0, 90), (-1, 0, 0), (0, 0, 1)), ((90, 0, 0), (0, 0, 1), (0, -1, 0)), ((0, 90, 0), (0, 1, 0), (1, 0, 0))],
    ids=["heading", "elevation", "roll"],
)
def test_each_angle_turns_as_stated(angles, ahead, up):
    camera = place_camera("c", (0, 0, 0), angles)
    assert np.allclose(camera.R[2], ahead, atol=1e-12)
    assert np.allclose(-camera.R[1], up, atol=1e-12)


@given(st.floats(-179, 179), st.floats(-89, 89), st.floats(-179, 179))
def test_angles_and_look_at_agree(heading, elevation, roll):
    camera = place_camera("c", (100, 200, 300), (elevation, roll, heading))
    again = look_at("c", (100, 200, 300), camera.centre + 900 * camera.R[2], roll_deg=roll)
    assert np.allclose(camera.P, again.P, rtol=1e-9, atol=1e-6)


def test_straight_down_has_world_y_up():
    camera = look_at("top", (0, 0, 3000), (0, 0, 0))
    assert np.allclose(-camera.R[1], [0, 1, 0])


def test_ring_sees_the_whole_volume_from_all_sides():
    rig = ring(6)
    corners = np.stack(np.meshgrid(*VOLUME.T, indexing="ij"), -1).reshape(-1, 3)
    for camera in rig:
        uv = project(camera, corners)
        assert (uv > 0).all() and (uv < camera.size - 1).all()
    assert set(np.round(rig.centres[:, 2])) == {1100, 2300}
    around = np.arctan2(*(rig.centres[:, :2] - [1200, 700]).T[::-1])
    assert np.allclose(np.diff(np.unwrap(around)), np.pi / 3)
    assert np.allclose(rig.volume, VOLUME)


def test_an_arc_ends_where_it_is_told_to():
    rig = ring(3, start_deg=0, sweep_deg=90, radius=1000, height=[500], target=(0, 0, 0))
    assert np.allclose(rig.centres, [[1000, 0, 500], [np.sqrt(5e5), np.sqrt(5e5), 500], [0, 1000, 500]])


def test_focal_length_in_pixels():
    assert focal_pixels(8.0, 5.0) == 1600.0
    with pytest.raises(ValueError, match="positive"):
        focal_pixels(8.0, 0.0)


def test_mistakes_are_named():
    with pytest.raises(ValueError, match="focal_px"):
        place_camera("c", (0, 0, 0), (0, 0, 0), focal_px=-1)
    with pytest.raises(ValueError, match="camera c"):
        look_at("c", (1, 2, 3), (1, 2, 3))
    with pytest.raises(ValueError, match="at least one"):
        ring(0)
