"""Whether two tracks are two markers: some camera has an image of each.

Images of one marker that do not fit one another, by an error of the calibration or of a centroid, can make two tracks
a few mm apart. Each then lacks an image in just those cameras in which the other has one, as merged markers do. But
of two markers that merge in some cameras, others have an image of each, or have had one before, or are so placed that
one marker would have two images in them.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .neighbouring_points import TrackPoints

FRAMES = 3
"""Frames in which a camera has an image of either track; chosen: by chance, as by a false image, fewer have."""


class SeenApart:
    """Tells of pairs of tracks whether a camera shows them apart; each pair is looked at once."""

    def __init__(self, points: TrackPoints, detection: Ints, P: Floats, r: float) -> None:
        """Of the P points of all tracks and their images detection (C, P), −1 for none; cameras P (C, 3, 4), which tell
        images apart that are r px from each other."""
        self._xyz, self._P, self._r = points.xyz, P, r
        self._order = np.lexsort([points.frame, points.id])
        self._id, self._frame, self._detection = points.id[self._order], points.frame[self._order], detection
        self._known: dict[tuple[int, int], bool] = {}

    def __call__(self, first: Ints, second: Ints) -> Bools:
        """(N) whether tracks first and second (N) have images of their own in one camera, in FRAMES and more, or are so
        far apart that some camera would show two images of one marker."""
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
        i, j = self._order[one][i], self._order[other][j]
        both = (self._detection[:, i] >= 0) & (self._detection[:, j] >= 0)
        return bool(np.count_nonzero(both.any(0)) >= FRAMES) or self._far(i, j)

    def _far(self, i: Ints, j: Ints) -> bool:
        """Whether points i and j (n) of two tracks are farther apart than r in some camera, in half of the frames."""
        uv = [_projected(self._P, self._xyz[rows]) for rows in (i, j)]
        return bool(len(i) and np.median(np.linalg.norm(uv[0] - uv[1], axis=-1), axis=1).max() > self._r)


def _projected(P: Floats, xyz: Floats) -> Floats:
    """(C, n, 2) px of points (n, 3) mm."""
    x = xyz @ P[:, :, :3].transpose(0, 2, 1) + P[:, None, :, 3]
    return np.asarray(x[..., :2] / x[..., 2:])
