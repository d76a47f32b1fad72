"""How much smaller than people what the cameras look at is.

The lengths, speeds and accelerations of `Simultaneous` are those of people, before cameras some metres away. Hands,
faces, mice and insects are looked at from nearer, and their markers are as much nearer to each other. There the same
lengths reach beyond the neighbours, and points are given that lie anywhere. So parameters that were left as they are
count in proportion to how far the points of the first tracks are from the cameras that see them,

    s = min(1, median depth / USUAL)                                                      (1)

What moves faster than that is learned as ever (`motion_scale`). A larger room has no larger people in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..detection_index import Images
from ..simultaneous_method import DEFAULT, Simultaneous
from .candidate_points import intersect
from .passes import Associations

USUAL = 3000.0
"""mm, of (1); chosen: cameras of a laboratory are farther away from people. Of nine scenes a tenth as large (2100 to
2126 of benchmarks/tracking_scenes.py) swaps and ghosts are about as many with 2500 to 5000, more with 1600."""

LENGTHS = ("process_noise", "velocity_sd", "acceleration_sd", "uncertain_sd", "max_sd")
"""Parameters whose unit has mm in it; by definition."""


def room_scale(images: Images, seen: Associations) -> float:
    """(1), by the points of tracks; 1 where there is none."""
    has = seen.detection >= 0
    xyz = intersect(images, seen.detection).xyz
    depth = np.einsum("ci,is->cs", images.P[:, 2, :3], xyz) + images.P[:, 2, 3:]
    depth = depth[has & (has.sum(0) >= 2) & (depth > 0)]  # NaN is none of these
    return min(1.0, float(np.median(depth)) / USUAL) if len(depth) else 1.0


def scaled(method: Simultaneous, scale: float) -> Simultaneous:
    """The method with the parameters in mm that were left as they are in this proportion."""
    left = [name for name in LENGTHS if getattr(method, name) == getattr(DEFAULT, name)] if scale != 1 else []
    return replace(method, **{name: scale * getattr(method, name) for name in left})
