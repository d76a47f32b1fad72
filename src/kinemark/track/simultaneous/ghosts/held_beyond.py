"""Where the images of a stretch are held before it and after it: by points that lie where they meet, or elsewhere.

A stretch is a run of frames in which the same two cameras see a track, and no other. Both of its images go on in their
own cameras (`image_chains`), before it and after it. A point that holds one of them there lies where the other is too,
if they are one marker's. If they are of two markers, which hardly drift past each other as long as both move alike, the
point is at its own marker, and the other image is beside it, anywhere along the epipolar line. With n₋ frames in which
the other image is more than ELSEWHERE standard deviations from where a point expects it, and n₊ frames in which it is
not, or the point holds both,

    score = max(0, ln(1 + n₋) − ln(1 + n₊))                                                 (1)

Below 0 it would say that points agree with the stretch. But pieces of one chance meeting do so too.
"""

from __future__ import annotations

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images
from ..following.associate import predict_images
from ..following.candidate_points import intersect
from ..following.kalman_states import KalmanStates
from .image_chains import images_beyond

MOST = 40
"""Frames before a stretch, and after it, in which its images are followed, a number; chosen: 60 take half as long
again."""

REACH = 3.0
"""Standard deviations of (1) of `image_chains`, as the noise of the images makes it, within which an image goes on;
chosen: in the scenes that were looked at (seeds 1045, 5224 and 800474 of benchmarks/tracking_scenes.py) none went over
to another marker so."""

ELSEWHERE = 4.0
"""Standard deviations of an image from where a point expects it, from which it is another marker's; chosen: as in
`Simultaneous.gate`, what is hardly ever so."""


def held_elsewhere(frame: Ints, detection: Ints, stretch: Ints, N: int, images: Images, r: float) -> Floats:
    """(N) the score (1) of each of N stretches, 0 of those of fewer than three points.

    Args:
        frame, stretch: (P) of points with detections (C, P); −1 where a point is of no stretch.
        r: px, that of `image_chains`.
    """
    rows = np.flatnonzero(stretch >= 0)
    rows = rows[np.lexsort([frame[rows], stretch[rows]])]
    size = np.bincount(stretch[rows], minlength=N)
    after = np.cumsum(size)
    long, number = np.flatnonzero(size >= 3), np.zeros((2, N))
    for step, end in ((1, after - 1), (-1, after - size)):
        three = rows[end[long][:, None] - step * np.arange(2, -1, -1)]
        has = detection[:, three[:, 2]] >= 0
        cameras = has.argmax(0), len(has) - 1 - has[::-1].argmax(0)
        last = np.concatenate([detection[camera[:, None], three] for camera in cameras])
        both = np.split(_beyond(images, last, step, r), 2)
        for held, other in (both, both[::-1]):
            which, elsewhere = _elsewhere(held, other, detection, images)
            for k in (0, 1):
                number[k] += np.bincount(long[which], elsewhere == k, N)
    return np.maximum(np.log1p(number[1]) - np.log1p(number[0]), 0.0)


def _beyond(images: Images, last: Ints, step: int, r: float) -> Ints:
    """(n, MOST) detections in which images go on beyond the last (n, 3), −1 from where they do not."""
    return images_beyond(images, last, step, REACH * np.sqrt(20 / 3 * images.variance[last].mean(1)), r, MOST)


def _elsewhere(held: Ints, other: Ints, detection: Ints, images: Images) -> tuple[Ints, Bools]:
    """Row (n) of each frame in which a point of detections (C, P) holds one image (N, MOST), while the other goes on as
    well; and whether this other image lies elsewhere (n)."""
    holder = np.full(len(images.uv), -1)
    for camera in detection:
        holder[camera[camera >= 0]] = np.flatnonzero(camera >= 0)
    row, k = np.nonzero((held >= 0) & (other >= 0))
    point, image = holder[held[row, k]], other[row, k]
    row, point, image = (column[point >= 0] for column in (row, point, image))
    point, at = np.unique(point, return_inverse=True)
    place, camera = intersect(images, detection[:, point]), images.camera[image]
    seen = predict_images(images.P, KalmanStates(place.xyz, place.cov))
    off, (a, b, d) = images.uv[image] - seen.uv[camera, :, at], seen.S[camera, :, at].T
    a, d = a + images.variance[image], d + images.variance[image]
    x, y = off.T
    away = d * x * x - 2 * b * x * y + a * y * y > ELSEWHERE**2 * (a * d - b * b)
    return row, away & (detection[camera, point[at]] != image)
