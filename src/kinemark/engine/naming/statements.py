"""What a person stated of a trial's names: found among its tracks by place, or by the names of a file's tracks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import KinemarkError, MarkerTrajectory, Trajectories
from ...data.nearest_word import guess, some_names
from ...io.stated_names_csv import StatedName
from ...io.track_names import TrackName
from ...label import Labels
from ...label.labels import State

REACH_MM = 30.0
"""How far a statement's place may be from its track; chosen: it is read off a page, and markers are farther apart."""


class Facts(NamedTuple):
    """The name of each track of which one was stated, None for no marker; and the statements without a track."""

    of: dict[str, str | None]
    lost: tuple[StatedName, ...]


def facts_of(tracks: Trajectories, stated: Sequence[StatedName]) -> Facts:
    """Which tracks the statements of this trial are about: the nearest in the frame."""
    found: dict[str, str | None] = {}
    lost = []
    xyz = tracks.xyz
    for one in stated:
        frame = one.frame - tracks.first_frame
        here = 0 <= frame < tracks.n_frames
        away = np.linalg.norm(xyz[:, frame] - one.place, axis=1) if here else np.zeros(0)
        away = np.where(np.isfinite(away), away, np.inf)
        if away.min(initial=np.inf) <= REACH_MM:
            found[tracks.names[int(away.argmin())]] = one.name or None
        else:
            lost.append(one)
    return Facts(found, tuple(lost))


def labels_of_facts(n_tracks: int) -> Labels:
    """Labels of nothing, for trials that only statements name."""
    none = (None,) * n_tracks
    unknown: State = "unknown"
    state = (unknown,) * n_tracks
    return Labels(none, np.zeros(n_tracks), state, none, np.full(n_tracks, np.nan), np.nan, np.nan)


class StatedTracks(NamedTuple):
    """Tracks, those with statements of some frames cut; and the name of each of which one was stated, None for none."""

    tracks: Trajectories
    stated: dict[str, str | None]


def stated_tracks(trial: Trajectories, statements: Sequence[TrackName]) -> StatedTracks:
    """The tracks of a trial and what is stated of each.

    Raises:
        KinemarkError: a track is not in the trial, a statement is of no sample of it, or two tracks that are seen at
            the same time are said to be one marker.
    """
    for one in statements:
        if one.track not in trial.names:
            raise KinemarkError(
                f"A name is stated of {one.track}, which is no track{guess(one.track, trial.names)}. There are "
                f"{some_names(trial.names)}."
            )
    paths: list[MarkerTrajectory] = []
    stated: dict[str, str | None] = {}
    for path in trial:
        pieces = _cut(path, [one for one in statements if one.track == path.name], trial.first_frame)
        paths += [piece for piece, _ in pieces]
        stated |= {piece.name: one.name for piece, one in pieces if one is not None}
    tracks = replace(trial, paths=tuple(paths))
    _check_apart(tracks, stated)
    return StatedTracks(tracks, stated)


def _cut(
    path: MarkerTrajectory, said: Sequence[TrackName], first_frame: int
) -> list[tuple[MarkerTrajectory, TrackName | None]]:
    """The pieces of a track, each with its statement; the rest without."""
    if not said:
        return [(path, None)]
    F = len(path.xyz)
    owner = np.full(F, -1)
    for k, one in enumerate(said):
        start = 0 if one.first is None else max(one.first - first_frame, 0)
        stop = F if one.last is None else max(one.last - first_frame + 1, 0)
        if not np.isfinite(path.xyz[start:stop]).any():
            raise KinemarkError(
                f"A name is stated of {path.name} in frames {one.first or 1} to {one.last or 'the last'}, where it has "
                "no sample. Correct the frames: they count as the file does, and the first is "
                f"{first_frame}."
            )
        owner[start:stop] = k
    parts = [k for k in range(-1, len(said)) if np.isfinite(path.xyz[owner == k]).any()]
    named = [path.name if len(parts) == 1 else f"{path.name} ({i})" for i in range(1, len(parts) + 1)]
    return [
        (replace(path.only(owner == k), name=name), said[k] if k >= 0 else None)
        for k, name in zip(parts, named, strict=True)
    ]


def _check_apart(tracks: Trajectories, stated: dict[str, str | None]) -> None:
    """No two tracks at once are one marker."""
    seen = {name: np.isfinite(tracks[name].xyz[:, 0]) for name, marker in stated.items() if marker is not None}
    for a in seen:
        for b in seen:
            if a < b and stated[a] == stated[b] and (seen[a] & seen[b]).any():
                k = int(np.flatnonzero(seen[a] & seen[b])[0]) + tracks.first_frame
                raise KinemarkError(
                    f"{a} and {b} are both said to be {stated[a]}, and both are seen in frame {k}. Correct one of them."
                )
