"""A trial that has everything a file may hold."""

from dataclasses import replace

import numpy as np

from kinemark.data import Analog, Events, ForcePlate, MarkerTrajectory, Origin, Trajectories, Trial


def made_trial(n=40, m=5, rate=100.0, first_frame=7, seed=1):
    """A trial with gaps, filled samples, residuals, cameras, force plates and events."""
    rng = np.random.default_rng(seed)
    paths = []
    for i in range(m):
        path = MarkerTrajectory.measured(
            f"M{i}",
            rng.normal(0, 600, (n, 3)),
            residual=rng.uniform(0.1, 3, n),
            cameras=rng.integers(1, 128, n),
        )
        xyz, origin = path.xyz.copy(), path.origin.copy()
        residual, cameras = path.residual.copy(), path.cameras.copy()
        xyz[3 + i : 6 + i], origin[3 + i : 6 + i] = np.nan, Origin.MISSING
        origin[20:22] = Origin.FILLED
        residual[origin == Origin.MISSING], residual[20:22] = np.nan, 0
        cameras[origin != Origin.MEASURED] = 0
        paths.append(replace(path, xyz=xyz, origin=origin, residual=residual, cameras=cameras))
    names = tuple(f"{what}{p}" for p in (1, 2) for what in ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
    values = rng.normal(0, 1, (12, n * 4)) * np.geomspace(1e-6, 1e4, 12)[:, None]
    corners = np.array([[0, 0, 0], [400, 0, 0], [400, 600, 0], [0, 600, 0]], float)
    plates = (
        ForcePlate(2, corners, np.array([1.5, -0.5, -40]), names[:6]),
        ForcePlate(4, corners + 700, np.array([1.5, -0.5, -40]), names[6:], np.arange(36.0).reshape(6, 6)),
    )
    return Trial(
        "made",
        Trajectories(tuple(paths), rate, first_frame),
        (Analog(names, ("N",) * 3 + ("Nmm",) * 3 + ("N",) * 3 + ("Nmm",) * 3, rate * 4, values),),
        plates,
        Events(("Foot Strike", "Foot Off"), ("Left", "Right"), np.array([0.25, 61.5])),
    )
