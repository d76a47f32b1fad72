"""Tracks that go on by one camera alone, where its image is the one into which another ran, or out of which one came.

From one point of a track to the next, an image of its own in the same camera tells that it is still the same marker's.
Where a file does not mark merged images, and no other track shows them, that image may be of two markers. Another
camera tells so; but where all others see the track in one of both points only, none does, and what comes out of the
image may be the other marker.

So points are looked at of which one camera alone has an image in both. With r px below which two markers are one image
(`unmarked_merging`), another image ran into it, or came out of it, where not as many others lie within REACH r (1).
"""

from __future__ import annotations

import numpy as np

from ...data import Tracks
from ...data.array_types import Bools, Ints
from .detection_index import Images
from .unmarked_merging import resolution

LONGEST = 4
"""Frames from one point to the next, a number at most; chosen: over longer gaps motion tells (`possible_exchanges`)."""

REACH = 1.3
"""Of (1), in r; chosen: markers come nearer by some of r from frame to frame before they are one image."""


def by_lone_images(tracks: Tracks, own: Bools, images: Images) -> tuple[Ints, Ints, Ints]:
    """Track (N), first and last frame (N) of points that follow each other, and go on so.

    Args:
        tracks: P points, of detections of `images`. own: (P, C) where a camera has an image of the point alone.
    """
    cloud = tracks.cloud
    order = np.lexsort([cloud.frame, tracks.id])
    a, b = order[:-1], order[1:]
    both = own[a] & own[b]
    alone = (tracks.id[a] == tracks.id[b]) & (cloud.frame[b] - cloud.frame[a] <= LONGEST) & (both.sum(1) == 1)
    a, b, camera = a[alone], b[alone], both[alone].argmax(1)
    r = resolution(images) if len(a) else 0.0
    before, since = (_others(images, cloud.detection[rows, camera], REACH * r) for rows in (a, b))
    ran = before != since  # (1)
    return tracks.id[a[ran]], cloud.frame[a[ran]], cloud.frame[b[ran]]


def _others(images: Images, image: Ints, reach: float) -> Ints:
    """(n) how many other images lie within `reach` px of each image (n)."""
    cell = images.frame[image] * len(images.P) + images.camera[image]
    query, row = images.near(cell, images.uv[image, 0], np.full(len(image), reach))
    near = np.hypot(*(images.uv[row] - images.uv[image[query]]).T) < reach
    return np.bincount(query, near & (row != image[query]), len(image)).astype(np.int64)
