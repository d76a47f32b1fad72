"""Bodies in motion for tests of filling, gaps in them, and how far a fill is from the truth."""

import numpy as np
from scipy.spatial.transform import Rotation

from kinemark.data import MarkerTrajectory, Trajectories, Trial
from kinemark.fill import MarkerArray
from support.motions import body

GAP = slice(40, 60)


def moving(frames=300, markers=8, *, rate=100.0, seed=0, soft=0.0, noise=0.0):
    """A rigid body that turns and goes along; `soft` mm of a wobble that all its markers share, each in its own way."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / rate
    shape = rng.normal(0, 80, (markers, 3))
    turn = Rotation.from_rotvec(np.stack([0.5 * np.sin(2 * t), 0.8 * np.sin(3 * t + 1), 0.3 * t], 1))
    wobble = soft * np.sin(7 * t)[None, :, None] * rng.normal(0, 1, (markers, 1, 3))
    body = shape[:, None] + wobble
    xyz = np.stack([turn.apply(b) for b in body]) + np.stack([900 * t, 50 * np.sin(5 * t), 0 * t], 1)
    xyz += rng.normal(0, noise, xyz.shape) if noise else 0
    return MarkerArray(xyz, rate, tuple(f"M{k}" for k in range(markers)))


def trial(motion):
    return Trajectories(
        tuple(MarkerTrajectory.measured(n, x) for n, x in zip(motion.names, motion.xyz, strict=True)), motion.rate
    )


def off(said, motion, gap):
    return np.linalg.norm(said.xyz - motion.xyz[gap.marker, gap.start : gap.stop], axis=1)


def segment(frames=200, noise=0.3, seed=0):
    """Five markers of a rigid body in motion, (5, F, 3) mm."""
    xyz = body(frames)[:5]
    return xyz + np.random.default_rng(seed).normal(0, noise, xyz.shape)


def with_gap(xyz):
    """The same, the first marker missing in GAP."""
    xyz = xyz.copy()
    xyz[0, GAP] = np.nan
    return xyz


def trial_of(xyz, names="ABCDEFG"):
    paths = tuple(MarkerTrajectory.measured(name, one) for name, one in zip(names, xyz, strict=False))
    return Trial("t", Trajectories(paths, 100.0, 5))


def swaying(markers_=5, frames=600, noise=0.2, bend=0.0, seed=1):
    """A body that turns about itself, whose markers move on it by `bend` mm; and its shape."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames) / 100
    turn = Rotation.from_rotvec(np.stack([0.5 * np.sin(5 * t), 0.3 * np.cos(3 * t), t], 1)).as_matrix()
    shape = rng.normal(0, 90, (markers_, 3))
    own = bend * np.sin(rng.uniform(1, 6, (markers_, 1, 3)) * t[:, None] + rng.uniform(0, 6, (markers_, 1, 3)))
    x = np.einsum("fij,mfj->mfi", turn, shape[:, None] + own) + np.stack([700 * t, 30 * np.sin(6 * t), 0 * t + 900], 1)
    x += rng.normal(0, noise, x.shape)
    return MarkerArray(x, 100.0, tuple(f"M{k}" for k in range(markers_))), shape
