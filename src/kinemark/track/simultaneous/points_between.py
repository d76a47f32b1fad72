"""Points between two markers: merged images of both, of several cameras, taken for a third marker.

Where cameras stand side by side, two markers run together in more than one of them at once, and their common images
meet half way between them, as well as those of one marker. In files that mark merged images they say nothing; in others
they make a track. It is told by the two tracks on either side: both lack an image there. With p and p′ where these are
expected in a camera, s_p and s_p′ in each axis, the common image b of markers alike lies at

    b = (p + p′) / 2,   variance s² + (s_p² + s_p′²) / 4 + (SHARE |p − p′|)²                 (1)

as in `unmarked_merging`. A point all of whose images lie there, within GATE standard deviations, is given up, if MOST
of its track lies so.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from ...data.array_types import Bools, Ints
from ...numerics.runs import equal_runs
from .detection_index import Images
from .near_held import NearHeld, near_held
from .neighbouring_points import TrackPoints
from .unmarked_merging import SHARE

GATE = 3.0
"""Standard deviations of (1); chosen: as many as an image of both is hardly ever off."""

MOST = 0.5
"""Of a track, a share; chosen: single points given up break tracks of markers, as one of `gait9` that then goes over to
another marker for 90 frames."""


def between_markers(points: TrackPoints, detection: Ints, images: Images, r: float) -> Bools:
    """(P) the points with detections (C, P) that lie between two others (1), where images nearer than r px are one."""
    out = np.zeros(len(points.id), bool)
    if not r:
        return out
    said: Counter[tuple[int, int, int]] = Counter()
    for near in near_held(points, detection, images, r):
        near = near.take(np.lexsort([near.other, near.image]))
        cuts = equal_runs(near.image)
        for k in np.flatnonzero(np.diff(cuts) > 1).tolist():
            i, j = cuts[k] + np.array(np.triu_indices(cuts[k + 1] - cuts[k], 1))
            good = _middle(near.take(i), near.take(j), images)
            i, j = i[good], j[good]
            said.update(zip(near.holder[i].tolist(), near.other[i].tolist(), near.other[j].tolist(), strict=True))
    number = (detection >= 0).sum(0)
    out[[row for (row, _, _), count in said.items() if count == number[row]]] = True
    return out & (np.bincount(points.id, out) >= MOST * np.bincount(points.id))[points.id]


def _middle(one: NearHeld, other: NearHeld, images: Images) -> Bools:
    """(n) whether the images lie by (1) between the places of one and another point."""
    off = images.uv[one.image].T - (one.uv + other.uv) / 2
    room = images.variance[one.image] + (one.variance + other.variance) / 4
    return np.asarray((off**2).sum(0) < GATE**2 * (room + SHARE**2 * ((one.uv - other.uv) ** 2).sum(0)))
