"""Twins: two tracks of one marker, each of images of other cameras.

Lines of two cameras do not tell how far one stands from the other, and where all stand in a row those of no pair do.
So where a calibration is off, noise that is learned from them is too small there, and images of three cameras do not
meet within it. Some make one track, and the rest another a few mm beside. Then no point holds images of both, and
points of three images are few: the tracks do not tell that cameras stand otherwise, unless twins are joined.

Two tracks are twins where in half of the frames of the shorter one

    their points are the nearest of each other, no camera has an image of both, the images of one lie less than
    BESIDE px from where their cameras would see the point of the other, and each image of one lies on the line of each
    of the other's, within GATE standard deviations                                       (1)

Lines tell two markers of which each camera sees one, as on both sides of a thin plate. Where twins have less than MANY
of the points, they are rather such.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...data import Cloud, Tracks
from ...data.array_types import Bools, Floats, Ints
from .candidate_points import fundamentals

SHARE, FEWEST = 0.5, 8
"""Of the frames of the shorter track in which (1) holds, and these at least; chosen: two markers meet for fewer."""

BESIDE = 10.0
"""px of (1); chosen, as `measurement_noise.MAX_DISTANCE`."""

GATE = 4.0
"""Standard deviations of (1); chosen: lines of a row whose file is off agree, those of markers on two sides of a plate
do not."""

MANY = 0.05
"""Share of all points; chosen: rows whose file is off had 0.05 to 0.8, `gait9` 0.015, and a quarter of it 0.03."""


def joined_twins(tracks: Tracks, uv: Floats, variance: Floats, P: Floats) -> Ints:
    """(C, S) images of the points of tracks, −1 for none, those of twins in one; as they are where twins are few.

    Args:
        tracks: of a first pass. uv, variance: (D, 2) px and (D) px² of all images. P: (C, 3, 4) the cameras that solved
            their points.
    """
    cloud = tracks.cloud
    detection = cloud.detection.T
    if len(P) < 4 or len(cloud) < FEWEST:
        return detection
    one, other = _nearest_of_each_other(cloud)
    alike = ~((detection[:, one] >= 0) & (detection[:, other] >= 0)).any(0)
    alike &= _beside(P, cloud.xyz[one], detection[:, other], uv) < BESIDE
    one, other = one[alike], other[alike]
    alike = lines_meet(P, detection[:, one], detection[:, other], uv, variance)
    one, other = one[alike], other[alike]
    ids = np.sort(tracks.id[np.stack([one, other])], axis=0)
    _, pair, n = np.unique(ids, axis=1, return_inverse=True, return_counts=True)
    twins = n[pair.ravel()] >= np.maximum(SHARE * tracks.lengths[ids].min(0), FEWEST)
    one, other = one[twins], other[twins]
    if 2 * len(one) <= MANY * len(cloud):
        return detection
    joined = detection.copy()
    joined[:, one] = np.maximum(joined[:, one], joined[:, other])
    return np.delete(joined, other, axis=1)


def _nearest_of_each_other(cloud: Cloud) -> tuple[Ints, Ints]:
    """Rows of two points of one frame of which each is the nearest of the other."""
    xyz = cloud.xyz - cloud.xyz.mean(0)
    apart = 4 * np.ptp(xyz, axis=0).max() + 1  # mm from frame to frame: nothing is as far within one
    place = np.column_stack([xyz, cloud.frame * apart])
    near = np.asarray(cKDTree(place).query(place, 2)[1], np.int64)
    own = np.arange(len(xyz))
    nearest = np.where(near[:, 0] == own, near[:, 1], near[:, 0])
    found = (nearest[nearest] == own) & (own < nearest) & (cloud.frame[nearest] == cloud.frame)
    return own[found], nearest[found]


def _beside(P: Floats, xyz: Floats, detection: Ints, uv: Floats) -> Floats:
    """(n) px, the farthest of the images (C, n) from where their cameras P would see points (n, 3) mm."""
    x = xyz @ P[:, :, :3].transpose(0, 2, 1) + P[:, None, :, 3]
    off = np.linalg.norm(x[..., :2] / x[..., 2:] - uv[detection], axis=-1)
    return np.asarray(np.where(detection >= 0, off, 0.0).max(0))


def lines_meet(P: Floats, one: Ints, other: Ints, uv: Floats, variance: Floats) -> Bools:
    """(n) whether images (C, n) of one point and of another meet each other's lines within GATE."""
    meet, F = np.ones(one.shape[1], bool), fundamentals(P)
    for r, s in np.argwhere(~np.eye(len(P), dtype=bool)):
        rows = np.flatnonzero((one[r] >= 0) & (other[s] >= 0))
        i, j = one[r, rows], other[s, rows]
        x, y = (np.column_stack([uv[own], np.ones(len(own))]) for own in (i, j))
        line, back = x @ F[r, s].T, y @ F[r, s]
        of_noise = (back[:, :2] ** 2).sum(1) * variance[i] + (line[:, :2] ** 2).sum(1) * variance[j]
        meet[rows] &= (line * y).sum(1) ** 2 < GATE**2 * of_noise
    return meet
