"""Tracks cut into pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Origin, Trajectories
from ..data.array_types import Ints


def cut(tracks: Trajectories, cuts: set[tuple[int, int]]) -> tuple[Trajectories, Ints]:
    """Tracks cut before these (track, frame), and (P) which track each piece is of; pieces are called `*3 (1)`, …"""
    paths, of = [], []
    for t, path in enumerate(tracks):
        ends = sorted(frame for one, frame in cuts if one == t)
        part = np.searchsorted(ends, np.arange(len(path)), side="right")
        seen = np.unique(part[path.origin != Origin.MISSING]).tolist()
        pieces = [replace(path.only(part == k), name=f"{path.name} ({i})") for i, k in enumerate(seen, 1)]
        paths += pieces if len(pieces) > 1 else [path]
        of += [t] * max(len(pieces), 1)
    return replace(tracks, paths=tuple(paths)), np.array(of, np.int64)
