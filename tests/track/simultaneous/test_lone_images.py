"""An image that a camera has of a track in one frame alone does not settle how far the marker is."""

import numpy as np

from kinemark.data import Camera, Detections, Rig
from kinemark.data.array_types import Floats
from kinemark.geometry import project_all
from kinemark.track.simultaneous import track_detections

FRAMES, NOISE = 80, 0.3
FALSE = range(20, 61, 10)
"""Frames in which the third camera has a false image."""


def rig() -> Rig:
    """Two cameras side by side, 4 m before the middle, and one from the side."""
    cameras = []
    for c, centre in enumerate(np.array([[-200.0, -4000.0, 1000.0], [200.0, -4000.0, 1000.0], [4000.0, 0.0, 1000.0]])):
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
