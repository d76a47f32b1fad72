"""The local frame of three markers, frame by frame.

With x along the line from the first to the second and z perpendicular to all three, R = (x, z × x, z) and c the centre,
a marker y has the local coordinates Rᵀ(y − c) (1). Three markers carry a frame without iteration, for all frames at
once.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats
from ..numerics.vectors import cross


def triad(points: Floats) -> tuple[Floats, Floats]:
    """R (F, 3, 3) and c (F, 3) mm of three points (3, F, 3); NaN where one is missing or all stand on one line."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x = points[1] - points[0]
        z = cross(x, points[2] - points[0])
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, cross(z, x), z], -1), points.mean(0)


def local(R: Floats, c: Floats, xyz: Floats) -> Floats:
    """(…, F, 3) local coordinates of positions (…, F, 3) (1)."""
    apart = xyz - c
    return (apart.reshape(-1, len(R), 3).swapaxes(0, 1) @ R).swapaxes(0, 1).reshape(apart.shape)
