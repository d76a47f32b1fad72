"""A camera that was touched and lies little beside the others is put right, or back to where it was."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Cloud, Detections, Rig, Tracks
from kinemark.geometry import project
from kinemark.track.simultaneous import Simultaneous, diagnose, simultaneous_tracking, track_simultaneously
from kinemark.track.simultaneous.rig.moved_cameras import MovedCamera, as_calibrated, moved_camera
from kinemark.track.simultaneous.rig.rig_of_tracks import changed_camera
from kinemark.track.simultaneous.rig.unfitting_stretches import Stretch
from support.laboratory import observe, ring
from support.motions import dance

TOUCHED, SINCE, FRAMES = 3, 43, 80


@pytest.fixture(scope="module", params=[(6, 1), (8, 3)], ids=["six", "eight"])
def knocked(request):
    """A rig, true places (M, F, 3) mm, and what its cameras see with one 2 px beside from a frame on."""
    cameras, seed = request.param
    rig, xyz = ring(cameras), dance(12, FRAMES, seed=seed)
    seen, _ = observe(rig, xyz, noise=0.2, seed=seed)

    def beside(since):
        those = (seen.camera == TOUCHED) & (seen.frame >= since)
        return replace(seen, uv=seen.uv + those[:, None] * [1.6, -1.2])

    return rig, xyz, beside


def off(result, xyz, since):
    """(n) mm by which points lie beside the nearest true place, from a frame on."""
    cloud = result.tracks.cloud
    late = cloud.frame >= since
    near = np.linalg.norm(cloud.xyz[late, None] - xyz[:, cloud.frame[late]].swapaxes(0, 1), axis=-1)
    return near.min(1)


def test_within_a_recording_its_images_are_put_where_they_would_have_been(knocked):
    rig, xyz, beside = knocked
    result = track_simultaneously(beside(SINCE), rig, Simultaneous())
    (moved,) = result.moved
    cloud = result.tracks.cloud
    assert result.unfitting == () and moved.camera == TOUCHED and moved.stop == FRAMES
    assert abs(moved.first - SINCE) <= 1
    assert (cloud.detection[cloud.frame >= SINCE, TOUCHED] >= 0).mean() > 0.8
    (found,) = diagnose(beside(SINCE), rig, result)
    assert (found.kind, found.cameras) == ("camera_put_right", (rig.names[TOUCHED],))
    assert found.frames == ((moved.first, FRAMES - 1),)
    assert np.median(off(result, xyz, SINCE)) < 1.1 * np.median(off(result, xyz, 0))


def test_it_takes_no_part_where_the_others_cannot_put_it_back(knocked, monkeypatch):
    rig, xyz, beside = knocked
    monkeypatch.setattr(simultaneous_tracking, "moved_camera", lambda *_: None)
    result = track_simultaneously(beside(SINCE), rig, Simultaneous())
    (stretch,) = result.unfitting
    cloud = result.tracks.cloud
    assert stretch == Stretch(TOUCHED, stretch.first, FRAMES) and abs(stretch.first - SINCE) <= 1
    assert not (cloud.detection[cloud.frame >= stretch.first, TOUCHED] >= 0).any()
    assert (cloud.detection[cloud.frame < stretch.first, TOUCHED] >= 0).mean() > 0.8
    (found,) = diagnose(beside(SINCE), rig, result)
    assert (found.kind, found.cameras, found.values["left_out"]) == ("camera_shifted", (rig.names[TOUCHED],), True)
    assert np.median(off(result, xyz, SINCE)) < 1.15 * np.median(off(result, xyz, 0))


def test_within_a_recording_it_is_told_by_a_calibration_that_is_off_as_well(knocked):
    rig, _, beside = knocked
    shift = np.random.default_rng(0).uniform(-0.35, 0.35, (len(rig), 2))
    stated = Rig(tuple(replace(one, K=one.K + _offset(by)) for one, by in zip(rig, shift, strict=True)), rig.method)
    result = track_simultaneously(beside(SINCE), stated, Simultaneous())
    assert [(one.camera, abs(one.first - SINCE) <= 1) for one in result.moved] == [(TOUCHED, True)]
    assert track_simultaneously(beside(FRAMES), stated, Simultaneous()).moved == ()


def _offset(by):
    """What moves the middle of the image by (2) px."""
    return np.array([[0, 0, by[0]], [0, 0, by[1]], [0, 0, 0.0]])


def test_images_of_a_camera_that_stands_otherwise_are_those_of_the_one_before():
    camera, depth = replace(ring(4)[0], distortion=np.array([-0.1, 0.01, 1e-4, 2e-4, 0.0])), 4000.0
    now = changed_camera(camera, np.array([2e-3, -3e-3, 1e-3, 1e-3, -1e-3, 5e-4, 0.0]), depth)
    x, y = np.meshgrid([-0.2, 0.0, 0.15], [-0.1, 0.05, 0.15])
    xyz = (depth * np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3) - now.t) @ now.R
    there = project(now, xyz)
    seen = Detections.build([camera.name], 100.0, [[9, 9, 9]], np.tile(there, (3, 1)))
    back = as_calibrated(seen, Rig((camera,)), [MovedCamera.of(0, 1, 2, camera, now, depth)]).uv.reshape(3, 9, 2)
    np.testing.assert_allclose(back[1], project(camera, xyz), atol=1e-6)
    np.testing.assert_array_equal(back[[0, 2]], [there, there])
    assert np.linalg.norm(back[1] - there, axis=1).min() > 1


def test_what_is_not_known_of_a_knock_is_stated():
    """Images put back are off by the variance that is stated, over knocks, noise and depths of the points."""
    ratios = [z for seed in range(12) for z in _put_back_ratios(seed)]
    assert 0.4 < np.mean(ratios) < 1.8


def _put_back_ratios(seed):
    """Mean squares (2) of how far images put back are off, over the stated variance: u, v."""
    rng, rig = np.random.default_rng(seed), ring(4)
    n, frames, camera, depth = 6, 60, rig[0], float(np.linalg.norm(rig[0].centre))
    xyz = rng.uniform([-400, -400, 500], [400, 400, 1300], (frames, n, 3))
    now = changed_camera(camera, np.r_[rng.normal(0, 8e-4, 3), rng.normal(0, 8e-4, 3), 0.0], depth)
    exact = np.stack([project(now if f >= 30 else camera, xyz[f]) for f in range(frames)])
    seen = exact + rng.normal(0, 0.4, exact.shape)
    uv = np.concatenate([seen.reshape(-1, 2), np.full((3 * frames * n, 2), 5.0)])
    detections = Detections.build(rig.names, 100.0, np.full((4, frames), n), uv)
    start = np.arange(frames + 1) * n
    detection = np.full((frames * n, 4), -1)
    detection[:, 1:] = 0
    flat = xyz.reshape(-1, 3)
    cov = np.broadcast_to(np.eye(3), (len(flat), 3, 3))
    tracks = Tracks(Cloud(100.0, start, flat, cov, np.zeros(len(flat)), detection), np.tile(np.arange(n), frames))
    offset = np.median((exact[30:] - np.stack([project(camera, x) for x in xyz[30:]])).reshape(-1, 2), axis=0)
    back = moved_camera(Stretch(0, 30, frames), offset, tracks, detections, rig)
    late = detections.keep(detections.camera == 0)
    moved = replace(late, uv=exact.reshape(-1, 2))
    off = as_calibrated(moved, rig, [back.moved]).uv[30 * n :] - project(camera, flat[30 * n :])
    return (off**2).mean(0) / np.diag(back.cov)


def test_points_with_an_image_of_the_knocked_camera_are_less_certain(knocked, monkeypatch):
    rig, _, beside = knocked
    kept = []
    said = simultaneous_tracking.less_certain
    monkeypatch.setattr(
        simultaneous_tracking, "less_certain", lambda result, back: kept.append(result) or said(result, back)
    )
    cloud = track_simultaneously(beside(SINCE), rig, Simultaneous()).tracks.cloud
    more = np.trace(cloud.cov - kept[0].tracks.cloud.cov, axis1=1, axis2=2)
    own = (cloud.frame >= SINCE + 1) & (cloud.detection[:, TOUCHED] >= 0)
    assert (more[own] > 0).all() and (more[cloud.frame < SINCE - 1] == 0).all()
    assert (more[cloud.detection[:, TOUCHED] < 0] == 0).all()


def test_in_a_whole_recording_it_is_put_right(knocked):
    rig, xyz, beside = knocked
    result = track_simultaneously(beside(0), rig, Simultaneous())
    good = track_simultaneously(beside(FRAMES), rig, Simultaneous())
    (found,) = diagnose(beside(0), rig, result)
    assert result.unfitting == () and [one.camera for one in result.put_right] == [TOUCHED]
    assert found.kind == "camera_put_right"
    assert np.median(off(result, xyz, 0)) < 1.15 * np.median(off(good, xyz, 0))
