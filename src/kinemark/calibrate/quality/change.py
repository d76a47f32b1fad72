"""How one calibration differs from another of the same cameras: what a kick, a lens or a new frame changed.

A camera may seem to have moved because the world was measured anew. So the new rig is first laid on the old one by the
turn and shift that best fit the cameras' centres and viewing directions, and only then compared; how far that turn and
shift move the middle of the volume is said apart. A camera that was kicked must not draw the others with it: every
camera alone gives a turn and shift, by its pose, the one that brings the most cameras home is taken, and refined on
those that it brings (`rigid_align`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ...data import Rig
from ...data.array_types import Floats
from ...geometry import project, rigid_align
from .predicted_covariance import visible

AHEAD = 1000.0
"""mm; points so far ahead along the cameras' own axes take part in laying one rig on the other.
Chosen (see studies/calibration_quality.py)."""


class Change(NamedTuple):
    """From an old rig to a new one, for the cameras that both have.

    names: (C); moved: (C) mm; turned: (C) deg; focal: (C) share, 0.01 is 1 % longer; image: (C) px median shift of the
    image of the volume; all once the worlds are laid on each other. world: mm by which the middle of the volume moved.
    """

    names: tuple[str, ...]
    moved: Floats
    turned: Floats
    focal: Floats
    image: Floats
    world: float


def compare(old: Rig, new: Rig, xyz: Floats) -> Change:
    """How `new` differs from `old`, with places (N, 3) mm of the new control volume."""
    names = tuple(name for name in new.names if name in old.names)
    a, b = old.select(names), new.select(names)
    R, t = _laid(b, a) if len(names) >= 2 else (np.eye(3), np.zeros(3))
    image = []
    for before, now in zip(a, b, strict=True):
        seen = xyz[visible(Rig((now,)), xyz)[0]]
        shift = np.linalg.norm(project(now, seen) - project(before, seen @ R.T + t), axis=1)
        image.append(float(np.nanmedian(shift)) if np.isfinite(shift).any() else np.nan)
    centre = xyz.mean(0)
    rotations = [
        scipy.spatial.transform.Rotation.from_matrix(n.R @ R.T @ o.R.T).magnitude() for o, n in zip(a, b, strict=True)
    ]
    return Change(
        names,
        np.linalg.norm(b.centres @ R.T + t - a.centres, axis=1),
        np.degrees(np.array(rotations)),
        np.array([n.K[0, 0] / o.K[0, 0] - 1 for o, n in zip(a, b, strict=True)]),
        np.array(image),
        float(np.linalg.norm(R @ centre + t - centre)),
    )


def _laid(source: Rig, target: Rig) -> tuple[Floats, Floats]:
    """R, t from the world of one rig to that of another with the same cameras."""
    a, b = _marks(source), _marks(target)
    worlds = [(o.R.T @ n.R, o.R.T @ (n.t - o.t)) for o, n in zip(target, source, strict=True)]
    distance = np.array([np.linalg.norm(a @ R.T + t - b, axis=-1).max(1) for R, t in worlds])  # (C worlds, C cameras)
    best = distance[np.median(distance, axis=1).argmin()]
    home = best <= max(3 * float(np.median(best)), 1e-6)
    return rigid_align(a[home].reshape(-1, 3), b[home].reshape(-1, 3))


def _marks(rig: Rig) -> Floats:
    """(C, 4, 3) mm the centre of each camera and a point ahead along each of its axes."""
    return np.array([[camera.centre, *(camera.centre + AHEAD * camera.R)] for camera in rig])
