"""Noise that the tracks of a first run contradict."""

import numpy as np

from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.noise_of_tracks import FACTOR, MARGIN, excess
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes import make, scene, tally

NOISE = 0.3


def taken_for(times, cameras=4, foreign=0.0):
    """Images of noise NOISE px, but camera 1 taken for so many `times` as noisy, and a share `foreign` of its images
    another marker's, 2 px off; and those of each point (C, S)."""
    detections, marker = observe(ring(cameras), dance(frames=120, seed=2), noise=NOISE, seed=3)
    images = read_images(detections, ring(cameras))
    detection = np.full((cameras, 8 * 120), -1)
    detection[images.camera, marker * 120 + images.frame] = np.arange(len(marker))
    wrong = (images.camera == 1) & (np.random.default_rng(4).random(len(marker)) < foreign)
    images = images._replace(uv=images.uv + 2.0 * wrong[:, None])
    return images.noisier((np.arange(cameras) == 1) * (times**2 - 1) * NOISE**2), detection


def test_a_camera_that_is_taken_for_too_noisy_shows_in_the_tracks():
    images, detection = taken_for(5.0)
    found = excess(detection, images)
    assert not found[[0, 2, 3]].any()
    left = np.median(images.variance[images.camera == 1]) - found[1]
    assert MARGIN * NOISE**2 < left < 2 * MARGIN * NOISE**2  # what the other cameras say is noisy too


def test_images_of_other_markers_are_no_measure_of_the_noise():
    images, detection = taken_for(5.0, foreign=0.15)
    left = np.median(images.variance[images.camera == 1]) - excess(detection, images)[1]
    assert MARGIN * NOISE**2 < left < 3 * MARGIN * NOISE**2


def test_noise_that_is_about_right_stays():
    images, detection = taken_for(0.8 * np.sqrt(FACTOR * MARGIN))
    assert not excess(detection, images).any()


def test_few_images_say_nothing():
    images, detection = taken_for(5.0)
    assert not excess(detection[:, :100], images).any()


def test_a_scene_of_three_cameras_of_which_one_was_taken_for_noisy():
    made = make(scene(3013))
    count = tally(made, track_detections(made.detections, made.rig))
    assert count.two_found > 0.98 * count.two  # 0.90 with the noise of epipolar lines alone
    assert count.ghosts <= 0.02 * count.frames  # 1.30
