"""What Swamidas' tracking gives beside the identities: its predictions, and what became of a model."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Tracks
from ...data.array_types import Bools, Floats, Ints


class PredictedFrame(NamedTuple):
    """One frame before its points were looked at: T tracks' id (T), xyz (T, 3) mm, half (T, 3) mm of the box, and which
    of them (T) an angle model has placed."""

    id: Ints
    xyz: Floats
    half: Floats
    placed: Bools


class ModelUse(NamedTuple):
    """What became of an angle model: whether its markers were recognised among the tracks, in how many frames one of
    them was missing (markers times frames), and in how many of these the model placed it."""

    recognised: bool
    missing: int
    placed: int


class SwamidasResult(NamedTuple):
    """Tracks, and how they came about.

    tracks; by (P) the `Constraint` that gave each point its identity; expected (F) what was predicted in each frame;
    model: what became of the angle model, None without one.
    """

    tracks: Tracks
    by: Ints
    expected: list[PredictedFrame]
    model: ModelUse | None = None

    def path(self, identity: int) -> Floats:
        """(F, 3) mm the points of a track, and its predictions where it has none; NaN before it began."""
        xyz = np.full((len(self.expected), 3), np.nan)
        for f, frame in enumerate(self.expected):
            xyz[f] = next(iter(frame.xyz[frame.id == identity]), np.full(3, np.nan))
        own = self.tracks.id == identity
        xyz[self.tracks.cloud.frame[own]] = self.tracks.cloud.xyz[own]
        return xyz
