"""Images that lie beside their marker's place: of which a limb hides a part, or beside which something shines.

Errors of images have heavy tails: for some frames one lies a part of its radius r beside, far more than its variance
says. Its track does not find it then, and where two cameras see the marker the track breaks. So an image has a
likelihood of two parts. Where a track has none within the gate of what its noise says, it takes one that

    nobody has, lies less than IN_ROW r + g sd from where the track's other images have it, and is the nearest,  (1)

of the image and of the track, with sd the standard deviation of that place and g the gate. It then counts with the
variance r² (2), and like an image that tracks share it is no evidence for the track: it only says that the marker is
somewhere about the blob. Tracks of which no image fits take none, nor do those known worse than VAGUE. With two cameras
nothing would tell such an image from another marker's.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .associate import IN_ROW, Association, PredictedImages
from .detection_index import Images

MOST_RADIUS = 4.0
"""px, r of (1) at most; chosen: of larger images a few px are hidden as well, but more others lie near."""

VAGUE = 2.0
"""px, the standard deviation of a place in the image from which nothing is looked for there; chosen: half of
MOST_RADIUS."""


def with_partly_hidden(
    images: Images, free: Bools, frame: Ints, expected: PredictedImages, association: Association, gate: float
) -> Association:
    """The association of tracks in frames (T) with free images (D) beside their places by (1) too.

    Args:
        expected: where the images of the association have the tracks.
    """
    camera, track, sd = _lacking(expected, association)
    cell = frame[track] * len(expected.uv) + camera
    place, image = images.near(cell, expected.uv[camera, 0, track], IN_ROW * MOST_RADIUS + gate * sd)
    good = free[image] & ~images.merged[image]
    place, image = place[good], image[good]
    off = images.uv[image] - expected.uv[camera[place], :, track[place]]
    reach = IN_ROW * np.minimum(images.radius(image), MOST_RADIUS) + gate * sd[place]
    nearest = _nearest(place, image, np.hypot(*off.T) / reach)
    if not len(nearest):
        return association
    at, image = (camera[place[nearest]], track[place[nearest]]), image[nearest]
    detection, variance, shared = association.detection.copy(), association.variance.copy(), association.shared.copy()
    detection[at], shared[at] = image, True
    variance[at] = np.maximum(images.variance[image], images.radius(image) ** 2)  # (2)
    return association._replace(detection=detection, variance=variance, shared=shared)


def _lacking(expected: PredictedImages, association: Association) -> tuple[Ints, Ints, Floats]:
    """Cameras and tracks (N) that lack an image where another fits, and the standard deviation (N) px of the place."""
    has = association.detection >= 0
    fits = (has & ~association.shared).any(0)
    camera, track = np.nonzero(~has & fits & np.isfinite(expected.uv[:, 0]))
    sd = np.sqrt(np.maximum(expected.S[camera, 0, track], expected.S[camera, 2, track]))
    known = sd < VAGUE
    return camera[known], track[known], sd[known]


def _nearest(place: Ints, image: Ints, beyond: Floats) -> Ints:
    """Of pairs (N) of places and images those that are the nearest, with `beyond` (N) < 1, to both."""
    order = np.argsort(beyond, kind="stable")
    order = order[beyond[order] < 1]
    of_place, of_image = (np.unique(column[order], return_index=True)[1] for column in (place, image))
    return order[np.intersect1d(of_place, of_image)]
