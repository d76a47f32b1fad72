"""Points that a later pass finds, among those that the tracks have."""

from __future__ import annotations

import numpy as np

from ...data import Cloud
from ...data.array_types import Bools, Ints
from ...geometry.weighted_points import usable_points
from .detection_index import Images
from .neighbouring_points import TrackPoints
from .simultaneous_method import Simultaneous
from .solved_points import Solver, precise_enough, solved, with_points


def with_found(
    cloud: Cloud,
    ids: Ints,
    kept: Bools,
    found: TrackPoints,
    detection: Ints,
    images: Images,
    solver: Solver,
    method: Simultaneous,
) -> tuple[Cloud, Ints]:
    """The points that are kept (P), their tracks, and those that were found, solved from detections (C, N)."""
    order = np.argsort(found.frame, kind="stable")
    detection = detection[:, order]
    new = solved(found.frame[order], detection, found.xyz[order].T, solver)
    own = ((detection >= 0) & ~images.merged[detection]).sum(0)
    good = usable_points(new, solver.rig, margin=None) & precise_enough(new, own, method)
    return with_points(cloud, ids, new, found.id[order], kept=kept, good=good)
