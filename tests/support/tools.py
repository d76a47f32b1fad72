"""Bodies of four markers each, which move by themselves."""

import numpy as np
import scipy

from kinemark.data import MarkerTrajectory, Trajectories


def tools(shape, seed, *, n=4, frames=200):
    """Bodies of four markers each, which wander and turn by themselves; `shape` says which bodies."""
    rng = np.random.default_rng(shape)
    places = rng.normal(0, 40, (n, 4, 3))
    rng, t = np.random.default_rng([shape, seed]), np.arange(frames) / 100.0
    paths = []
    for k, body in enumerate(places):
        turns = np.array([sum(rng.normal(0, 0.5) * np.sin(2 * t * w + w) for w in (1, 2, 3)) for _ in range(3)]).T
        way = np.array([sum(rng.normal(0, 90) * np.sin(2 * t * w + w) for w in (1, 2)) for _ in range(3)]).T
        xyz = np.einsum("fij,mj->mfi", scipy.spatial.transform.Rotation.from_rotvec(turns).as_matrix(), body)
        xyz += way + rng.normal(0, 150, 3) + rng.normal(0, 0.2, xyz.shape)
        paths += [MarkerTrajectory.measured(f"{'ABCD'[k]}{m}", one) for m, one in enumerate(xyz, 1)]
    return Trajectories(tuple(paths), 100.0)
