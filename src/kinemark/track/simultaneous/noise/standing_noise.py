"""What a calibration leaves in images that stand still.

The means of such images have hardly any other noise. What they leave between epipolar lines (`epipolar_noise`), less
what noise a mean has, is told from chance meetings, of which there are as many, far better than that of single frames.

Where they leave more than single images do, what stands still are no markers but reflections, which meet by chance
alone, or the calibration leaves so much that means tell no more than single images.
"""

from __future__ import annotations

import numpy as np

from ....data.array_types import Floats
from ..detection_index import LEAST_SD, Images
from ..following.standing_images import free_rows, means_of, standing_still
from .epipolar_noise import camera_noise, mixture, pair_of, residuals
from .measurement_noise import sampled_frames

MOST_CAMERAS = 4
"""Cameras beyond which single frames tell enough, as three images seldom meet by chance; chosen: of eight, means began
second tracks of markers whose images stand still in some cameras alone (see studies/probable_errors.py)."""


def lasting_variance(images: Images, F: Floats, T: float, gate: float) -> Floats | None:
    """(C) px², l of (1) of `standing_images`; None where hardly any image stands still, those that do agree worse than
    single images, or more than `MOST_CAMERAS` look."""
    frames, C = sampled_frames(images), len(images.P)
    if C > MOST_CAMERAS:
        return None
    standing = standing_still(images, free_rows(images, images.usable, frames), T, gate)
    means = means_of(images, standing, np.array(frames, np.int64), np.zeros(C))
    some = residuals(means, F, [*range(len(frames))])
    noise = camera_noise(some, mixture(some.off, pair_of(some, C), C * C, some.window), C).variance
    known = np.isfinite(noise)
    if not known.any() or np.median(noise[known]) > np.median(images.variance[standing.row]):
        return None
    number = float(np.median(standing.number))
    return np.asarray(np.maximum(np.fmax(noise, np.median(noise[known])) - standing.white / number, LEAST_SD**2))
