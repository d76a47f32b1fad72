"""A small laboratory for tests: cameras about a walkway, made with nothing but the camera model."""

import numpy as np
from scipy.spatial.transform import Rotation

from kinemark.data import Camera, Detections, Rig
from kinemark.geometry import project

LENS = np.array([-0.1, 0.05, 0.001, -0.002, 0.01])


def camera(name: str, centre, target=(0.0, 0.0, 900.0), *, focal=1200.0, lens=LENS, size=(1280, 1024)) -> Camera:
    """A camera at `centre` that looks at `target`, upright."""
    z = np.asarray(target, float) - centre
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    R = np.array([x, np.cross(z, x), z])
    K = np.array([[focal, 0, size[0] / 2], [0, 0.99 * focal, size[1] / 2], [0, 0, 1]])
    return Camera(name, np.array(size), K, R, -R @ np.asarray(centre, float), lens)


def ring(n: int = 6, **options) -> Rig:
    """n cameras in a ring of 4 m about the volume, at changing heights."""
    turns = [Rotation.from_euler("z", 360 / n * i + 10, degrees=True) for i in range(n)]
    places = [turn.apply([4000, 0, 1500 + 400 * (i % 3)]) for i, turn in enumerate(turns)]
    return Rig(tuple(camera(f"c{i}", place, **options) for i, place in enumerate(places)))


def observe(rig: Rig, xyz, *, noise=0.0, rate=100.0, seed=0, cov=None):
    """Detections of points (M, F, 3) in all cameras, in shuffled order, and the point (D) that each one shows.

    A point is seen where its projection is in the image. Covariances are noise², unless `cov` is False.
    """
    rng = np.random.default_rng(seed)
    counts, rows, truth = np.zeros((len(rig), xyz.shape[1]), int), [], []
    for c, cam in enumerate(rig):
        uv = project(cam, xyz)
        inside = ((uv > 0) & (uv < cam.size - 1)).all(-1)
        for f in range(xyz.shape[1]):
            seen = rng.permutation(np.flatnonzero(inside[:, f]))
            counts[c, f] = len(seen)
            rows.append(uv[seen, f] + noise * rng.normal(size=(len(seen), 2)))
            truth.append(seen)
    uv = np.concatenate(rows)
    known = None if cov is False else np.broadcast_to(np.eye(2) * max(noise, 0.01) ** 2, (len(uv), 2, 2))
    return Detections.build(rig.names, rate, counts, uv, known), np.concatenate(truth)


IDEAL = np.zeros(5)


def seen_by(rig, images):
    """Detections of one frame from lists of images, one a camera."""
    counts = [[len(own)] for own in images]
    return Detections.build(rig.names, 100.0, counts, np.concatenate([np.reshape(own, (-1, 2)) for own in images]))
