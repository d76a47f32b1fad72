"""A wand waved above an L-frame: cameras, images and truth by the generator of `scenes`, for calibrations in a room."""

from typing import NamedTuple

import numpy as np

from kinemark.data import Camera, Detections, Rig

from .scenes.placements import looking, places, seen

GAPS = (180.0, 320.0)  # mm, of the wand
ARMS = (600.0, 400.0)  # mm, of the L-frame


class Laboratory(NamedTuple):
    """The true rig in the L-frame's world, what cameras saw of the wand and the L-frame, places (N, 3) mm; noise px."""

    true: Rig
    wand: Detections
    frame: Detections
    places: np.ndarray
    noise: float


def laboratory(seed, *, lens=(True, True, False), height=None, cameras=None, noise=None, frames=500, kind=None):
    """A random one. lens: whether k1, k2 and p1 p2 are there; height: mm of the L-frame; noise: px."""
    rng = np.random.default_rng(seed)
    cameras = int(rng.integers(3, 11)) if cameras is None else cameras
    noise = float(rng.uniform(0.1, 0.5)) if noise is None else noise
    height = float(rng.choice([0.0, 0.0, 750.0, 1200.0])) if height is None else height
    kind = str(rng.choice(["ring", "one side", "two heights"])) if kind is None else kind
    rig = _rig(kind, cameras, lens, rng)
    lengthwise = np.concatenate([[0.0], np.cumsum(GAPS)])
    wand = _sticks(frames, lengthwise, rng)
    corner = np.array([rng.uniform(-300, 100), rng.uniform(-300, 100), height])
    arms = corner + np.array([[0.0, 0, 0], [ARMS[0], 0, 0], [0, ARMS[1], 0]])
    still = np.repeat(arms[None], int(rng.integers(20, 100)), 0)
    moved = Rig(tuple(Camera(c.name, c.size, c.K, c.R, c.t + c.R @ corner, c.distortion) for c in rig), "made")
    grid = np.stack(np.meshgrid([-600, 0, 600], [-600, 0, 600], [600, 1200, 1800]), -1).reshape(-1, 3) - corner
    return Laboratory(moved, _images(rig, wand, noise, rng), _images(rig, still, noise, rng), grid, noise)


def _rig(kind, n, lens, rng):
    there, targets = places(kind, n, rng.uniform(3200, 5000), rng)
    return Rig(tuple(_camera(f"k{c}", there[c], targets[c], lens, rng) for c in range(n)), "made")


def _camera(name, place, target, lens, rng):
    size = np.array([[1280, 1024], [2048, 1088], [752, 582], [1600, 1200]][rng.integers(4)])
    focal = size.min() * np.linalg.norm(target - place) / 3300 * rng.uniform(0.9, 1.1)
    middle = size / 2 + rng.normal(0, 8, 2)
    R = looking(place, target)
    terms = np.array([rng.uniform(-0.15, -0.04), rng.uniform(0.02, 0.08), *rng.choice([-1, 1], 2) * 1.5e-3, 0.0])
    terms *= np.array([lens[0], lens[1], lens[2], lens[2], 0.0])
    return Camera(
        name, size, np.array([[focal, 0, middle[0]], [0, focal, middle[1]], [0, 0, 1.0]]), R, -R @ place, terms
    )


def _sticks(frames, along, rng):
    """(F, K, 3) mm, waved between half a metre and two."""
    t = np.arange(frames) / 25
    phase, rate = rng.uniform(0, 6.28, 5), rng.uniform(0.5, 1.6, 5)
    a = np.sin(t[:, None] * rate + phase)
    middle = np.stack([900 * a[:, 0], 900 * a[:, 1], 1250 + 750 * a[:, 2]], 1)
    turn, tilt = 3 * t * rate[3] + phase[3], 1.3 * a[:, 4]
    way = np.stack([np.cos(turn) * np.cos(tilt), np.sin(turn) * np.cos(tilt), np.sin(tilt)], 1)
    return middle[:, None] + (along - along.mean())[:, None] * way[:, None]


def _images(rig, xyz, noise, rng):
    """What the rig sees of points (F, K, 3) with that noise, in an order of its own in each image."""
    counts, rows = np.zeros((len(rig), len(xyz)), np.int64), []
    for c, camera in enumerate(rig):
        uv = seen(camera, xyz)[0] + noise * rng.normal(size=(*xyz.shape[:2], 2))
        for f in range(len(xyz)):
            with np.errstate(invalid="ignore"):
                inside = ((uv[f] > 2) & (uv[f] < camera.size - 3)).all(-1)
            frame = rng.permutation(uv[f][inside])
            counts[c, f] = len(frame)
            rows.append(frame)
    return Detections.build(rig.names, 25.0, counts, np.vstack(rows))
