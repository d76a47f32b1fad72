"""Whether two tracks are two markers: some camera has an image of each.

Images of one marker that do not fit one another, by an error of the calibration or of a centroid, can make two tracks
a few mm apart. Each then lacks an image in just those cameras in which the other has one, as merged markers do. But
of two markers that merge in some cameras, others have an image of each, or have had one before.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Ints
from .neighbouring_points import TrackPoints

FRAMES = 3
"""Frames in which a camera has an image of either track; chosen: by chance, as by a false image, fewer have."""


class SeenApart:
    """Tells of pairs of tracks whether a camera shows them apart; each pair is looked at once."""

    def __init__(self, points: TrackPoints, detection: Ints) -> None:
        """Of the P points of all tracks and their images detection (C, P), −1 for none."""
        self._order = np.lexsort([points.frame, points.id])
        self._id, self._frame, self._detection = points.id[self._order], points.frame[self._order], detection
        self._known: dict[tuple[int, int], bool] = {}

    def __call__(self, first: Ints, second: Ints) -> Bools:
        """(N) whether tracks first and second (N) have images of their own in one camera, in FRAMES and more."""
        pairs, which = np.unique(np.stack([first, second]), axis=1, return_inverse=True)
        said = [self._asked(one, other) for one, other in pairs.T.tolist()]
        return np.array(said, bool)[which.ravel()]

    def _asked(self, first: int, second: int) -> bool:
        if (first, second) not in self._known:
            self._known[first, second] = self._known[second, first] = self._apart(first, second)
        return self._known[first, second]

    def _apart(self, first: int, second: int) -> bool:
        one, other = (slice(*np.searchsorted(self._id, [k, k + 1])) for k in (first, second))
        _, i, j = np.intersect1d(self._frame[one], self._frame[other], assume_unique=True, return_indices=True)
        both = self._detection[:, self._order[one][i]] >= 0
        both &= self._detection[:, self._order[other][j]] >= 0
        return bool(np.count_nonzero(both.any(0)) >= FRAMES)
