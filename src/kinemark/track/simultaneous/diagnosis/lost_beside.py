"""Tracks that are lost where another one has an image, in files that do not mark merged images.

A track is lost where it runs into another: both are one image, which the other track has. Until it is found again, that
image may be of both, or of either while the other is hidden, and the other track may go on as the lost one. Where the
lost one is expected is known for some frames alone; merged images stay merged until they part. So from where it was
lost to where it is found again no image of that camera tells that the other track goes on as itself.
"""

from __future__ import annotations

import numpy as np

from ....data import Tracks
from ....data.array_types import Bools
from ....native.image_index import ranges
from ..detection_index import Images
from ..ghosts.near_held import near_held
from ..points.neighbouring_points import TrackPoints
from ..points.second_pass import expected_between
from ..simultaneous_method import Simultaneous


def with_lost_ones(tracks: Tracks, images: Images, r: float, method: Simultaneous) -> Bools:
    """(P, C) the images of points that a track that was lost may have too, where images nearer than r px are one; none
    where r is 0."""
    cloud, F = tracks.cloud, tracks.cloud.n_frames
    out = np.zeros(cloud.detection.shape, bool)
    if not r:
        return out
    points = TrackPoints.of(cloud, tracks.id)
    unseen = expected_between(points, F, 1 / cloud.rate, method)
    near = [one.take(one.other >= len(out)) for one in near_held(points, cloud.detection.T, images, r, unseen)]
    holder, camera = (np.concatenate([getattr(one, name) for one in near]) for name in ("holder", "camera"))
    lost = unseen.take(np.concatenate([one.other for one in near]) - len(out))
    order = np.lexsort([cloud.frame, tracks.id])
    place = (tracks.id * (F + 1) + cloud.frame)[order]
    found = np.searchsorted(place, lost.id * (F + 1) + lost.frame)  # the lost one's first point after it
    gap, id = cloud.frame[order[found - 1]], tracks.id[holder]
    first, last = (np.searchsorted(place, id * (F + 1) + f) for f in (gap + 1, cloud.frame[order[found]]))
    row = order[ranges(first, last - first)]
    out[row, np.repeat(camera, last - first)] = True
    return out
