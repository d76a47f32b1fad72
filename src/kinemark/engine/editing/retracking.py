"""The stage `retrack`: tracks made again with what people said as facts. There is one where somebody asked for it.

Facts are the entries of the journal that count up to the last that says to track again; what is said later is applied
by the stage `edit` alone, until somebody asks again. Facts are found in the tracks as any edit is, by witnesses, so
that they are facts of whatever tracks the trial has by then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...data import Detections, Origin, Rig, Tracks, Trajectories
from ...data.array_types import Bools, Ints
from ...data.edits import Claim, Edit, Entry, Erase, ImagePoint, Put, TrackAgain, facts_of
from ...edit import replay
from ...edit.claims import claims_that_hold
from ...edit.values import ALONE
from ...edit.votes import nearest_images
from ...reconstruct import LeastSquares, image_errors
from ...track import to_trajectories
from ...track.simultaneous import AmbiguousDecision, Simultaneous
from ...track.simultaneous.facts import NO_MARKER, UNSAID, Facts, Mended, mended_tracks
from ...track.simultaneous.points.neighbouring_points import TrackPoints
from ..graph import Records, Stage
from ..keys import world_key
from ..sources import TrialSource
from ..tracking_in_time import Tracked
from ..tracking_stage import load_tracked, save_tracked
from ..trial_inputs import detections_of, trial_rig
from .journal import Journal

FILES = ("retracked.h5", "retracked.json")


def retrack_stage(source: TrialSource, trial: str, rig: Rig, track: Any, reconstruct: Any) -> list[Stage[Any]]:
    """The stage, in a list that is empty where nobody asked for it; `track` and `reconstruct` are the methods."""
    entries = facts_of(Journal.of(source.of.root, trial).read().entries)
    if not entries:
        return []
    given = world_key(rig), [entry.edits for entry in entries], reconstruct
    compute = partial(_compute, entries)
    return [Stage("retrack", ("detect", "track"), FILES, compute, save_tracked, load_tracked, track, given)]


def _compute(entries: tuple[Entry, ...], inputs: Any, records: Records) -> Tracked:
    """The stage."""
    detections, tracked, cameras = detections_of(records), records["track"], trial_rig(records)
    method, place = inputs.settings.track, inputs.settings.reconstruct
    method = method if isinstance(method, Simultaneous) else Simultaneous()
    place = place if isinstance(place, LeastSquares) else LeastSquares()
    first = inputs.source.of.first_frame
    facts = facts_of_tracks(
        tracked.tracks, entries, detections, cameras.rig, first_frame=first, world=world_key(inputs.rig),
        timed=cameras.timed(detections), left_out=cameras.left_out_of(first),
    )  # fmt: skip
    margin = place.volume_margin if place.within_volume else None
    mended = mended_tracks(
        cameras.seen(detections), cameras.rig, tracked.tracks, facts, method=method, errors=image_errors(place),
        volume_margin=margin,
    )  # fmt: skip
    return Tracked(mended.tracks, _decisions(tracked.ambiguous_decisions, mended), tracked.diagnostics)


def _decisions(decisions: Sequence[AmbiguousDecision], mended: Mended) -> tuple[AmbiguousDecision, ...]:
    """The decisions about tracks that are still there, by their numbers now."""
    became = {-1: -1, **dict(enumerate(mended.became.tolist()))}
    now = [(one, tuple(became[t] for t in one.tracks)) for one in decisions]
    return tuple(
        replace(one, tracks=tracks) for one, tracks in now if [t < 0 for t in tracks] == [t < 0 for t in one.tracks]
    )


def facts_of_tracks(
    tracks: Tracks,
    entries: Sequence[Entry],
    detections: Detections,
    rig: Rig,
    *,
    first_frame: int = 1,
    world: str | None = None,
    timed: Detections | None = None,
    left_out: tuple[tuple[str, int, int], ...] = (),
) -> Facts:
    """What entries say of the points of some tracks and of the images behind them.

    Args:
        tracks: of a trial. entries: of its journal. rig: the cameras of the tracks.
        detections, timed: as recorded, and at the times of the frames, as `replay` has them, and `left_out`.
        first_frame: its number. world: key of the world that these are in; that of the rig where None.
    """
    world = world_key(rig) if world is None else world
    said = [edit for entry in entries for edit in entry.edits]
    asked = [edit for edit in said if isinstance(edit, TrackAgain)]
    claims = [*(asked[-1].names if asked else ()), *(edit for edit in said if isinstance(edit, Claim))]
    trajectories = replace(to_trajectories(tracks, rig), first_frame=first_frame)
    frame = tracks.cloud.frame
    of = claims_that_hold(trajectories, claims, detections, world=world)
    numbers = {name: n for n, name in enumerate(dict.fromkeys(one.name for one in claims if one.name is not None))}
    claim = of[tracks.id, frame] if len(of) else np.full(len(frame), -1)
    each = np.array([*(NO_MARKER if one.name is None else numbers[one.name] for one in claims), UNSAID])
    marker = each[claim]
    values = [edit for edit in said if isinstance(edit, Erase | Put | ImagePoint)]
    behind: dict[str, Any] = {
        "detections": detections,
        "timed": timed,
        "rig": rig,
        "world": world,
        "left_out": left_out,
    }
    edited, standing = _with_standing(trajectories, claims, values, behind)
    return Facts(
        marker,
        claim,
        _erased(standing, numbers, marker, frame + first_frame),
        _owned(standing, numbers, detections, first_frame),
        _places(standing, edited, numbers),
    )


def _with_standing(
    trajectories: Trajectories, claims: Sequence[Edit], values: Sequence[Edit], behind: dict[str, Any]
) -> tuple[Trajectories, list[Edit]]:
    """The trial with claims and edits of values, and those of the latter that find their place, of their markers.

    An image alone is no place, and is its marker's all the same: tracking may have others, or the next one was given.
    """
    entries = [Entry(k + 1, "", "", "", "", "", (edit,)) for k, edit in enumerate((*claims, *values))]
    edited = replay(trajectories, entries, **behind)
    done = edited.applied[len(claims) :]
    kept = (one for one in done if one.outcome in ("held", "thin", "moot") or one.reason == ALONE.reason)
    return edited.trajectories, [one.edit for one in kept]


def _erased(standing: Sequence[Edit], numbers: dict[str, int], marker: Ints, frame: Ints) -> Bools:
    """(P) the points, of markers in frames (P), that were erased."""
    wrong = np.zeros(len(frame), bool)
    for edit in standing:
        if isinstance(edit, Erase) and edit.marker in numbers:
            wrong |= (marker == numbers[edit.marker]) & (frame >= edit.first) & (frame <= edit.last)
    return wrong


def _owned(standing: Sequence[Edit], numbers: dict[str, int], detections: Detections, first_frame: int) -> Ints:
    """(D) the marker whose an image is."""
    owner = np.full(len(detections), UNSAID)
    for edit in standing:
        if not isinstance(edit, ImagePoint) or edit.camera not in detections.cameras:
            continue
        at = np.array([edit.frame - first_frame])
        if 0 <= at[0] < detections.n_frames:
            camera = np.array([detections.cameras.index(edit.camera)])
            row = int(nearest_images(camera, at, np.array([[edit.u, edit.v]]), detections)[0])
            if row >= 0:
                owner[row] = NO_MARKER if edit.marker is None else numbers.get(edit.marker, UNSAID)
    return owner


def _places(standing: Sequence[Edit], edited: Trajectories, numbers: dict[str, int]) -> TrackPoints:
    """Where markers are by hand, or by images that were corrected."""
    found = {}
    for spot in standing:
        if not isinstance(spot, Put | ImagePoint) or spot.marker not in numbers or spot.marker not in edited.names:
            continue
        path, at = edited[spot.marker], spot.frame - edited.first_frame
        if 0 <= at < len(path) and path.origin[at] != Origin.MISSING and np.isfinite(path.cov[at]).all():
            found[numbers[spot.marker], at] = path.xyz[at], path.cov[at]
    keys = np.array(list(found), np.int64).reshape(-1, 2)
    xyz = np.array([xyz for xyz, _ in found.values()]).reshape(-1, 3)
    return TrackPoints(keys[:, 1], keys[:, 0], xyz, np.array([cov for _, cov in found.values()]).reshape(-1, 3, 3))
