"""Points that a later pass finds, among those that the tracks have."""

from __future__ import annotations

import numpy as np

from ...data import Cloud
from ...data.array_types import Bools, Ints
from ...geometry.weighted_points import usable_points
from ...numerics.returned_memory import return_memory
from .detection_index import Images
from .drifting_pairs import UsualResiduals
from .dropped_tracks import given_back
from .neighbouring_points import TrackPoints
from .passes import Associations
from .rigid_pass import rigid_pass
from .second_pass import second_pass
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
    good = usable_points(new, solver.rig, margin=None) & precise_enough(new.cov, own, method)
    return with_points(cloud, ids, new, found.id[order], kept=kept, good=good)


def with_given_back(
    every: Associations,
    confirmed: Ints,
    cloud: Cloud,
    ids: Ints,
    images: Images,
    usual: UsualResiduals,
    solver: Solver,
    method: Simultaneous,
) -> tuple[Cloud, Ints]:
    """The points and their tracks, with those of dropped tracks that are markers, which nothing is stitched to."""
    rows = given_back(every, confirmed, cloud, ids, images, usual, method.gate) if usual.of else confirmed[:0]
    if not len(rows):
        return cloud, ids
    new = solved(every.frame[rows], every.detection[:, rows], every.xyz[:, rows], solver)
    good = usable_points(new, solver.rig, margin=None) & precise_enough(new.cov, (new.detection >= 0).sum(1), method)
    return with_points(cloud, ids, new, every.id[rows], good=good)


def with_second_pass(
    cloud: Cloud, ids: Ints, images: Images, solver: Solver, method: Simultaneous
) -> tuple[Cloud, Ints]:
    """The points and their tracks after the second pass."""
    return_memory()
    points = TrackPoints.of(cloud, ids)
    kept, found, detection = second_pass(points, cloud.detection.T, images, 1 / cloud.rate, method)
    return_memory()
    return with_found(cloud, ids, kept, found, detection, images, solver, method)


def with_rigid_pass(
    cloud: Cloud, ids: Ints, images: Images, solver: Solver, method: Simultaneous
) -> tuple[Cloud, Ints, Ints]:
    """The points and their tracks after the pass over rigid bodies, and what each track became."""
    again = rigid_pass(TrackPoints.of(cloud, ids), cloud.detection.T, images, 1 / cloud.rate, method)
    kept = again.id >= 0
    if not len(again.found.id) and (again.id == ids).all():
        return cloud, ids, again.became
    return *with_found(cloud, again.id, kept, again.found, again.detection, images, solver, method), again.became
