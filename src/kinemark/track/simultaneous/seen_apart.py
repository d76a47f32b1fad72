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


def seen_apart(points: TrackPoints, detection: Ints, first: Ints, second: Ints) -> Bools:
    """(N) whether pairs of tracks, first and second (N), have images of their own in one camera, in FRAMES and more.

    Args:
        points: the P points of all tracks. detection: (C, P) their images, −1 for none.
    """
    order = np.lexsort([points.frame, points.id])
    ids, frame = points.id[order], points.frame[order]
    pairs, which = np.unique(np.stack([first, second]), axis=1, return_inverse=True)
    begin, end = np.searchsorted(ids, pairs), np.searchsorted(ids, pairs, "right")
    apart = np.zeros(pairs.shape[1], bool)
    for k in range(len(apart)):
        one, other = (slice(begin[side, k], end[side, k]) for side in (0, 1))
        _, i, j = np.intersect1d(frame[one], frame[other], assume_unique=True, return_indices=True)
        both = (detection[:, order[one][i]] >= 0) & (detection[:, order[other][j]] >= 0)
        apart[k] = np.count_nonzero(both.any(0)) >= FRAMES
    return apart[which.ravel()]
