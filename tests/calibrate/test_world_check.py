"""An L-frame or surveyed points tell of a camera that was moved after the wand, and of points surveyed wrongly."""

import numpy as np
import pytest

from kinemark.calibrate.world_check import OFF_MM, images_of_resting, odd_camera, seen_within, wrong_points
from kinemark.data import Detections, KinemarkError
from kinemark.geometry import project_all, triangulate
from kinemark.geometry.camera import undistort_all
from support.calibrations import RIG, SMALL, detected

CORNER = np.array([[0.0, 0, 12.5], [800, 0, 12.5], [0, 600, 12.5]])
SURVEYED = np.array([[x, y, z] for x in (0.0, 1800) for y in (0.0, 1200) for z in (100.0, 900)])


def images(seed, noise=0.5):
    return project_all(RIG, SURVEYED) + noise * np.random.default_rng(seed).normal(size=(4, 8, 2))


@pytest.mark.parametrize("c", range(4))
def test_a_camera_that_was_moved_is_found_with_how_far(c):
    uv = images(c)
    uv[c] += [6.0, -3.0]
    odd = odd_camera(RIG, uv)
    assert odd is not None
    assert odd.camera == c
    assert odd.px == pytest.approx(np.hypot(6, 3), rel=0.2)


def test_cameras_that_stand_still_are_not_suspected():
    assert [odd_camera(RIG, images(seed)) for seed in range(40)] == [None] * 40


def test_where_only_two_cameras_see_points_none_is_named():
    uv = images(1)
    uv[2:] = np.nan
    assert odd_camera(RIG, uv) is None
    uv[1] += [3.0, 25.0]
    odd = odd_camera(RIG, uv)
    assert odd is not None
    assert odd.camera is None
    assert odd.px > 5


def test_where_two_of_four_were_moved_none_is_named():
    uv = images(2)
    uv[0] += [0.0, 30.0]
    uv[3] += [25.0, -20.0]
    odd = odd_camera(RIG, uv)
    assert odd is not None
    assert odd.camera is None


def test_images_of_what_rests_are_the_nearest_ones_in_most_frames():
    seen = detected(np.repeat(CORNER[:, None], 9, 1), noise=0.2)
    uv = images_of_resting(SMALL, seen, CORNER)
    expected = project_all(SMALL, CORNER)
    assert np.nanmax(np.abs(uv - expected)) < 0.5
    blind = seen.keep((seen.camera != 2) | (seen.frame < 4))  # in most frames it sees nothing
    assert np.isnan(images_of_resting(SMALL, blind, CORNER)[2]).all()


@pytest.mark.parametrize("i", range(8))
def test_a_point_that_was_surveyed_wrongly_is_left_out(i):
    known = SURVEYED + np.random.default_rng(i).normal(size=(8, 3))
    known[i, i % 3] += 100.0
    found = wrong_points(SURVEYED, known)
    assert np.flatnonzero(~found.kept).tolist() == [i]
    assert found.off_mm[i] == pytest.approx(100, abs=8)
    assert found.rms_mm < 3


def test_two_points_of_exchanged_names_are_told_but_not_guessed():
    known = SURVEYED.copy()
    known[[2, 3]] = known[[3, 2]]
    found = wrong_points(SURVEYED, known)
    assert found.kept.all()
    assert found.rms_mm > 100


def test_points_surveyed_with_care_all_stay():
    """To 1 mm an axis, in any number from three, with the scale free or not; three or four are never left out."""
    rng = np.random.default_rng(0)
    for n in range(3, 9):
        for scale in (False, True) if n > 3 else (False,):
            found = wrong_points(SURVEYED[:n], SURVEYED[:n] + rng.normal(size=(n, 3)), scale=scale)
            assert found.kept.all()
            assert found.rms_mm < OFF_MM
    with pytest.raises(KinemarkError, match="do not fix a world"):
        wrong_points(SURVEYED[:2], SURVEYED[:2])


@pytest.mark.parametrize("others", [0, 1])
def test_a_camera_that_alone_sees_a_point_says_nothing(others):
    """Nothing it sees can be compared, and nobody is off by nan px."""
    uv = images(3)
    uv[2], uv[:, 7], uv[3, :, 0] = np.nan, np.nan, np.nan if others else uv[3, :, 0]
    uv[2, 7] = [600.0, 500.0]
    assert odd_camera(RIG, uv) is None


def with_reflections(rng, hidden, shift):
    """An L-frame that these cameras see six reflections of the room in place of, the others beside; one is moved."""
    rows, counts = [], np.zeros((len(RIG), 9), np.int64)
    for c, where in enumerate(project_all(RIG, CORNER)):
        lights = rng.uniform(0.0, RIG[c].size, (6, 2))
        there = lights if c in hidden else np.concatenate([where + shift.get(c, 0.0), lights])
        rows += [there + 0.2 * rng.normal(size=there.shape) for _ in range(9)]
        counts[c] = len(there)
    return Detections.build(RIG.names, 50.0, counts, np.concatenate(rows))


def test_reflections_where_the_l_frame_is_hidden_are_no_l_frame_elsewhere():
    suspected, found = 0, 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        blind = with_reflections(rng, (1, 2), {})
        suspected += odd_camera(RIG, images_of_resting(RIG, blind, CORNER)) is not None
        moved = odd_camera(RIG, images_of_resting(RIG, with_reflections(rng, (), {3: [9.0, -6.0]}), CORNER))
        found += moved is not None and moved.camera == 3
    assert suspected <= 1
    assert found >= 28


@pytest.mark.parametrize("size", [1.0, 5.0, 20.0])
def test_a_wide_field_is_surveyed_and_seen_less_well(size):
    """The same scene, up to 40 m wide: half a pixel is a hundred times as far, and a survey as exact as it is long."""
    rng = np.random.default_rng(0)
    for seed in range(10):
        uv = images(seed)
        seen = triangulate(undistort_all(RIG, uv.transpose(1, 0, 2)), RIG.P)
        within = seen_within(RIG, seen, uv)
        assert 0.5 < within * np.sqrt(len(seen)) / np.linalg.norm(seen - SURVEYED) < 2
        known = size * (SURVEYED + rng.normal(size=SURVEYED.shape))
        checked = wrong_points(size * seen, known, within=size * within)
        assert checked.kept.all()
        assert checked.rms_mm <= checked.limit_mm
        known[3, 1] += 200.0 * size
        assert np.flatnonzero(~wrong_points(size * seen, known, within=size * within).kept).tolist() == [3]
