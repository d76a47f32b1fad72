"""Poses of segments as a system without markers gives them."""

import numpy as np

from kinemark.data import Poses


def made_poses(names=("pelvis", "thigh", "shank"), n=40, rate=100.0, start=0.0, seed=4):
    """Proper rotations, translations in mm that single precision holds, and some missing samples."""
    rng = np.random.default_rng(seed)
    T = np.tile(np.eye(4), (len(names), n, 1, 1))
    T[..., :3, :3] = np.linalg.qr(rng.normal(size=(len(names), n, 3, 3)))[0]
    T[..., :3, 3] = rng.normal(0, 500, (len(names), n, 3))
    T, reliability = T.astype(np.float32).astype(float), rng.random((len(names), n)).astype(np.float32).astype(float)
    gone = rng.random((len(names), n)) < 0.1
    T[gone], reliability[gone] = np.nan, -1.0
    return Poses(tuple(names), rate, T, reliability, start)
