"""What a person stated of a trial's names, found among its tracks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import Trajectories
from ...io.stated_names_csv import StatedName
from ...label import Labels
from ...label.labels import State

REACH_MM = 30.0
"""How far a statement's place may be from its track; chosen: it is read off a page, and markers are farther apart."""


class Facts(NamedTuple):
    """The name of each track of which one was stated, empty for no marker; and the statements without a track."""

    of: dict[int, str]
    lost: tuple[StatedName, ...]


def facts_of(tracks: Trajectories, stated: Sequence[StatedName]) -> Facts:
    """Which tracks the statements of this trial are about: the nearest in the frame."""
    found: dict[int, str] = {}
    lost = []
    xyz = tracks.xyz
    for one in stated:
        frame = one.frame - tracks.first_frame
        here = 0 <= frame < tracks.n_frames
        away = np.linalg.norm(xyz[:, frame] - one.place, axis=1) if here else np.zeros(0)
        away = np.where(np.isfinite(away), away, np.inf)
        if away.min(initial=np.inf) <= REACH_MM:
            found[int(away.argmin())] = one.name
        else:
            lost.append(one)
    return Facts(found, tuple(lost))


def with_facts(labels: Labels, tracks: Trajectories, facts: dict[int, str]) -> Labels:
    """Labels with what was stated, of which nobody is surer; others of that name at the same time lose it."""
    if not facts:
        return labels
    seen = np.isfinite(tracks.xyz[..., 0])
    names, probability, state = list(labels.names), labels.probability.copy(), list(labels.state)
    for track, name in facts.items():
        for k in range(len(names)):
            if k not in facts and names[k] == name and name and (seen[k] & seen[track]).any():
                names[k], probability[k], state[k] = None, 0.0, "unknown"
        names[track], probability[track], state[track] = name or None, float(bool(name)), "sure" if name else "unknown"
    return replace(labels, names=tuple(names), probability=probability, state=tuple(state))


def labels_of_facts(n_tracks: int) -> Labels:
    """Labels of nothing, for trials that only statements name."""
    none = (None,) * n_tracks
    unknown: State = "unknown"
    state = (unknown,) * n_tracks
    return Labels(none, np.zeros(n_tracks), state, none, np.full(n_tracks, np.nan), np.nan, np.nan)
