"""Points that a later pass finds, among those that the tracks have."""

from __future__ import annotations

import numpy as np

from ....data import Cloud
from ....data.array_types import Bools, Ints
from ....geometry.weighted_points import usable_points
from ....numerics.returned_memory import return_memory
from ..bodies.rigid_pass import RigidPass, rigid_pass
from ..detection_index import Images
from ..ghosts.drifting_pairs import UsualResiduals
from ..simultaneous_method import Simultaneous
from .neighbouring_points import TrackPoints
from .remaining_images import tracks_of_remaining
from .second_pass import SecondPass, second_pass
from .solved_points import Held, Solver, precise_enough, solved, with_points


def with_found(
    held: Held,
    ids: Ints,
    kept: Bools,
    found: TrackPoints,
    detection: Ints,
    images: Images,
    solver: Solver,
    method: Simultaneous,
) -> tuple[Held, Ints]:
    """The points that are kept (P), their tracks, and those that were found, solved from detections (C, N)."""
    order = np.argsort(found.frame, kind="stable")
    detection = detection[:, order]
    new = solved(found.frame[order], detection, found.xyz[order].T, solver)
    own = ((detection >= 0) & ~images.merged[detection]).sum(0)
    good = usable_points(new, solver.rig, margin=None) & precise_enough(new.cov, own, method)
    return with_points(held, ids, new, found.id[order], kept=kept, good=good)


def with_remaining(
    held: Held,
    ids: Ints,
    first: int,
    images: Images,
    usual: UsualResiduals,
    resolution: float,
    solver: Solver,
    method: Simultaneous,
) -> tuple[Held, Ints]:
    """The points and their tracks, with new ones, numbered from `first` on, of images that none has."""
    more = bool(usual.of)
    while more:
        return_memory()
        found, more = tracks_of_remaining(held[0], ids, images, usual, resolution, method)
        if not len(found.id):
            break
        new, number = solved(found.frame, found.detection, found.xyz, solver), (found.detection >= 0).sum(0)
        good = usable_points(new, solver.rig, margin=None) & precise_enough(new.cov, number, method)
        more &= bool(good.any())
        held, ids = with_points(held, ids, new, found.id + first, good=good)
        first += int(found.id.max()) + 1
    return held, ids


def with_second_pass(held: Held, ids: Ints, images: Images, solver: Solver, method: Simultaneous) -> tuple[Held, Ints]:
    """The points and their tracks after the second pass."""
    return_memory()
    kept, found, detection = _second_pass(held[0], ids, images, method)
    return_memory()
    return with_found(held, ids, kept, found, detection, images, solver, method)


def with_rigid_pass(
    held: Held, ids: Ints, images: Images, solver: Solver, method: Simultaneous
) -> tuple[Held, Ints, Ints]:
    """The points and their tracks after the pass over rigid bodies, and what each track became."""
    return_memory()
    again = _rigid_pass(held[0], ids, images, method)
    kept = again.id >= 0
    if not len(again.found.id) and (again.id == ids).all():
        return held, ids, again.became
    return *with_found(held, again.id, kept, again.found, again.detection, images, solver, method), again.became


def _second_pass(cloud: Cloud, ids: Ints, images: Images, method: Simultaneous) -> SecondPass:
    """The second pass over a cloud."""
    return second_pass(TrackPoints.of(cloud, ids), cloud.detection.T, images, 1 / cloud.rate, method)


def _rigid_pass(cloud: Cloud, ids: Ints, images: Images, method: Simultaneous) -> RigidPass:
    """The pass over the rigid bodies of a cloud."""
    return rigid_pass(TrackPoints.of(cloud, ids), cloud.detection.T, images, 1 / cloud.rate, method)
