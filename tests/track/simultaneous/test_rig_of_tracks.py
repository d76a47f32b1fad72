"""The rig adjusted to the images of its own tracks."""

import numpy as np
import pytest

from kinemark.geometry import project
from kinemark.numerics.robust import plane_scale
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import intersect
from kinemark.track.simultaneous.rig.rig_of_tracks import rig_of_tracks
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally
from support.scenes.placements import off

NOISE, FRAMES = 0.2, 120


def seen(cameras):
    """Detections of eight markers, and those of each point (C, S)."""
    true = ring(cameras)
    detections, marker = observe(true, dance(frames=FRAMES, seed=2), noise=NOISE, seed=3)
    images = read_images(detections, true)
    detection = np.full((cameras, 8 * FRAMES), -1)
    detection[images.camera, marker * FRAMES + images.frame] = np.arange(len(marker))
    return detections, detection


def residual(detections, detection, rig):
    """Median distance of images from the points that fit them best, px."""
    point = intersect(images := read_images(detections, rig), detection)
    apart = [
        np.linalg.norm(project(camera, point.xyz.T) - images.uv[own], axis=1)[own >= 0]
        for camera, own in zip(rig, detection, strict=True)
    ]
    return float(np.median(np.concatenate(apart)))


@pytest.mark.parametrize("cameras", [3, 4, 7, 12])
@pytest.mark.parametrize("error", [0.5, 1.5])
def test_a_file_that_is_off_is_adjusted_to_what_the_images_allow(cameras, error):
    detections, detection = seen(cameras)
    wrong = off(ring(cameras), error, np.random.default_rng(cameras))
    adjusted = rig_of_tracks(detection, read_images(detections, wrong), wrong)
    best = residual(detections, detection, ring(cameras))
    assert residual(detections, detection, wrong) > 1.5 * best
    assert residual(detections, detection, adjusted) < 1.1 * best
    moved = np.linalg.norm(adjusted.centres - wrong.centres, axis=1)
    assert moved.max() < 0.01 * np.linalg.norm(wrong.centres, axis=1).min()  # the rig as a whole stays


def sides_of_a_plate(gap):
    """Markers (24, FRAMES, 3) on both sides of a plate, gap mm thick, which moves between cameras at +x and −x."""
    grid = np.array([[0.0, 60 * a, 60 * b] for a in range(4) for b in range(3)]) - [0, 90, 60]
    way = np.linspace([-150, -500, 1000], [150, 500, 1090], FRAMES)
    return np.concatenate([grid[:, None] + way + [side * gap / 2, 0, 0] for side in (1, -1)])


@pytest.mark.parametrize("cameras", [6, 12])
def test_the_sides_of_a_plate_that_no_camera_shares_are_not_moved_onto_each_other(cameras):
    """One point in 20 has an image of the marker on the other side, less than 1 px beside it.

    With 1.5 mrad in place of what the images disagree by, the sides came to 12 and 15 mm of 36."""
    true, xyz = ring(cameras), sides_of_a_plate(36.0)
    detections, marker = observe(true, xyz, noise=0.15, cov=False)
    file = off(true, 0.2, np.random.default_rng(0))
    images = read_images(detections, file)
    every = np.full((cameras, 24, FRAMES), -1)
    every[images.camera, marker, images.frame] = np.arange(len(marker))
    facing = np.sign(true.centres[:, 0])[:, None] == np.repeat([1, -1], 12)
    own = np.where(facing[..., None], every, -1).reshape(cameras, -1)
    other = np.roll(every, 12, 1).reshape(cameras, -1)
    place = intersect(images, own).xyz.T
    beside = np.array(
        [np.linalg.norm(project(c, place) - images.uv[d], axis=1) for c, d in zip(file, other, strict=True)]
    )
    met = np.where((own < 0) & (beside < 1), other, own)
    assert 0.01 < ((met >= 0) & (own < 0)).any(0).mean() < 0.1
    adjusted = rig_of_tracks(met, images, file)
    sides = intersect(read_images(detections, adjusted), own).xyz.reshape(3, 24, FRAMES)
    assert np.median(np.linalg.norm(sides[:, :12] - sides[:, 12:], axis=0)) > 28


