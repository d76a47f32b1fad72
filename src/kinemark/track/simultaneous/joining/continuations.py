"""Which tracks likely go on as others after gaps that are too long for a stitch.

A stitch needs motion (`stitch`), which says nothing after half a second of occlusion, and is made over a second at
most. The distances to others that do not change still tell: by (2) of `stitch`, an earlier track and a later one are
likely one marker where their distances to the same three others agree. Of all pairs of tracks that do not overlap
those of the greatest sum of scores are taken, and of these the ones that are LIKELY times likelier as one marker than
as two. Nothing is joined: a name given to both does that, or a decision of the operator.
"""

from __future__ import annotations

import numpy as np
import scipy

from ....data import Tracks
from ....data.array_types import Ints
from ..points.neighbouring_points import TrackPoints
from .stitch import scores_by_distance

LIKELY = 2 * float(np.log(100.0))
"""A hundred times, in units of twice a natural logarithm; chosen, as for stitches."""

MAX_PAIRS = 5_000
"""Pairs of tracks that are compared at most, those of the shortest gaps; chosen: more take long, and so many fragments
are no recording."""


def continuations(tracks: Tracks) -> Ints:
    """(n, 2) an earlier track and the later one that likely continues it, by the later one's first frame."""
    cloud, named = tracks.cloud, tracks.id >= 0
    points = TrackPoints(cloud.frame[named], tracks.id[named], cloud.xyz[named], cloud.cov[named])
    if not len(points.id):
        return np.zeros((0, 2), np.int64)
    first, last = np.full(len(tracks), cloud.n_frames), np.full(len(tracks), -1)
    np.minimum.at(first, points.id, points.frame)
    np.maximum.at(last, points.id, points.frame)
    a, b = np.nonzero(first > last[:, None])
    near = np.argsort(first[b] - last[a], kind="stable")[:MAX_PAIRS]
    a, b = a[near], b[near]
    if not len(a):
        return np.zeros((0, 2), np.int64)
    table = np.zeros((len(tracks), len(tracks)))
    table[a, b] = np.maximum(scores_by_distance(points, a, b, np.zeros(len(a))), 0.0)
    before, after = scipy.optimize.linear_sum_assignment(table, maximize=True)
    good = table[before, after] > LIKELY
    pairs = np.column_stack([before, after])[good]
    return np.asarray(pairs[np.argsort(first[pairs[:, 1]], kind="stable")])
