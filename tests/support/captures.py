"""Captures for tests of the report: a walk that every camera sees, and its figures."""

from dataclasses import fields

import numpy as np

from kinemark.data import Camera, Cloud, Detections, MarkerTrajectory, Rig, Step, Tracks, Trajectories
from kinemark.geometry import project
from kinemark.report import AboutTrial, TrialRecords, quality

RATE = 50.0
STEPS = (
    Step("detect", "Centroids", {"threshold": 60}, "0.1.0", "f" * 64, 2.0),
    Step("match", "Epipolar", {"gate": float("nan"), "cameras": ("a", "b")}, "0.1.0", "e" * 64, 0.5),
)


def camera_at(name, azimuth, size=(640, 480)):
    """Looks from 3 m at a point 1 m above the floor."""
    a = np.radians(azimuth)
    centre = np.array([3000 * np.cos(a), 3000 * np.sin(a), 2000.0])
    ahead = np.array([0, 0, 1000.0]) - centre
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(ahead, right), ahead])
    K = np.array([[800.0, 0, 319.5], [0, 800.0, 239.5], [0, 0, 1]])
    return Camera(name, np.array(size), K, R, -R @ centre, np.array([-0.1, 0.01, 0, 0, 0]))


def ring(n=4, volume=None, names=None):
    cameras = tuple(camera_at(names[c] if names else f"cam{c + 1}", 360 * c / n) for c in range(n))
    return Rig(cameras, "control points", np.full((2, 3), np.nan) if volume is None else np.asarray(volume, float))


def walk(markers=3, frames=40):
    """(M, F, 3) mm: smooth, inside all images."""
    t = np.linspace(0, 1, frames)
    path = np.stack([300 * t, 100 * np.sin(3 * t), 1000 + 50 * t], -1)
    return path + 80.0 * np.arange(markers)[:, None, None] * np.array([0, 1, 1.0])


def capture(rig, xyz, offset=None, sd=0.5, names=None):
    """Detections, tracks and trajectories of markers (M, F, 3) that all cameras see wherever they are not NaN."""
    M, F, _ = xyz.shape
    seen = np.isfinite(xyz).all(2)
    frame, marker = np.nonzero(seen.T)
    points = xyz[marker, frame]
    uv = [project(camera, points) + (0 if offset is None else offset[c]) for c, camera in enumerate(rig)]
    counts = np.tile(seen.sum(0), (len(rig), 1))
    detections = Detections.build(rig.names, RATE, counts, np.concatenate([np.zeros((0, 2)), *uv]))
    detection = np.arange(len(points))[:, None] + len(points) * np.arange(len(rig))
    cov = np.broadcast_to(sd**2 * np.eye(3), (len(points), 3, 3))
    start = np.concatenate([[0], np.cumsum(seen.sum(0))])
    tracks = Tracks(Cloud(RATE, start, points, cov, np.zeros(len(points)), detection), marker)
    known = {"cov": np.broadcast_to(sd**2 * np.eye(3), (F, 3, 3)), "cameras": np.full(F, 2 ** len(rig) - 1)}
    paths = [MarkerTrajectory.measured(names[m] if names else f"m{m}", xyz[m], **known) for m in range(M)]
    return {"detections": detections, "tracks": tracks, "trajectories": Trajectories(tuple(paths), RATE)}


ABOUT = {field.name for field in fields(AboutTrial)}
MEASURED = {field.name for field in fields(TrialRecords)}


def judge(rig, records, **more):
    """The figures; more: of the records, of what they are about, or of what is known besides."""
    given = {"session": "S", "trial": "T", "steps": STEPS, "rig": rig, **records, **more}
    about, measured = ({name: given.pop(name) for name in own & set(given)} for own in (ABOUT, MEASURED))
    return quality(TrialRecords(**measured), about=AboutTrial(**about), **given)


def empty_capture(rig, frames):
    detections = Detections.build(rig.names, RATE, np.zeros((len(rig), frames)), np.zeros((0, 2)))
    cloud = Cloud(RATE, np.zeros(frames + 1), np.zeros((0, 3)), np.zeros((0, 3, 3)), [], np.zeros((0, len(rig))))
    return {"detections": detections, "tracks": Tracks(cloud, np.zeros(0)), "trajectories": Trajectories((), RATE)}
