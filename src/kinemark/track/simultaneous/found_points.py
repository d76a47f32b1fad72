"""Points that a later pass finds, among those that the tracks have."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data import Cloud
from ...data.array_types import Bools, Ints
from ...geometry.weighted_points import usable_points
from .detection_index import Images
from .neighbouring_points import TrackPoints
from .simultaneous_method import Simultaneous
from .solved_points import Solver, precise_enough, solved


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
    frame = np.concatenate([cloud.frame[kept], new.frame[good]])
    ids = np.concatenate([ids[kept], found.id[order][good]])
    by_frame = np.argsort(frame, kind="stable")
    start = np.searchsorted(frame[by_frame], np.arange(cloud.n_frames + 1))
    columns = (
        _joined(getattr(cloud, name), kept, getattr(new, name), good, by_frame)
        for name in ("xyz", "cov", "residual", "detection")
    )
    return Cloud(cloud.rate, start, *columns), ids[by_frame]


def _joined(one: NDArray[Any], kept: Bools, other: NDArray[Any], good: Bools, order: Ints) -> NDArray[Any]:
    """Some rows of one column and some of another, in an order of both; in memory no more than twice."""
    out, old = np.empty((len(order), *one.shape[1:]), one.dtype), order < np.count_nonzero(kept)
    out[old] = one[np.flatnonzero(kept)[order[old]]]
    out[~old] = other[np.flatnonzero(good)[order[~old] - np.count_nonzero(kept)]]
    return out
