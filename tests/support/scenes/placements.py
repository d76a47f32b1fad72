"""Cameras in the placements that laboratories have, and calibration files that are off."""

import numpy as np

from kinemark.data import Camera, Rig

PLACEMENTS = ("ring", "row", "one side", "toed out", "two heights", "portrait", "off-centre")
MIDDLE = np.array([0.0, 0.0, 950.0])


def looking(place, target):
    """(3, 3) world → camera, upright, at `place` towards `target` in mm."""
    forward = (target - place) / np.linalg.norm(target - place)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(forward, right), forward])


def places(kind, n, distance, rng):
    """(n, 3) mm of the cameras and of what they look at."""
    k = np.arange(n)
    height = 1300 + 900 * rng.random(n)
    target = np.tile(MIDDLE, (n, 1)) + rng.normal(0, 80, (n, 3))
    if kind in ("row", "toed out"):
        width = min(1100 * (n - 1), 6500)
        x = np.linspace(-0.5, 0.5, n) * width
        place = np.stack([x, np.full(n, -distance), height], 1)
        target[:, 0] += (0.25 if kind == "row" else 1.25) * x
        target[:, 1] += 0.0 if kind == "row" else 400.0
        return place, target
    sweep = {"one side": np.deg2rad(130)}.get(kind, 2 * np.pi * (n - 1) / n)
    if n == 2 or (n == 3 and kind != "one side"):
        sweep = np.deg2rad(55 * (n - 1))
    angle = rng.uniform(0, 2 * np.pi) + sweep * (k / max(n - 1, 1)) + rng.normal(0, 0.04, n)
    far = distance * rng.uniform(0.9, 1.1, n)
    if kind == "two heights":
        height = np.where(k % 2, 600.0, 2500.0) + rng.normal(0, 60, n)
    return np.stack([far * np.cos(angle), far * np.sin(angle), height], 1), target


def camera(name, place, target, kind, span, rng):
    """A camera whose image holds about `span` mm at the target."""
    size = np.array([[1280, 1024], [2048, 1088], [752, 582], [1600, 1200]][rng.integers(4)])
    if kind == "portrait":
        size = size[::-1]
    focal = size.min() * np.linalg.norm(target - place) / span * rng.uniform(0.9, 1.25)
    middle = size / 2 + (size * rng.uniform(-0.18, 0.18, 2) if kind == "off-centre" else rng.normal(0, 8, 2))
    R = looking(place, target)
    K = np.array([[focal, 0, middle[0]], [0, focal * rng.uniform(0.99, 1.01), middle[1]], [0, 0, 1]])
    lens = np.array([rng.uniform(-0.12, 0.04), rng.uniform(-0.02, 0.02), *rng.normal(0, 2e-4, 2), 0.0])
    return Camera(name, size, K, R, -R @ place, lens)


def rig(kind, n, distance, rng):
    """The true cameras."""
    there, targets = places(kind, n, distance, rng)
    span = 2500 if kind != "toed out" else 2900
    return Rig(tuple(camera(f"k{c}", there[c], targets[c], kind, span, rng) for c in range(n)), method="made")


def seen(camera, xyz):
    """Pixels (…, 2) of points (…, 3) mm through the lens, NaN behind; and their depths (…) mm."""
    x, y, depth = np.moveaxis(xyz @ camera.R.T + camera.t, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = np.where(depth > 100, x / depth, np.nan), np.where(depth > 100, y / depth, np.nan)
    k1, k2, p1, p2, k3 = camera.distortion
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    uv = np.stack([camera.K[0, 0] * u + camera.K[0, 2], camera.K[1, 1] * v + camera.K[1, 2]], -1)
    return np.where((r2 < 1.2)[..., None], uv, np.nan), depth


def off(true, error_px, rng):
    """The rig as a file states it: turned, shifted and refocused so that images are off by `error_px` RMS."""
    if not error_px:
        return true
    place = rng.uniform([-900, -900, 200], [900, 900, 1800], (300, 3))
    return Rig(tuple(_off(camera, place, error_px, rng) for camera in true), true.method)


def _off(camera, place, error_px, rng):
    """The camera, off by `error_px` RMS at the places (N, 3) mm."""
    direction = rng.normal(size=7) * np.array([1e-3, 1e-3, 2e-3, 3.0, 3.0, 3.0, 1.5e-3])
    size = 1.0
    for _ in range(4):
        wrong = _moved(camera, size * direction)
        there = seen(camera, place)[0]
        rms = np.sqrt(np.nanmean(((seen(wrong, place)[0] - there) ** 2).sum(-1)) / 2)
        size *= error_px / rms
    return _moved(camera, size * direction)


def _moved(camera, by):
    """The camera turned by a small turn (3) rad, moved by (3) mm, its focal lengths times 1 + by[6]."""
    x, y, z = by[:3]
    turn = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0.0]])
    R = np.linalg.qr((np.eye(3) + turn) @ camera.R)[0]
    R = R * np.sign((R * camera.R).sum(0))  # the factor's signs are free
    K = camera.K.copy()
    K[[0, 1], [0, 1]] *= 1 + by[6]
    centre = camera.centre + by[3:6]
    return Camera(camera.name, camera.size, K, R, -R @ centre, camera.distortion)
