"""An image that a camera has of a track in one frame alone does not settle how far the marker is."""

import numpy as np
import pytest

from kinemark.data import Camera, Detections, Rig
from kinemark.data.array_types import Floats
from kinemark.geometry import project_all
from kinemark.track.simultaneous import track_detections
from kinemark.track.simultaneous.candidate_points import intersect
from kinemark.track.simultaneous.detection_index import read_images
from kinemark.track.simultaneous.lone_images import without_lone
from kinemark.track.simultaneous.passes import Associations

PLACES = np.array(
    [[-200.0, -4000.0, 1000.0], [200.0, -4000.0, 1000.0], [4000.0, 0.0, 1000.0], [-4000.0, 500.0, 1000.0]]
)
"""mm; of two cameras side by side, 4 m before the middle, and of two from the sides."""

FRAMES, NOISE = 80, 0.3
FALSE = range(20, 61, 10)
"""Frames in which the third camera has a false image."""


def rig(n: int = 3) -> Rig:
    """The first n cameras."""
    cameras = []
    for c, centre in enumerate(PLACES[:n]):
        z = (np.array([0.0, 0.0, 1000.0]) - centre) / np.linalg.norm(centre - [0, 0, 1000])
        x = np.cross(z, [0.0, 0.0, 1.0])
        R = np.stack([x, np.cross(z, x), z])
        K = np.array([[1000.0, 0.0, 640.0], [0.0, 1000.0, 512.0], [0.0, 0.0, 1.0]])
        cameras.append(Camera(f"cam{c}", np.array([1280, 1024]), K, R, -R @ centre))
    return Rig(tuple(cameras))


def seen(uv: Floats, rng: np.random.Generator) -> Detections:
    """Images (C, F, M, 2) of all markers; the third camera has the first one's only where FALSE, 8 px aside."""
    counts, rows = np.zeros(uv.shape[:2], int), []
    for c, f in np.ndindex(*counts.shape):
        of = uv[c, f] + rng.normal(0, NOISE, uv[c, f].shape)
        if c == 2:
            of = np.vstack([of[1:], of[:1] + np.array([8.0, 0.0])] if f in FALSE else [of[1:]])
        counts[c, f] = len(of)
        rows.append(of)
    return Detections.build(("cam0", "cam1", "cam2"), 100.0, counts, np.concatenate(rows))


def test_one_image_of_a_third_camera_does_not_settle_the_distance() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(FRAMES)[:, None] / 100
    xyz = rng.uniform([-600, -600, 300], [600, 600, 1700], (9, 3)) + np.stack([300 * t, 200 * np.sin(3 * t), 0 * t], -1)
    cloud = track_detections(seen(project_all(rig(), xyz), rng), rig()).cloud
    off = np.linalg.norm(cloud.xyz - xyz[cloud.frame, 0], axis=1)
    near = off < 120
    sd = np.sqrt(np.trace(cloud.cov[near], axis1=1, axis2=2))
    assert near.sum() > 0.95 * FRAMES
    assert (off[near] < 3.5 * sd).mean() > 0.95


@pytest.mark.parametrize(("n", "left"), [(3, 2), (4, 4)])
def test_lone_images_that_two_cameras_have_at_once_check_each_other(n: int, left: int) -> None:
    """Of n cameras, those from the sides see the marker in the middle frame alone."""
    has = np.repeat([np.arange(n) < 2], 5, 0)
    has[2] = True
    rows = np.where(has, np.cumsum(has.T.ravel()).reshape(n, 5).T - 1, -1).T
    uv = project_all(rig(n), np.array([[[0.0, 0.0, 1000.0]]]))[:, 0, 0].repeat(has.sum(0), axis=0)
    images = read_images(Detections.build(rig(n).names, 100.0, has.T.astype(int), uv), rig(n))
    point, zero = intersect(images, rows), np.zeros(5)
    seen = Associations(np.arange(5), np.zeros(5, int), rows, rows < -1, zero, zero, point.xyz, point.cov)
    assert (without_lone(seen, images).detection >= 0).sum(0).tolist() == [2, 2, left, 2, 2]