def test_images_of_a_right_file_lose_nothing_by_it():
    detections, detection = seen(6)
    adjusted = rig_of_tracks(detection, read_images(detections, ring(6)), ring(6))
    assert residual(detections, detection, adjusted) < 1.02 * residual(detections, detection, ring(6))


def test_cameras_that_agree_only_where_nothing_moves_tell_nothing():
    detections, detection = seen(6)
    wrong = off(ring(6), 1.0, np.random.default_rng(1))
    images = read_images(detections, wrong)
    rng = np.random.default_rng(5)
    late = (images.frame >= FRAMES // 2) * rng.choice([-30.0, 30.0], len(images.frame))
    assert rig_of_tracks(detection, images._replace(uv=images.uv + late[:, None]), wrong) is wrong


def test_images_that_agree_as_well_as_they_say_leave_the_rig_as_it_is():
    detections, detection = seen(4)
    wrong = off(ring(4), 1.0, np.random.default_rng(1))
    images = read_images(detections, wrong)
    assert rig_of_tracks(detection, images, wrong, least=0.0) is not wrong
    assert rig_of_tracks(detection, images, wrong, least=2.0) is wrong


@pytest.mark.parametrize(("cameras", "points"), [(2, None), (6, 45)])
def test_two_cameras_and_few_points_tell_nothing(cameras, points):
    detections, detection = seen(cameras)
    wrong = off(ring(cameras), 1.0, np.random.default_rng(1))
    assert rig_of_tracks(detection[:, :points], read_images(detections, wrong), wrong) is wrong


def test_sixty_points_tell_enough():
    """A first pass that a file leaves few points needs the adjustment most."""
    detections, detection = seen(4)
    wrong = off(ring(4), 1.0, np.random.default_rng(1))
    adjusted = rig_of_tracks(detection[:, ::16], read_images(detections, wrong), wrong)
    assert residual(detections, detection, adjusted) < 1.2 * residual(detections, detection, ring(4))


def test_a_scene_of_four_cameras_whose_file_is_a_pixel_off():
    made = make(scene(90038))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.two_found > 0.93 * count.two  # 0.66 with what epipolar lines tell of the rig
    assert count.ghosts <= 0.1 * count.frames  # 0.26


def test_a_rig_by_which_chance_meetings_agree_is_not_taken():
    """Sixty markers crawl slowly before four cameras in pairs: by the rig adjusted to epipolar lines, images agree six
    times better, and tracks of parts of the recording have half as many of them (36 % of the samples were found)."""
    made = make(scene(131008))
    found = tally(made, track_detections(made.detections, made.rig))
    assert found.two_found + found.more_found > 0.99 * (found.two + found.more)
    assert not found.ghosts


def test_stated_noise_that_pairs_of_cameras_do_not_contradict_but_three_images_do():
    """Three cameras that look past each other's centres see all markers; the file is a pixel off. Their lines agree."""
    made = make(scene(30402))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.more_found > 0.998 * count.more  # 0.914 with the rig as given
    assert count.ghosts <= 0.02 * count.frames  # 1.03


@pytest.mark.parametrize(("cameras", "left"), [(3, 1 / 2), (4, 5 / 8)])
def test_a_point_fits_a_part_of_the_noise_that_images_state(cameras, left):
    """Of four images of a point eight coordinates are noisy, and five are left in its residuals."""
    detections, detection = seen(cameras)
    wrong = off(ring(cameras), 1.0, np.random.default_rng(1))
    images = read_images(detections, wrong)
    detection = detection[:, (detection >= 0).all(0)]
    squared = intersect(images, detection).squared * images.variance[detection]
    noise = plane_scale(np.sqrt(squared).ravel()) / np.sqrt(left)
    assert rig_of_tracks(detection, images, wrong, least=0.85 * noise) is not wrong
    assert rig_of_tracks(detection, images, wrong, least=1.05 * noise) is wrong
