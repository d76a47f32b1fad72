"""Strobes of cameras, which other cameras see, are no markers; what stands before a camera may be one."""

from dataclasses import replace

import numpy as np
import pytest

from kinemark.data import Camera, Detections, Rig
from kinemark.data.array_types import Floats
from kinemark.geometry import project
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.rig.camera_strobes import camera_strobes, diagnose_strobes, without_strobes

CAMERAS, FRAMES, MARKERS, NOISE = 6, 80, 10, 0.1
DOWN = np.array([[0, 0, 0], [0, 0, 60.0], [0, 0, 0]])
ORIGIN = np.array([400.0, -300.0, 0.0])


def rig() -> Rig:
    """Cameras at one height on a circle, each of which sees those on the other side."""
    return Rig(tuple(_camera(f"cam{c + 1}", 2 * np.pi * c / CAMERAS) for c in range(CAMERAS)))


def _camera(name: str, azimuth: float) -> Camera:
    centre = ORIGIN + np.array([4000 * np.cos(azimuth), 4000 * np.sin(azimuth), 2000.0])
    ahead = ORIGIN + np.array([0, 0, 1200.0]) - centre
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(ahead, right), ahead])
    K = np.array([[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1]])
    return Camera(name, np.array([640, 480]), K, R, -R @ centre, np.array([-0.1, 0.01, 0, 0, 0]))


def seen(cameras: Rig, xyz: Floats, rng: np.random.Generator) -> Detections:
    """Images of markers (F, M, 3) mm, and of the strobes, 60 mm above the middle of each camera."""
    rows, counts = [], np.zeros((CAMERAS, FRAMES), int)
    strobes = np.array([one.centre for one in cameras]) + np.array([0, 0, 60.0])
    for c, f in np.ndindex(CAMERAS, FRAMES):
        uv = project(cameras[c], np.concatenate([xyz[f], np.delete(strobes, c, axis=0)]))
        uv = uv[((uv > 0) & (uv < cameras[c].size)).all(1)]
        rows.append(uv + rng.normal(0, NOISE, uv.shape))
        counts[c, f] = len(uv)
    return Detections.build(cameras.names, 100.0, counts, np.concatenate(rows))


def body(rng: np.random.Generator, speed: float) -> Floats:
    """(F, M, 3) mm, markers that go together at a speed, mm/s."""
    shape = ORIGIN + rng.uniform([-300, -300, 300], [300, 300, 1500], (MARKERS, 3))
    return shape + speed * np.arange(FRAMES)[:, None, None] / 100 * np.array([1, 0.5, 0.1])


@pytest.mark.parametrize("seed", range(2))
def test_strobes_of_other_cameras_make_no_tracks(seed: int) -> None:
    """Each pair of opposite cameras made one that lasted as long as the recording."""
    rng = np.random.default_rng(seed)
    cameras, xyz = rig(), body(rng, 700.0)
    detections = seen(cameras, xyz, rng)
    assert {(one.seen_by, one.of) for one in camera_strobes(detections, cameras)} >= {(0, 3), (3, 0), (1, 4)}
    (told,) = diagnose_strobes(detections, cameras)
    assert set(told.cameras) == set(told.values["of_list"]) == set(cameras.names)
    cloud = track_detections(detections, cameras).cloud
    off = np.linalg.norm(cloud.xyz[:, None] - xyz[cloud.frame], axis=-1).min(1)
    assert (off < 20).sum() > 0.99 * MARKERS * FRAMES
    assert not (off > 20).any()


def test_images_stay_where_they_are_not_of_strobes() -> None:
    """Of somebody who stands still, of markers that pass before a camera, and where another rig has its cameras."""
    rng = np.random.default_rng(3)
    cameras = rig()
    still = seen(cameras, body(rng, 0.0), rng)
    assert without_strobes(still, cameras) is still
    moving = seen(cameras, body(rng, 700.0), rng)
    elsewhere = Rig(tuple(replace(one, K=one.K + DOWN) for one in cameras))
    assert without_strobes(moving, elsewhere) is moving
    assert (~without_strobes(moving, cameras).valid).sum() == CAMERAS * FRAMES


def test_before_cameras_that_stand_near_what_rests_may_be_a_marker() -> None:
    """60 mm beside a camera is 4° at 0.8 m, as about a hand."""
    rng = np.random.default_rng(4)
    near = Rig(tuple(replace(one, t=0.1 * one.t) for one in rig()))
    assert not camera_strobes(seen(near, 0.1 * body(rng, 700.0), rng), near)
