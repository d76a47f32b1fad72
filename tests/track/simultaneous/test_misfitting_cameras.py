"""A camera whose images fit no other's in the whole trial is named and left out; a good one, or a late one, is not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinemark.data import Detections
from kinemark.data.detections import Validity
from kinemark.track.simultaneous import diagnose, track_simultaneously
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.rig.misfitting_cameras import beside_tracks, image_offset, misfitting
from kinemark.track.simultaneous.rig.unfitting_stretches import unfitting_stretches
from kinemark.track.simultaneous.simultaneous_method import DEFAULT
from support.scenes import make, scene, tally
from support.scenes.placements import off

BUMPED = {160030: 3, 160035: 0, 164019: 1}
"""Scenes, and the camera that is bumped: 160030 along the lines of the three others, 164019 one of three, which takes
another along."""


@cache
def made(seed, frames=100):
    """The first frames of a scene."""
    whole = make(scene(seed))
    columns = {name: getattr(whole, name)[:, :frames] for name in ("xyz", "own", "sd")}
    return whole._replace(detections=whole.detections.frames(0, frames), **columns)


def bumped(one, c, by):
    own = one.detections.camera == c
    return replace(one.detections, uv=one.detections.uv + own[:, None] * np.array(by))


def later(detections, c, k):
    """Camera c shows in each frame what it saw k frames before."""
    start = detections.start.copy()
    start[c, k + 1 : -1] = detections.start[c, 1 : len(start[c]) - 1 - k]
    start[c, 1 : k + 1] = detections.start[c, 0]
    return replace(detections, start=start)


def masked(detections, c):
    return replace(detections, validity=np.where(detections.camera == c, Validity.MASKED, detections.validity))


CASES = [(160030, (12.0, 0.0)), (160035, (9.0, -8.0)), (164019, (9.7, 7.1))]


def told_of(one, detections, result, kind):
    (told,) = [f for f in diagnose(detections, one.rig, result) if f.kind == kind]
    assert told.frames == ()
    return told.cameras, (told.values["offset_u_px"], told.values["offset_v_px"])


@pytest.mark.parametrize(("seed", "by"), CASES)
def test_a_camera_bumped_in_the_whole_trial_is_named_and_put_right(seed, by):
    one, c = made(seed), BUMPED[seed]
    detections = bumped(one, c, by)
    result = track_simultaneously(detections, one.rig, DEFAULT)
    best = track_simultaneously(one.detections, one.rig, DEFAULT)
    found, wanted = (tally(one, r.tracks) for r in (result, best))
    assert result.unfitting == () and [camera for camera, *_ in result.put_right] == [c]
    assert found.ghosts <= wanted.ghosts + 5  # 2299, 209 and 3872 with its images, in all frames
    assert found.two_found + found.more_found >= 0.995 * (wanted.two_found + wanted.more_found)
    cameras, offset = told_of(one, detections, result, "camera_put_right")
    assert cameras == (one.rig.names[c],)
    np.testing.assert_allclose(offset, by, atol=3.0)  # looked for in boxes of 6 px
    others = [k for k in range(len(one.rig)) if k != c]
    assert all(result.rig[k] is one.rig[k] for k in others), "the world stays as it is"


@pytest.mark.parametrize(("seed", "by"), CASES[:2])
def test_a_camera_whose_images_agree_nowhere_is_left_out(seed, by):
    one, c = made(seed), BUMPED[seed]
    shaken = np.random.default_rng(seed).normal(0, 2.5, one.detections.uv.shape)
    own = (one.detections.camera == c)[:, None]
    detections = replace(one.detections, uv=one.detections.uv + own * (by + shaken))
    result = track_simultaneously(detections, one.rig, DEFAULT)
    best = track_simultaneously(masked(one.detections, c), one.rig, DEFAULT)
    found, wanted = (tally(one, r.tracks) for r in (result, best))
    assert result.put_right == () and result.rig is one.rig
    assert [stretch.camera for stretch in result.unfitting] == [c]
    assert found.ghosts <= wanted.ghosts + 5
    assert found.two_found + found.more_found >= 0.995 * (wanted.two_found + wanted.more_found)


def test_good_cameras_are_not_suspected():
    one = made(160035)
    result = track_simultaneously(one.detections, one.rig, DEFAULT)
    assert result.unfitting == () and beside_tracks(result.tracks, result.images) == []
    assert not [f for f in diagnose(one.detections, one.rig, result) if f.kind == "camera_fits_nothing"]


def test_images_that_are_a_frame_late_are_not_beside_and_those_that_are_five_late_are():
    one, c = made(160021, 60), 2  # a walk at 25 Hz
    tracks = track_simultaneously(masked(one.detections, c), one.rig, DEFAULT).tracks
    offsets = [image_offset(c, tracks, read_images(later(one.detections, c, k), one.rig)) for k in (0, 1, 5)]
    assert offsets[0] is None and offsets[1] is None and offsets[2] is not None


def test_the_camera_without_which_the_others_agree_best_is_the_one():
    possible = 100.0 * (1 - np.eye(4))
    good = np.array([[0, 60, 8, 60], [60, 0, 15, 60], [8, 15, 0, 3], [60, 60, 3, 0.0]])
    assert misfitting(good, 0 * good + 1, possible, np.arange(4)) == [2]
    few = good.copy()  # camera 3 sees little with cameras 0 and 1, and is good
    few[3, :2] = few[:2, 3] = 12
    assert misfitting(few, 0 * few + 1, possible, np.arange(4))[0] == 2
    assert misfitting(0 * good, 0 * good + 1, possible, np.arange(4)) == []


def test_detections_that_are_not_valid_change_no_point():
    one = made(160004, 60)  # whose rig is adjusted to its tracks
    without = one.detections.keep(one.detections.camera != 3)
    a, b = (track_simultaneously(each, one.rig, DEFAULT).tracks for each in (without, masked(one.detections, 3)))
    np.testing.assert_array_equal(a.cloud.xyz, b.cloud.xyz)


def test_good_cameras_of_which_one_is_half_a_pixel_off_were_not_touched():
    one = made(160011, 240)  # its file is .3 px off
    result = track_simultaneously(one.detections, one.rig, DEFAULT)
    assert [f.kind for f in diagnose(one.detections, one.rig, result)] == []


def test_a_camera_without_images_is_told_once():
    one = made(160035)
    for detections in (one.detections.keep(one.detections.camera != 1), masked(one.detections, 1)):
        told = diagnose(detections, one.rig, track_simultaneously(detections, one.rig, DEFAULT))
        assert [(f.kind, f.cameras) for f in told if f.cameras] == [("camera_without_images", (one.rig.names[1],))]


def test_where_the_whole_calibration_is_off_no_camera_is_left_out():
    one = made(177009, 80)
    rig = off(one.rig, 2.5, np.random.default_rng(177009))  # 2 of 6 were left out, and 554 ghosts came of it
    result = track_simultaneously(one.detections, rig, DEFAULT)
    assert result.unfitting == () and tally(one, result.tracks).ghosts < 50


def test_reflections_that_are_masked_make_no_camera_suspected():
    one = made(160004, 60)
    n, extra = one.detections.n_frames, 60
    own = one.detections.counts
    more = own + np.array([extra, extra, 0, 0])[:, None]
    uv, valid = np.zeros((more.sum(), 2)), np.zeros(more.sum(), bool)
    to = np.concatenate([[0], np.cumsum(more)])
    rng = np.random.default_rng(0)
    for k, (start, count) in enumerate(zip(to[:-1].tolist(), own.ravel().tolist(), strict=True)):
        c, f = divmod(k, n)
        rows = slice(int(one.detections.start[c, f]), int(one.detections.start[c, f + 1]))
        uv[start : start + count], valid[start : start + count] = one.detections.uv[rows], True
        uv[start + count : int(to[k + 1])] = rng.uniform(
            0, one.rig.cameras[c].size, (int(to[k + 1]) - start - count, 2)
        )
    validity = np.where(valid, Validity.VALID, Validity.MASKED)
    detections = Detections.build(one.rig.names, one.detections.rate, more, uv, validity=validity)
    assert unfitting_stretches(detections, one.rig) == unfitting_stretches(one.detections, one.rig)


def test_a_camera_that_fits_once_the_rig_is_adjusted_is_not_left_out():
    """Of a file 1.4 px off one camera's images lie nowhere by the points of the others, which agree to 0.3 px."""
    one = make(scene(770070)._replace(calibration=1.4, seconds=1.2))
    result = track_simultaneously(one.detections, one.rig, DEFAULT)
    assert not result.unfitting
    found = tally(one, result.tracks)
    assert found.two_found > 0.98 * found.two
