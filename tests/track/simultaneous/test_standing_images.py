"""Points of images that stand still, found from the means of many frames."""

import numpy as np
import pytest

from kinemark import synth
from kinemark.data import Detections, Rig
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.following.candidate_points import find_candidate_points, fundamentals
from kinemark.track.simultaneous.following.standing_images import HALF_S, find_standing_points
from kinemark.track.simultaneous.noise.standing_noise import lasting_variance
from support.laboratory import observe, ring
from support.motions import dance
from support.scenes.bodies import walker

T = 0.01
HALF = round(HALF_S / T)
NOISE, FRAMES, GATE = 0.3, 2 * HALF + 1, 5.0
LASTING = np.full(4, 0.05**2)
SWAY = 2.0 * np.sin(np.arange(FRAMES) / 15)[:, None] * np.array([1.0, 0.5, 0.0])


def on_each_others_lines(rig, pairs=12, off_px=1.0):
    """(2 pairs, F, 3) mm, markers that sway together, of which each has another `off_px` beside its epipolar lines."""
    one, other = (camera.centre for camera in rig.cameras[:2])
    rng = np.random.default_rng(5)
    first = rng.uniform([-400, -400, 400], [400, 400, 1600], (pairs, 3))
    away = [(first - eye) / np.linalg.norm(first - eye, axis=1)[:, None] for eye in (one, other)]
    across = np.cross(*away)
    across /= np.linalg.norm(across, axis=1)[:, None]
    second = first + 120 * away[0] - 90 * away[1] + off_px * across * 4000 / 1200
    return np.concatenate([first, second])[:, None] + SWAY


def wrong_and_right(find, frames, *more):
    """How many points of two cameras are of two markers, and how many of one."""
    rig = Rig(ring(4).cameras[:2])
    detections, marker = observe(rig, on_each_others_lines(rig), noise=NOISE, seed=1)
    images = read_images(detections, rig)
    found = find(images, images.usable, fundamentals(images.P), frames, *more)
    of = marker[found.detection]
    assert (found.detection >= 0).all()
    assert (images.frame[found.detection] == found.frame).all()
    return int((of[0] != of[1]).sum()), int((of[0] == of[1]).sum())


def test_the_means_of_many_frames_tell_markers_on_each_others_lines_apart():
    frames = [HALF - 20, HALF, HALF + 20]
    assert wrong_and_right(find_standing_points, frames, T, GATE, LASTING[:2]) == (0, 72)
    assert wrong_and_right(find_candidate_points, frames, GATE)[0] >= 5  # what the images of one frame make of them


def test_places_are_those_of_the_images_of_their_own_frame():
    rig = ring(4)
    xyz = on_each_others_lines(rig, pairs=4)
    images = read_images(observe(rig, xyz, noise=0.1)[0], rig)
    found = find_standing_points(images, images.usable, fundamentals(images.P), [24, 72], T, GATE, LASTING)
    apart = np.linalg.norm(found.xyz.T[:, None] - xyz[:, found.frame].swapaxes(0, 1), axis=-1).min(1)
    assert len(apart) == 16
    assert np.median(apart) < 0.6  # the mean place is 1.6 mm away


def test_images_that_move_or_are_not_free_or_are_two_do_not_stand():
    rig = ring(4)
    images = read_images(observe(rig, dance(n=6, frames=FRAMES), noise=NOISE)[0], rig)
    F = fundamentals(images.P)
    assert not find_standing_points(images, images.usable, F, [HALF], T, GATE, LASTING).frame.size
    still = on_each_others_lines(rig, pairs=1)[:1]
    images = read_images(observe(rig, still, noise=NOISE)[0], rig)
    assert find_standing_points(images, images.usable, F, [HALF], T, GATE, LASTING).frame.size == 1
    assert not find_standing_points(images, ~images.usable, F, [HALF], T, GATE, LASTING).frame.size
    images = read_images(observe(rig, np.concatenate([still, still + 1.0]), noise=NOISE)[0], rig)
    assert not find_standing_points(images, images.usable, F, [HALF], T, GATE, LASTING).frame.size


