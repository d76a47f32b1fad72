"""Points less certain by what is not known of a camera that was knocked within the recording and put back.

Its images since the knock all lie beside by the same d, whose covariance S is that of `moved_cameras.PutBack`. A point
of covariance C, of which the camera has an image of variance σ², follows it by

    δx = C Jᵀ d / σ²,   J = ∂uv / ∂x                                                      (1)

so that C + C Jᵀ S J C / σ⁴ is the covariance of the point (2). No filter makes it less, as d is the same in all frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....data import Cloud
from ....geometry import point_jacobian
from ..points.solved_points import Working, image_variance
from ..tracker import TrackingResult
from .moved_cameras import PutBack


def less_certain(result: TrackingResult, back: Sequence[PutBack]) -> TrackingResult:
    """Tracks with the covariances of (2), from images of cameras that were put `back`."""
    tracks = result.tracks
    for one in back:
        tracks = replace(tracks, cloud=_with_offset(tracks.cloud, result, one))
    return result._replace(tracks=tracks)


def _with_offset(cloud: Cloud, result: TrackingResult, one: PutBack) -> Cloud:
    """The points with (2) where they have an image of one camera since its knock."""
    c, first, stop, _ = one.moved
    image = cloud.detection[:, c]
    rows = np.flatnonzero((image >= 0) & (cloud.frame >= first) & (cloud.frame < stop))
    variance = image_variance(image[rows], Working(result.rig, result.images, result.noise))
    follow = cloud.cov[rows] @ point_jacobian(result.rig[c], cloud.xyz[rows]).swapaxes(1, 2)
    follow /= variance[:, None, None]  # (1)
    cov = cloud.cov.copy()
    cov[rows] += follow @ one.cov @ follow.swapaxes(1, 2)
    return replace(cloud, cov=cov)
