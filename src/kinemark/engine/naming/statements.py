"""What a person stated of a trial's names, found among its tracks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data import Trajectories
from ...io.stated_names_csv import StatedName
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
