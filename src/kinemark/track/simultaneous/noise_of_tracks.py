"""How noisy images are, as the tracks of a first run say.

Before anything is tracked, noise is learned from distances between images and epipolar lines (`epipolar_noise`). With
many markers the nearest image to a line is often another's, and a camera may be taken for many times noisier than it
is. Gates are then wide, and chance meetings of images many. But most tracks are markers all the same. With r the
distance of an image from the point that fits its three or more images best, which leaves of its variance v what is not
in S, the place's,

    v̂ = quantile_p( |r|² v / (v − tr S / 2) ) / (−2 ln(1 − p))                            (1)

is the variance of a camera's images, by the median and by the TAIL, whichever is more: images that are not taken in
time are off where they are fast, and need all the room that was learned. Where MARGIN times this is less than one
FACTOR-th of what was learned, it takes its place.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Floats, Ints
from .associate import predict_images
from .candidate_points import intersect
from .detection_index import Images
from .kalman_states import KalmanStates

FEWEST = 200
"""Images of a camera by which it is judged, at least; chosen."""

MOST_CAMERAS = 4
"""Cameras at most; chosen: with more, cameras that are shifted or not in time would lose the room that they need, and
the rig adjusted to the tracks does as well (`rig_of_tracks`)."""

MARGIN = 2.0
"""Of (1), a ratio of variances: what is left to images that no track has yet, as they lie farther off; chosen."""

FACTOR = 1.25
"""Of (1), a ratio of variances; chosen (seeds 90000 to 90066 of benchmarks/tracking_scenes.py): 4, with a TAIL of 0.95,
leaves 0.21 ghosts a frame with four cameras, 2 and 0.8 leave 0.14; 1.25 finds more in scenes of 60 markers."""

TAIL = 0.7
"""p of (1); chosen: of infrared footage by cameras that are not synchronous many images are fast; in crowded scenes an
image in five is another marker's, and 0.95 is then the distance of these."""

LEAST_LEFT = 0.1
"""Of an image's variance, the least that is left without the place's; chosen, as in `passes`."""


def excess(detection: Ints, images: Images) -> Floats:
    """(C) px² that the images of each camera have too much of, by the points of detections (C, S).

    0 where it is little, and of more cameras than MOST_CAMERAS.
    """
    if len(detection) > MOST_CAMERAS:
        return np.zeros(len(detection))
    rows = np.flatnonzero((detection >= 0).sum(0) >= 3)
    detection = detection[:, rows[:: max(len(rows) // 20_000, 1)]]
    point = intersect(images, detection)
    place = predict_images(images.P, KalmanStates(point.xyz, point.cov)).S
    out = np.zeros(len(detection))
    for c, own in enumerate(detection):
        which = np.flatnonzero((own >= 0) & np.isfinite(point.squared[c]) & np.isfinite(place[c]).all(0))
        own = own[which]
        own, which = own[~images.merged[own]], which[~images.merged[own]]
        if len(own) < FEWEST:
            continue
        v = images.variance[own]
        left = np.maximum(1 - (place[c, 0, which] + place[c, 2, which]) / (2 * v), LEAST_LEFT)
        p = np.array([0.5, TAIL])
        seen = float((np.quantile(point.squared[c, which] * v / left, p) / (-2 * np.log(1 - p))).max())  # (1)
        learned = float(np.median(v - images.margin(own)))
        out[c] = learned - MARGIN * seen if FACTOR * MARGIN * seen < learned else 0.0
    return out
