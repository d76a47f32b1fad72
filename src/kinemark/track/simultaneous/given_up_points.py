"""Points that images of other markers make, which are given up, and those of merged images, which are solved again.

Images of two markers that drift past each other tell `drifting_pairs`, those of one marker half way between two others
`points_between`, and what merged images say of each of their markers `unmarked_merging`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data import Cloud
from ...data.array_types import Bools, Ints
from ...geometry.weighted_points import usable_points
from ...numerics.returned_memory import return_memory
from .detection_index import Images
from .drift_beyond import drifting_beyond
from .drifting_pairs import UsualResiduals, drifting, with_rest, without_strangers
from .neighbouring_points import TrackPoints, smoothed
from .points_between import between_markers
from .simultaneous_method import Simultaneous
from .solved_points import Solver, precise_enough, solved
from .unmarked_merging import Merging


def without_between(cloud: Cloud, ids: Ints, merging: Merging, images: Images) -> tuple[Cloud, Ints]:
    """The points and their tracks, without those that merged images make between two markers."""
    return_memory()
    sound = ~between_markers(TrackPoints.of(cloud, ids), cloud.detection.T, images, merging.resolution)
    return cloud.keep(sound), ids[sound]


def without_merged(
    cloud: Cloud, ids: Ints, merging: Merging, solver: Solver, images: Images, method: Simultaneous
) -> tuple[Cloud, Ints]:
    """The points and their tracks, those of merged images solved again from what these say of each marker.

    Those of fewer than two images of their own are smoothed. Where that is vague, they are given if one image is their
    own and the merging is clear, up to `uncertain_sd`: others are as often a chance meeting of two markers' images.
    """
    if not len(merging.image):
        return cloud, ids
    solver, rig = merging.told_apart(cloud, ids, solver), solver.rig
    has, own = cloud.detection >= 0, (cloud.detection >= 0) & ~images.merged[cloud.detection]
    which, number, own = (has & ~own).any(1), has.sum(1), own.sum(1)
    again = solved(cloud.frame[which], cloud.detection[which].T, cloud.xyz[which].T, solver)
    del solver
    return_memory()
    xyz, cov, residual = cloud.xyz.copy(), cloud.cov.copy(), cloud.residual.copy()
    xyz[which], cov[which], residual[which] = again.xyz, again.cov, again.residual
    moved = replace(cloud, xyz=xyz, cov=cov, residual=residual)
    few = which & (own < 2) & np.isfinite(xyz).all(1) & np.isfinite(cov).all((1, 2))
    xyz[few], cov[few] = smoothed(TrackPoints(cloud.frame, ids, xyz, cov), few, own >= 2, 1 / cloud.rate, method)
    sure = np.zeros(len(images.uv), bool)
    sure[merging.image[merging.clear]] = True
    clear = own + (has & sure[cloud.detection]).sum(1) == number
    clear &= (own == 1) & (np.trace(cov, axis1=1, axis2=2) < method.uncertain_sd**2)
    good = ~which | usable_points(moved, rig, margin=None) & (clear | precise_enough(moved.cov, own, method))
    columns = [xyz, cov, residual, cloud.detection]
    del moved, xyz, cov, residual
    return _kept(cloud, good, columns), ids[good]


def _kept(cloud: Cloud, kept: Bools, columns: list[NDArray[Any]]) -> Cloud:
    """A cloud of those points that are kept (P), of columns xyz, cov, residual and detection in place of its own, each
    of which ends before the next one is in memory twice."""
    start = np.concatenate([[0], np.cumsum(kept)])[cloud.start]
    return Cloud(cloud.rate, start, *(columns.pop(0)[kept] for _ in range(4)))


def without_drifting(
    cloud: Cloud,
    ids: Ints,
    merging: Merging,
    images: Images,
    usual: UsualResiduals,
    solver: Solver,
    method: Simultaneous,
) -> tuple[Cloud, Ints]:
    """The points and their tracks, without images of other markers, and without those of two images of two markers."""
    if not usual.of:
        return cloud, ids
    return_memory()
    detection = without_strangers(cloud.frame, ids, cloud.detection.T, images, usual, method.gate)
    return_memory()
    sound = ~drifting(cloud.frame, ids, detection, images, usual, method.gate)
    rest = np.flatnonzero(sound)
    two = cloud.frame[rest], ids[rest], detection[:, rest], images, usual, merging.resolution, method.gate
    sound[rest] = ~drifting_beyond(*two)
    sound = ~with_rest(~sound, ids, (detection >= 0).sum(0))
    return_memory()
    less = (cloud.detection != detection.T).any(1)
    if not less.any():
        return cloud.keep(sound), ids[sound]
    detection = np.ascontiguousarray(detection.T)
    rows, own = np.flatnonzero(less), detection[less]
    again = solved(cloud.frame[rows], own.T, cloud.xyz[rows].T, solver)
    own = ((own >= 0) & ~images.merged[own]).sum(1)
    good = usable_points(again, solver.rig, margin=None) & precise_enough(again.cov, own, method)
    sound[rows[~good]] = False
    columns, detection = [column[sound] for column in (cloud.xyz, cloud.cov, cloud.residual)], detection[sound]
    place = (np.cumsum(sound) - 1)[rows[good]]
    for column, new in zip(columns, (again.xyz, again.cov, again.residual), strict=True):
        column[place] = new[good]
    start = np.concatenate([[0], np.cumsum(sound)])[cloud.start]
    return Cloud(cloud.rate, start, columns[0], columns[1], columns[2], detection), ids[sound]
