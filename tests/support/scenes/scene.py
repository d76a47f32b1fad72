"""What a scene is like, drawn from its seed, and the scene itself."""

from typing import NamedTuple

import numpy as np

from kinemark.data import Detections, Rig

from .bodies import standing, swarm, walker
from .imaging import Optics, images
from .placements import PLACEMENTS, off, rig, seen

DEVELOPMENT = range(150)
FINAL = range(1000, 1100)
FRAMES = 240  # at most, so that a table of all scenes takes minutes


class Scene(NamedTuple):
    """Markers, cameras and their placement, motion, rate in Hz, seconds, optics, px that the file is off."""

    seed: int
    markers: int
    cameras: int
    placement: str
    motion: str
    rate: float
    seconds: float
    optics: Optics
    calibration: float
    treadmill: bool

    def __str__(self):
        noise = f"{self.optics.noise} px{'' if self.optics.stated else ' unstated'}, file {self.calibration} px off"
        merge = f"merging {self.optics.merge:.0f} px{'' if self.optics.marked else ' unmarked'}"
        return (
            f"{self.seed}: {self.markers} markers, {self.cameras} cameras ({self.placement}), {self.motion} "
            f"{self.rate:g} Hz, {noise}, {merge}"
        )


class Made(NamedTuple):
    """The scene, the rig as its file states it, detections, the true paths (M, F, 3) mm; the cameras (M, F) that have
    an image of their own of each sample; the standard deviation (M, F) in mm that these allow; the true rig; and the
    detection (C, M, F) of each sample, which may be of other markers too, −1 for none."""

    scene: Scene
    rig: Rig
    detections: Detections
    xyz: np.ndarray
    own: np.ndarray
    sd: np.ndarray
    true: Rig
    image: np.ndarray


def scene(seed):
    """The scene of a seed."""
    rng = np.random.default_rng([seed, 15])
    cameras = int(rng.choice([2, 3, 4, 4, 4, 6, 6, 8, 10, 12]))
    motion = str(rng.choice(["walk", "walk", "run", "sprint", "jump", "crawl", "arms", "swarm"]))
    slowest = {"sprint": 100, "run": 50, "jump": 50}.get(motion, 25)
    rate = float(rng.choice([r for r in (25, 50, 100, 120, 200, 250) if r >= slowest]))
    treadmill = bool(motion in ("run", "sprint") and rng.random() < 0.5)
    seconds = min({"run": 2.0, "sprint": 1.0}.get(motion, 4.0) if not treadmill else 3.0, FRAMES / rate)
    optics = Optics(
        noise=float(rng.choice([0.1, 0.2, 0.3, 0.5])),
        stated=bool(rng.random() < 0.5),
        merge=float(rng.choice([0, 4, 6, 10])),
        marked=bool(rng.random() < 0.6),
        dropout=float(rng.choice([0.0, 0.01, 0.03])),
        false=float(rng.choice([0.0, 0.5, 2.0])),
    )
    return Scene(
        seed=seed,
        markers=int(rng.choice([15, 39, 60])),
        cameras=cameras,
        placement=str(rng.choice(PLACEMENTS)),
        motion=motion,
        rate=rate,
        seconds=seconds,
        optics=optics,
        calibration=float(rng.choice([0.0, 0.1, 0.3, 1.0])),
        treadmill=treadmill,
    )


def make(scene):
    """The scene of these properties."""
    rng = np.random.default_rng([scene.seed, 16])
    t = np.arange(round(scene.seconds * scene.rate)) / scene.rate
    if scene.motion == "swarm":
        body = swarm(scene.markers, t, rng)
    elif scene.motion == "stand":
        body = standing(scene.markers, t, rng)
    else:
        body = walker(scene.motion, scene.markers, t, rng, scene.treadmill)
    true = rig(scene.placement, scene.cameras, rng.uniform(3200, 5000), rng)
    detections, image, own = images(true, body, scene.rate, scene.optics, rng)
    sd = allowed(true, body.xyz, own, np.hypot(scene.optics.noise, scene.calibration))
    return Made(scene, off(true, scene.calibration, rng), detections, body.xyz, own.sum(0), sd, true, image)


def allowed(true, xyz, own, error):
    """(M, F) mm: standard deviation of all three axes together of points (M, F, 3) mm that the cameras `own` (C, M, F)
    allow whose images are off by `error` px; infinite where fewer than two."""
    N = np.zeros((*xyz.shape[:2], 3, 3))
    for camera, has in zip(true, own, strict=True):
        J = np.stack([(seen(camera, xyz + step)[0] - seen(camera, xyz - step)[0]) / 2 for step in np.eye(3)], -1)
        N += np.where(has[..., None, None], J.swapaxes(-1, -2) @ J, 0.0)
    least = np.linalg.eigvalsh(N)[..., 0] > 1e-9
    cov = np.linalg.inv(np.where(least[..., None, None], N, np.eye(3)))
    return np.where(least, error * np.sqrt(np.trace(cov, axis1=-1, axis2=-2)), np.inf)
