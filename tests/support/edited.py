"""Small scenes whose tracks are edited, and entries of journals."""

from functools import cache

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.edits import Entry
from kinemark.data.track_trajectories import trajectories_of
from kinemark.engine.keys import world_key
from kinemark.track.simultaneous import track_detections
from support.laboratory import observe, ring
from support.motions import swarm

FRAMES = 120


@cache
def scene():
    """A rig, its detections of five markers, their tracks as trajectories, and the key of their world."""
    rig = ring(4)
    detections, _ = observe(rig, swarm(n=5, frames=FRAMES), noise=0.1)
    return rig, detections, trajectories_of(track_detections(detections, rig)), world_key(rig)


def entries(*acts, first=1):
    """Acts, each one edit or several, as entries."""
    acts = [act if isinstance(act, tuple) else (act,) for act in acts]
    return [Entry(first + k, "2026-11-23", "op", "", "1", "", act) for k, act in enumerate(acts)]


def paths_without_images(n=4, frames=200, seed=0, first_frame=1, rate=100.0):
    """Unnamed markers that keep apart, as in a file of another system."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / rate
    phase, away = rng.uniform(0, 6, (n, 3)), rng.permutation(n)[:, None] * 150.0
    xyz = 100 * np.sin(2 * t[None, :, None] + phase[:, None]) + away[:, None] + rng.normal(0, 0.2, (n, frames, 3))
    return Trajectories(
        tuple(MarkerTrajectory.measured(f"*{k + 1}", path) for k, path in enumerate(xyz)), rate, first_frame
    )


def samples(trajectories):
    """Frames that each name has, from 0."""
    return {path.name: np.flatnonzero(path.origin > 0) for path in trajectories}
