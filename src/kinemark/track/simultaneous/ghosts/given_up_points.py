"""Points that images of other markers make, which are given up, and those of merged images, which are solved again.

Images of two markers that drift past each other tell `drifting_pairs`, those of one marker half way between two others
`points_between`, and what merged images say of each of their markers `unmarked_merging`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Cloud
from ....data.array_types import Bools, Ints
from ....geometry.weighted_points import usable_points
from ....numerics.returned_memory import return_memory
from ..detection_index import Images
from ..following.candidate_points import intersect
from ..points.neighbouring_points import TrackPoints, smoothed
from ..points.solved_points import Held, Solver, kept_points, precise_enough, solved, taken_out, with_columns
from ..simultaneous_method import Simultaneous
from .chance_meetings import chance_meetings
from .drift_beyond import drifting_beyond
from .drifting_pairs import UsualResiduals, drifting, with_rest, without_strangers
from .exchanged_images import with_exchanged
from .points_between import between_markers
from .standing_reflections import of_reflections
from .unmarked_merging import Merging, inferred_merging


class WithMerging(NamedTuple):
    """Points of tracks ids (P), the images that they show to be of two markers, and the solver that knows of these."""

    held: Held
    ids: Ints
    merging: Merging
    solver: Solver


def with_merging(held: Held, ids: Ints, solver: Solver, method: Simultaneous) -> WithMerging:
    """The points and their tracks, without those between two markers, and those of merged images solved again.

    Args:
        solver: by images as the file marks them.
    """
    return_memory()
    merging = _merging(held[0], ids, solver.working.images, method)
    return_memory()
    images = merging.marked(solver.working.images)
    solver = solver._replace(working=solver.working._replace(images=images))
    held, ids = without_between(held, ids, merging, images)
    return WithMerging(*without_merged(held, ids, merging, solver, images, method), merging, solver)


def _merging(cloud: Cloud, ids: Ints, images: Images, method: Simultaneous) -> Merging:
    """The images that the points of tracks ids (P) show to be of two markers."""
    return inferred_merging(TrackPoints.of(cloud, ids), cloud.detection.T, images, 1 / cloud.rate, method)


def without_between(held: Held, ids: Ints, merging: Merging, images: Images) -> tuple[Held, Ints]:
    """The points and their tracks, without those that merged images make between two markers."""
    return_memory()
    cloud = held[0]
    sound = ~between_markers(TrackPoints.of(cloud, ids), cloud.detection.T, images, merging.resolution)
    del cloud
    return kept_points(held, sound), ids[sound]


def without_reflections(held: Held, ids: Ints, images: Images, gate: float) -> tuple[Held, Ints]:
    """The points and their tracks, without those that reflections that stand still make by chance."""
    sound = ~of_reflections(ids, held[0].detection.T, images, gate)
    return kept_points(held, sound), ids[sound]


def without_merged(
    held: Held, ids: Ints, merging: Merging, solver: Solver, images: Images, method: Simultaneous
) -> tuple[Held, Ints]:
    """The points and their tracks, those of merged images solved again from what these say of each marker.

    Those of fewer than two images of their own are smoothed. Where that is vague, they are given if one image is their
    own and the merging is clear, up to `uncertain_sd`: others are as often a chance meeting of two markers' images.
    """
    if not len(merging.image):
        return held, ids
    frame, T, has = held[0].frame, 1 / held[0].rate, held[0].detection >= 0
    own = has & ~images.merged[held[0].detection]
    which = np.asarray((has & ~own).any(1))
    number, own = has.sum(1), own.sum(1)
    again = _solved_again(held[0], which, merging.told_apart(held[0], ids, solver))
    return_memory()
    rate, start, columns = taken_out(held)
    detection = columns.pop()
    xyz, cov, residual = (columns.pop(0).copy() for _ in range(3))
    xyz[which], cov[which], residual[which] = again.xyz, again.cov, again.residual
    few = which & (own < 2) & np.isfinite(xyz).all(1) & np.isfinite(cov).all((1, 2))
    xyz[few], cov[few] = smoothed(TrackPoints(frame, ids, xyz, cov), few, own >= 2, T, method)
    sure = np.zeros(len(images.uv), bool)
    sure[merging.image[merging.clear]] = True
    clear = own + (has & sure[detection]).sum(1) == number
    clear &= (own == 1) & (np.trace(cov, axis1=1, axis2=2) < method.uncertain_sd**2)
    good = ~which | np.isfinite(xyz).all(1) & (clear | precise_enough(cov, own, method))
    columns = [xyz, cov, residual, detection]
    del xyz, cov, residual, detection
    return [with_columns(rate, np.concatenate([[0], np.cumsum(good)])[start], columns, good)], ids[good]


def _solved_again(cloud: Cloud, which: Bools, solver: Solver) -> Cloud:
    """Some points (P) of a cloud, solved."""
    return solved(cloud.frame[which], cloud.detection[which].T, cloud.xyz[which].T, solver)


def without_drifting(
    held: Held,
    ids: Ints,
    merging: Merging,
    images: Images,
    usual: UsualResiduals,
    solver: Solver,
    method: Simultaneous,
) -> tuple[Held, Ints]:
    """The points and their tracks, without images of other markers, and without those of two images of two markers."""
    if not usual.of:
        return held, ids
    return_memory()
    detection, sound = _without_drifting(held[0], ids, merging, images, usual, method)
    return_memory()
    if (held[0].detection == detection).all():
        return kept_points(held, sound), ids[sound]
    held, sound = _of_fewer_images(held, detection, sound, images, solver, method)
    return held, ids[sound]


def _without_drifting(
    cloud: Cloud, ids: Ints, merging: Merging, images: Images, usual: UsualResiduals, method: Simultaneous
) -> tuple[Ints, Bools]:
    """The detections (P, C) of a cloud without images of other markers, and the points (P) that are not given up."""
    frame, gate, T = cloud.frame, method.gate, 1 / cloud.rate
    detection = without_strangers(frame, ids, cloud.detection.T, images, usual, gate)
    return_memory()
    sound = ~drifting(frame, ids, detection, images, usual, gate)
    rest = np.flatnonzero(sound)  # of these copies none outlives its call
    r = merging.resolution
    sound[rest] = ~drifting_beyond(frame[rest], ids[rest], detection[:, rest], images, usual, r, gate, T)
    return_memory()
    rest = np.flatnonzero(sound)
    detection[:, rest] = with_exchanged(frame[rest], ids[rest], detection[:, rest], images, usual, gate)
    sound[rest] = ~chance_meetings(frame[rest], ids[rest], detection[:, rest], images, usual, r, gate)
    del frame, rest
    return_memory()
    sound = ~with_rest(~sound, ids, (images.own(detection) >= 0).sum(0))
    return np.ascontiguousarray(detection.T), sound


def _of_fewer_images(
    held: Held, detection: Ints, sound: Bools, images: Images, solver: Solver, method: Simultaneous
) -> tuple[Held, Bools]:
    """The sound points (P), solved again where detections (P, C) leave them fewer images, or others, and which of P
    they are."""
    frame, less = held[0].frame, sound & (held[0].detection != detection).any(1)
    rows, own = np.flatnonzero(less), detection[less]
    guess, others = held[0].xyz[rows].T, ((own >= 0) & (own != held[0].detection[rows])).any(1)
    guess[:, others] = intersect(images, own[others].T).xyz
    again = solved(frame[rows], own.T, guess, solver)
    own = ((own >= 0) & ~images.merged[own]).sum(1)
    good = usable_points(again, solver.rig, margin=None) & precise_enough(again.cov, own, method)
    sound[rows[~good]] = False
    place, start = (np.cumsum(sound) - 1)[rows[good]], np.concatenate([[0], np.cumsum(sound)])[held[0].start]
    rate, _, columns = taken_out(held)
    columns[-1] = detection
    del detection
    xyz, cov, residual, detection = (columns.pop(0)[sound] for _ in range(4))
    xyz[place], cov[place], residual[place] = again.xyz[good], again.cov[good], again.residual[good]
    return [Cloud(rate, start, xyz, cov, residual, detection)], sound
