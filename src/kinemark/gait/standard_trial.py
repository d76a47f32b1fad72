"""A trial as the gait model wants it: its markers by the model's names, z upwards, heels where only standing wore them.

Up is the axis of the laboratory that goes from the ankles to the pelvis. A heel that is not worn while walking sits on
the foot where the standing trial had it:

    h = a + Q Qₛᵀ (hₛ − aₛ),   Q from ankle a, toe and knee in a frame of the walk, Qₛ standing, medians          (1)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ..data import KinemarkError, MarkerTrajectory, Origin, Trial
from ..data.array_types import Floats
from ..data.subject_measures import LETTER
from .clusters import Clusters, carried_landmarks, check_clusters, with_wands
from .gait_trial import marker_points
from .marker_names import model_names, with_model_names
from .segments import level_axes, unit, upright

Up = Literal["auto", "x", "y", "z", "-x", "-y", "-z"]
STEEP = 0.8
"""Least part of the way from ankles to pelvis along an axis, as a share, for the axis to be up; chosen: walkers lean
by less than 0.05, a laboratory that stands askew by 45° is 0.71."""


class StandardTrial(NamedTuple):
    """A trial for the gait model.

    Attributes:
        trial: by the model's names, z up, nothing else changed.
        turn: (3, 3) that brings vectors (…, 3) of the laboratory to it.
        known: the trial's name of each of the model's markers. heels: that were taken from the standing trial.
    """

    trial: Trial
    turn: Floats
    known: Mapping[str, str]
    heels: tuple[str, ...] = ()


def standard_trial(
    trial: Trial, *, markers: Mapping[str, str] | None = None, up: Up = "auto", turn: Floats | None = None
) -> StandardTrial:
    """The trial as the model wants it; the same trial where it is so.

    Args:
        trial: with named markers, mm.
        markers: the trial's name by the model's, of those that `model_names` does not know.
        up: the axis of the laboratory; as the markers show where "auto".
        turn: (3, 3) of another trial of the laboratory, in place of `up`.

    Raises:
        KinemarkError: a stated marker is not there, or no axis is up.
    """
    known = model_names(trial.trajectories.names, markers)
    named = replace(trial, trajectories=with_model_names(trial.trajectories, known))
    if turn is None:
        turn = level_axes(axis_of(up) if up != "auto" else up_shown(marker_points(named)))
    if np.array_equal(turn, np.eye(3)):
        return StandardTrial(named, turn, known)
    return StandardTrial(turned(named, turn), turn, known)


def up_shown(points: Mapping[str, Floats]) -> Floats:
    """(3) the axis from the ankles to the pelvis; z where markers are missing, which is said elsewhere.

    Args:
        points: (F, 3) mm by the model's names.

    Raises:
        KinemarkError: it is along no axis.
    """
    wanted = ("LASI", "RASI", "LANK", "RANK")
    if not set(wanted) <= set(points):
        return axis_of("z")
    seen = [points[name][np.isfinite(points[name]).all(1)] for name in wanted]
    if not all(len(xyz) for xyz in seen):
        return axis_of("z")
    left, right, *ankles = (np.median(xyz, axis=0) for xyz in seen)
    way = unit((left + right) / 2 - (ankles[0] + ankles[1]) / 2)
    k = int(np.abs(way).argmax())
    if abs(way[k]) < STEEP:
        raise KinemarkError(
            f"From the ankles to the pelvis it goes by {', '.join(f'{x:.2f}' for x in way)} along x, y and z, so that "
            "no axis is up. Turn the laboratory's axes so that one is, or say which is meant: --up z."
        )
    return np.asarray(np.sign(way[k]) * np.eye(3)[k])


def with_heels(walk: StandardTrial, stood: Mapping[str, Floats]) -> StandardTrial:
    """The walk with the heels (1) that only the standing trial has.

    Args:
        walk: to be completed. stood: (F, 3) mm of the standing trial by the model's names.
    """
    points, added = marker_points(walk.trial), []
    for letter in LETTER.values():
        names = [letter + part for part in ("ANK", "TOE", "KNE")]
        if letter + "HEE" in points or letter + "HEE" not in stood or not set(names) <= set(points) & set(stood):
            continue
        Q, Qs = (_foot_axes(*(each[name] for name in names)) for each in (points, stood))
        local = np.einsum("fji,fj->fi", Qs, stood[letter + "HEE"] - stood[names[0]])
        if not np.isfinite(local).all(1).any():
            continue
        added.append(_filled(letter + "HEE", points[names[0]] + Q @ np.nanmedian(local, axis=0)))
    return _with(walk, added)._replace(heels=tuple(path.name for path in added)) if added else walk


def with_landmarks(walk: StandardTrial, stood: Mapping[str, Floats], clusters: Clusters) -> StandardTrial:
    """The walk with the landmarks of its segments that it does not wear, where clusters carry them.

    Args:
        walk: to be completed. stood: (F, 3) mm of the standing trial by the model's names. clusters: at least one.

    Raises:
        KinemarkError: a cluster's marker is in one of both not there, or a cluster cannot be calibrated.
    """
    points = marker_points(walk.trial)
    check_clusters(clusters, points, "walk")
    carried = carried_landmarks(points, with_wands(stood), clusters)
    return _with(walk, [_filled(name, xyz) for name, xyz in carried.items() if name not in points])


def _with(walk: StandardTrial, added: Sequence[MarkerTrajectory]) -> StandardTrial:
    paths = (*walk.trial.trajectories.paths, *added)
    return walk._replace(trial=replace(walk.trial, trajectories=replace(walk.trial.trajectories, paths=paths)))


def _filled(name: str, xyz: Floats) -> MarkerTrajectory:
    """A marker that nobody wears in this trial, at (F, 3) mm."""
    path = MarkerTrajectory.measured(name, xyz)
    origin = np.where(path.origin == Origin.MISSING, Origin.MISSING, Origin.FILLED)
    return replace(path, origin=origin.astype(np.uint8))


def in_laboratory(values: Floats, turn: Floats) -> Floats:
    """(…, 3) vectors of a standard trial in the axes of its laboratory."""
    return values @ turn.T


def _foot_axes(ankle: Floats, toe: Floats, knee: Floats) -> Floats:
    """(F, 3, 3) of (1)."""
    return upright(ankle, toe - ankle, knee - ankle).R


def axis_of(up: str) -> Floats:
    """(3) an axis by its name, as "y", "+Y" or "-x"."""
    up = up.lower()
    return np.asarray((-1.0 if up[0] == "-" else 1.0) * np.eye(3)["xyz".index(up[-1])])


def turned(trial: Trial, turn: Floats) -> Trial:
    """Markers and plates in other axes; vectors (…, 3) times `turn`."""
    paths = tuple(replace(p, xyz=p.xyz @ turn, cov=turn.T @ p.cov @ turn) for p in trial.trajectories)
    plates = tuple(replace(plate, corners=plate.corners @ turn) for plate in trial.plates)
    return replace(trial, trajectories=replace(trial.trajectories, paths=paths), plates=plates)
