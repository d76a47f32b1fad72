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

from ..data import MarkerTrajectory, Origin, Trial
from ..data.array_types import Floats
from ..data.laboratory_axes import axis_of, level_axes, turned, up_shown
from ..data.marker_sides import without_subject
from ..data.model_markers import LEG_MARKERS, model_names, upper_body_names, with_model_names
from ..data.subject_measures import LETTER
from .clusters import Clusters, carried_landmarks, check_clusters, with_wands
from .gait_trial import marker_points
from .segments import upright

Up = Literal["auto", "x", "y", "z", "-x", "-y", "-z"]


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
    names = trial.trajectories.names
    known = model_names(names, markers)
    known |= upper_body_names(names, known.values())
    named = replace(trial, trajectories=with_model_names(trial.trajectories, known))
    if turn is None:
        turn = level_axes(axis_of(up) if up != "auto" else up_shown(marker_points(named)))
    if np.array_equal(turn, np.eye(3)):
        return StandardTrial(named, turn, known)
    return StandardTrial(turned(named, turn), turn, known)


def with_heels(walk: StandardTrial, stood: Mapping[str, Floats]) -> StandardTrial:
    """The walk with the heels (1) that only the standing trial shows.

    Args:
        walk: to be completed. stood: (F, 3) mm of the standing trial by the model's names.
    """
    points, added = marker_points(walk.trial), []
    for letter in LETTER.values():
        names = [letter + part for part in ("ANK", "TOE", "KNE")]
        if _seen(points, letter + "HEE") or letter + "HEE" not in stood or not set(names) <= set(points) & set(stood):
            continue
        Q, Qs = (_foot_axes(*(each[name] for name in names)) for each in (points, stood))
        local = np.einsum("fji,fj->fi", Qs, stood[letter + "HEE"] - stood[names[0]])
        if not np.isfinite(local).all(1).any():
            continue
        added.append(_filled(letter + "HEE", points[names[0]] + Q @ np.nanmedian(local, axis=0)))
    walk = _without(walk, [path.name for path in added])
    return _with(walk, added)._replace(heels=tuple(path.name for path in added)) if added else walk


def with_absent_leg(trial: StandardTrial) -> StandardTrial:
    """The trial with markers that are never seen in place of a leg of which it has none, where the other leg has some.

    Such a leg is none, or nobody put markers on it: the other one's gait is that of the side that is there.
    """
    names = trial.trial.trajectories.names
    own = {letter: [letter + part for part in LEG_MARKERS] for letter in LETTER.values()}
    bare = [letter for letter, legs in own.items() if not {without_subject(name) for name in names} & {*legs}]
    if len(bare) != 1:
        return trial
    nowhere = np.full((trial.trial.trajectories.n_frames, 3), np.nan)
    return _with(trial, [MarkerTrajectory.measured(name, nowhere) for name in own[bare[0]]])


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


def _without(walk: StandardTrial, names: Sequence[str]) -> StandardTrial:
    """The walk without the markers of these names, which it never shows."""
    kept = tuple(path for path in walk.trial.trajectories if without_subject(path.name) not in names)
    return walk._replace(trial=replace(walk.trial, trajectories=replace(walk.trial.trajectories, paths=kept)))


def _seen(points: Mapping[str, Floats], name: str) -> bool:
    """Whether any frame shows a marker."""
    return name in points and bool(np.isfinite(points[name]).any())


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
