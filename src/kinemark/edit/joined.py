"""One path of samples of several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from weakref import WeakValueDictionary

import numpy as np

from ..data import MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Bools

_KNOWN: WeakValueDictionary[object, MarkerTrajectory] = WeakValueDictionary()
"""Paths of pieces, as long as somebody has them: the next version has the same record where the pieces are the same."""


def joined(trajectories: Trajectories, name: str, masks: Sequence[tuple[int, Bools]]) -> MarkerTrajectory:
    """One path of samples of several, no frame of them twice."""
    masks = [one for one in masks if one[1].any()] or masks[:1]
    p, mask = masks[0]
    first = trajectories.paths[p]
    if len(masks) == 1 and first.name == name and np.array_equal(mask, first.origin != Origin.MISSING):
        return first
    pieces = [(trajectories.paths[p], mask) for p, mask in masks]
    key = name, *((path, mask.tobytes()) for path, mask in pieces)
    found = _KNOWN.get(key)
    if found is None:
        _KNOWN[key] = found = _of_pieces(name, pieces)
    return found


def _of_pieces(name: str, pieces: Sequence[tuple[MarkerTrajectory, Bools]]) -> MarkerTrajectory:
    first, mask = pieces[0]
    if len(pieces) == 1 and np.array_equal(mask, first.origin != Origin.MISSING):
        return replace(first, name=name)
    blank = _blank(len(first), max(path.detection.shape[1] for path, _ in pieces))
    for path, mask in pieces:
        for column, values in blank.items():
            source = getattr(path, column)
            if column != "detection" or source.shape[1]:
                values[mask] = source[mask]
    return MarkerTrajectory(name=name, **blank)


def _blank(n: int, cameras: int) -> dict[str, np.ndarray]:
    """Columns of a path without samples."""
    return {
        "xyz": np.full((n, 3), np.nan),
        "cov": np.full((n, 3, 3), np.nan),
        "origin": np.zeros(n, np.uint8),
        "residual": np.full(n, np.nan),
        "cameras": np.zeros(n, np.uint32),
        "detection": np.full((n, cameras), -1, np.int64),
    }
