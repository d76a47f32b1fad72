"""One force plate made into two that lie side by side, with the same load on both together."""

from dataclasses import replace

import numpy as np

from kinemark.data import Analog, ForcePlate
from kinemark.gait import reaction

SENSOR_MM = 40.0
REACH_MM = 30.0
"""How far the foot presses before and behind the centre of pressure."""
AXES = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])


def split(trial, plate, *, edge_mm, axis=0):
    """The trial with one of its plates cut at `edge_mm` along x (axis 0) or y (1), and no other plates.

    The pressure is even over `REACH_MM` to both sides of its centre, so that both plates' forces and moments add up to
    those of the one.
    """
    own, record = trial.plates[plate], next(a for a in trial.analog if trial.plates[plate].channels[0] in a.names)
    fine = reaction(
        own, [replace(record, start=0.0)], n_frames=record.values.shape[1], rate=record.rate, threshold_n=0.5,
        averaged=False, zeroed=True,
    )  # fmt: skip
    low, high = own.corners.min(0), own.corners.max(0)
    s = fine.centre[:, axis]
    front = np.nan_to_num(np.clip((s + REACH_MM - edge_mm) / (2 * REACH_MM), 0.0, 1.0))
    ends = (
        (np.minimum(edge_mm, s + REACH_MM) + s - REACH_MM) / 2,
        (np.maximum(edge_mm, s - REACH_MM) + s + REACH_MM) / 2,
    )
    plates, channels = [], []
    for k, share in enumerate((1.0 - front, front)):
        a, b = low.copy(), high.copy()
        (b if k == 0 else a)[axis] = edge_mm
        centre = fine.centre.copy()
        centre[:, axis] = ends[k]
        middle = (a + b) / 2
        corners = np.array([[b[0], a[1], 0], [b[0], b[1], 0], [a[0], b[1], 0], [a[0], a[1], 0]])[[1, 0, 3, 2]]
        force = -(share[:, None] * np.nan_to_num(fine.force)) @ AXES
        at = np.nan_to_num(centre - middle) @ AXES
        free = -(share[:, None] * np.nan_to_num(fine.free_moment)) @ AXES * 1000.0
        moment = np.cross(at * (1, 1, 0) - [0.0, 0.0, SENSOR_MM], force) + free
        names = tuple(f"{name}S{k}" for name in ("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
        plates.append(ForcePlate(2, corners, np.array([0.0, 0.0, -SENSOR_MM]), names))
        channels.append(np.concatenate([force, moment], 1).T)
    names = sum((one.channels for one in plates), ())
    block = Analog(names, ("N", "N", "N", "N·mm", "N·mm", "N·mm") * 2, record.rate, np.concatenate(channels))
    return replace(trial, plates=tuple(plates), analog=(replace(block, start=record.start),))
