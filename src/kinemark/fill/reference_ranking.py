"""Reference markers in order: those that keep their distance from a marker move with it."""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints
from ..geometry.rigid_pairs import distances_from
from .marker_array import MarkerArray

FEWEST = 12
"""Frames to learn from, at least; chosen (see benchmarks/gaps.py)."""


class Ranks:
    """The other markers of a trial in order, for each marker worked out when it is first asked for."""

    def __init__(self, motion: MarkerArray) -> None:
        """Of a trial, from some hundreds of its frames."""
        self.thin = np.ascontiguousarray(motion.xyz[:, :: max(1, motion.xyz.shape[1] // 400)])
        self._of: dict[int, Ints] = {}

    def of(self, marker: int) -> Ints:
        """That whose distance from the marker varies least first; only those seen with it often enough."""
        if marker not in self._of:
            self._of[marker] = _ranked(self.thin, marker)
        return self._of[marker]


def ranked(motion: MarkerArray, marker: int) -> Ints:
    """The same of one marker."""
    return Ranks(motion).of(marker)


def _ranked(thin: Floats, marker: int) -> Ints:
    found = distances_from(thin, marker)
    vary, n = found.spread.copy(), found.frames
    vary[(n < FEWEST) | (n < 0.5 * n[marker])] = np.inf
    vary[marker] = np.inf
    order = np.argsort(vary, kind="stable")
    return order[np.isfinite(vary[order])]
