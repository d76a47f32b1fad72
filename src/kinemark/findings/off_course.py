"""Whether the frame rate tells markers apart: how far they leave their course, against how near they are to others.

From one frame to the next a marker goes on as it did, but for

    a = |x(t+1) − 2 x(t) + x(t−1)|                                                          (1)

which nothing but the next image tells. Where a is more than half of the distance d to the nearest other track, its
image lies nearer to where the other would be than chance and motion can part (2): what is tracked then is a guess, at
whatever precision. Points whose own noise makes such an a, 6 times the variance of x, do not count (3).
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..data import Tracks
from ..data.array_types import Floats, Ints
from ..numerics.evenly import scattered
from .plain import share

CLEAR = 3.0
"""Standard deviations of noise that a exceeds (3); conventional."""

LOOKED_AT = 1000
"""Frames in which points are looked at; chosen: of ten markers the share is then known to 0.01."""


def off_course_share(tracks: Tracks) -> float:
    """Share of the points that leave the course of their track by more than half of the distance to another one, by
    (2), of those that have one a frame before and after; NaN without any."""
    cloud = tracks.cloud
    order = np.lexsort([cloud.frame, tracks.id])
    id, frame = tracks.id[order], cloud.frame[order]
    middle = 1 + np.flatnonzero((id[:-2] >= 0) & (id[2:] == id[:-2]) & (frame[2:] - frame[:-2] == 2))
    middle = middle[np.isin(frame[middle], scattered(cloud.n_frames, LOOKED_AT))]
    xyz = cloud.xyz[order]
    a = np.linalg.norm(xyz[middle + 1] - 2 * xyz[middle] + xyz[middle - 1], axis=1)  # (1)
    noise = np.sqrt(6 * np.trace(cloud.cov[order[middle]], axis1=1, axis2=2))
    off = (a > CLEAR * noise) & (a > _nearest(xyz, frame, middle) / 2)
    return share(float(off.sum()), len(middle))


def _nearest(xyz: Floats, frame: Ints, rows: Ints) -> Floats:
    """(n) mm from some points to the nearest other of their frame; endless where there is none."""
    out, by_frame = np.full(len(rows), np.inf), np.argsort(frame, kind="stable")
    for f in np.unique(frame[rows]).tolist():
        own = by_frame[slice(*np.searchsorted(frame, [f, f + 1], sorter=by_frame))]
        asked = frame[rows] == f
        if len(own) > 1:
            out[asked] = np.asarray(cKDTree(xyz[own]).query(xyz[rows[asked]], k=2)[0])[:, 1]
    return out