def test_a_foot_that_stands_for_less_than_a_second_is_no_standing_subject_at_any_rate():
    rig, frame = ring(4), np.arange(400)
    foot = np.array([100.0, 50.0, 80.0]) + np.maximum(frame - 120, 0)[:, None] * np.array([15.0, 0.0, 1.0])
    images = read_images(observe(rig, foot[None], noise=NOISE)[0], rig)
    F = fundamentals(images.P)
    for rate, stands in ((100, True), (500, False)):  # 1.2 s, and .24 s
        found = find_standing_points(images, images.usable, F, [60], 1 / rate, GATE, LASTING)
        assert bool(found.frame.size) == stands


def seen_by_two(seed, markers=60, frames=60):
    """A rig of four cameras, markers that stand still (M, F, 3) mm, and detections of the two that see each."""
    rng, rig = np.random.default_rng(seed), ring(4)
    sway = 2.0 * np.sin(np.arange(frames) / 15)[:, None] * np.array([1.0, 0.5, 0.0])
    xyz = rng.uniform([-400, -400, 200], [400, 400, 1700], (markers, 1, 3)) + sway
    detections, marker = observe(rig, xyz, noise=NOISE, seed=seed)
    sees = rng.permuted(np.tile(np.arange(4) < 2, (markers, 1)), axis=1)
    return rig, xyz, detections.keep(sees[marker, detections.camera])


def test_a_subject_that_stands_still_is_tracked():
    rig, xyz, detections = seen_by_two(2)
    cloud = track_detections(detections, rig).cloud
    apart = np.linalg.norm(cloud.xyz[:, None] - xyz[:, cloud.frame].swapaxes(0, 1), axis=-1)
    found = np.unique(np.column_stack([apart.argmin(1), cloud.frame])[apart.min(1) < 10.0], axis=0)
    assert len(found) >= 0.93 * xyz[..., 0].size


def test_who_walks_before_a_camera_of_a_high_rate_does_not_stand_still():
    rig, xyz = ring(4), walker("walk", 39, np.arange(200) / 1000, np.random.default_rng(1), True).xyz
    tracks = track_detections(observe(rig, xyz, noise=NOISE, seed=1, rate=1000.0, cov=False)[0], rig)
    assert len(tracks) == 39  # 52 where they stand for 48 frames, whatever the rate


def test_reflections_that_meet_by_chance_do_not_tell_how_well_a_calibration_fits():
    rig = ring(4)
    rng = np.random.default_rng(1)
    still = [rng.uniform([50, 50], camera.size - 50, (15, 2)) for camera in rig]
    counts = np.full((4, FRAMES), 15)
    uv = np.concatenate([one + NOISE * rng.normal(size=(FRAMES, 15, 2)) for one in still]).reshape(-1, 2)
    reflected = Detections.build(rig.names, 100.0, counts, uv, np.broadcast_to(np.eye(2) * NOISE**2, (len(uv), 2, 2)))
    markers = observe(rig, on_each_others_lines(rig), noise=NOISE)[0]
    for detections, told in ((reflected, False), (markers, True)):
        images = read_images(detections, rig)
        assert (lasting_variance(images, fundamentals(images.P), T, GATE) is not None) == told


@pytest.mark.parametrize(("cameras", "most_tracks"), [(4, 35), (8, 34)])
def test_who_walks_slowly_has_no_second_tracks(cameras, most_tracks):
    """Feet in stance stand still in some cameras alone, where nothing comes near them; 40 and 48 tracks of 34 markers
    when their images in the others began tracks at once. What two cameras see for a moment is none of these."""
    rig = synth.ring(cameras)
    subject = synth.walking(duration_s=30.0, rate=100.0, speed_mm_s=80.0, wobble_mm=1.0, seed=0)
    subject = synth.with_markers(subject, 39, apart_mm=30.0, seed=0)
    detections = synth.observe(rig, subject, noise_px=0.2, merge_px=4.0, seed=0).detections
    points = np.bincount(track_detections(detections, rig).id)
    assert (points >= 20).sum() <= most_tracks
