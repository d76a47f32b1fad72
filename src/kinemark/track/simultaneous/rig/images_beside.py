"""Images that no point has, beside a point that lacks one in their camera: those of a camera of a row that is off.

Lines of two cameras do not tell how far one stands from the other, and where all stand in a row those of no pair do.
So where a calibration is off, the images of one of four cameras lie on all lines, but some px beside the points of the
other three, and no track takes them. Then no point ties that camera to the others, and a rig adjusted to the points
(`rig_of_tracks`) leaves it where it is. An image is taken for the point's where

    no point has it, the point has two images and more, none in its camera, sees it less than BESIDE px from there, and
    the image lies on the line of each of the point's, within GATE standard deviations,                              (1)

of several the nearest, of the image and of the point. Lines of cameras that do not stand in a row cross at the point
itself, where a track finds its image. So there are few such images elsewhere, and where fewer than MANY of the points
have one, none is taken.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....data import Tracks
from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images
from ..following.candidate_points import fundamentals

BESIDE = 10.0
"""px of (1); chosen, as `measurement_noise.MAX_DISTANCE`."""

GATE = 4.0
"""Standard deviations of (1); chosen: lines of a row whose file is off agree, those of markers on two sides of a plate
do not."""

MANY = 0.15
"""Share of all points; chosen: rows that gained had 0.19 to 0.95; of eight below two gained, five samples and two;
with 0.06 a camera that was bumped by 12 px along the lines of the others was no longer put right (160030)."""

MOST_POINTS = 20_000
"""Points that are looked at; chosen: more say the same."""


def with_images_beside(tracks: Tracks, images: Images) -> Tracks:
    """The tracks with images by (1), whose points stay where they are; the same object where such images are few."""
    cloud, frame, C = tracks.cloud, tracks.cloud.frame, len(images.P)
    if C < 3:
        return tracks
    some = np.arange(0, len(cloud), max(len(cloud) // MOST_POINTS, 1))
    has = cloud.detection[some] >= 0
    free = images.usable & ~images.merged
    free[cloud.detection[cloud.detection >= 0]] = False
    remaining = images._replace(by_cell=images.by_cell.keep(free))
    found = np.zeros((3, 0), np.int64)
    for c in range(C):
        lacking = some[~has[:, c] & (has.sum(1) >= 2)]
        point, image = _beside(c, frame[lacking], cloud.xyz[lacking], cloud.detection[lacking].T, remaining)
        found = np.concatenate([found, [lacking[point], np.full(len(point), c), image]], 1)
    row, camera, image = found
    if len(row) <= MANY * len(some):
        return tracks
    detection = cloud.detection.copy()
    detection[row, camera] = image
    return replace(tracks, cloud=replace(cloud, detection=detection))


def _beside(c: int, frame: Ints, xyz: Floats, detection: Ints, images: Images) -> tuple[Ints, Ints]:
    """Rows of points (n, 3) mm of frames (n) and detections (C, n), and images of camera c that are theirs by (1)."""
    h = xyz @ images.P[c, :, :3].T + images.P[c, :, 3]
    uv = h[:, :2] / h[:, 2:]
    row, image = images.near(frame * len(images.P) + c, uv[:, 0], np.full(len(uv), BESIDE))
    apart = np.linalg.norm(images.uv[image] - uv[row], axis=1)
    order = np.argsort(apart, kind="stable")
    order = order[apart[order] < BESIDE]
    row, image = row[order], image[order]
    other = np.full((len(images.P), len(row)), -1)
    other[c] = image
    meet = _lines_meet(images.P, detection[:, row], other, images.uv, images.variance)
    row, image = row[meet], image[meet]
    nearest = np.intersect1d(np.unique(row, return_index=True)[1], np.unique(image, return_index=True)[1])
    return row[nearest], image[nearest]


def _lines_meet(P: Floats, one: Ints, other: Ints, uv: Floats, variance: Floats) -> Bools:
    """(n) whether images (C, n) of one point and others (C, n) meet each other's lines within GATE."""
    meet, F = np.ones(one.shape[1], bool), fundamentals(P)
    for r, s in np.argwhere(~np.eye(len(P), dtype=bool)):
        rows = np.flatnonzero((one[r] >= 0) & (other[s] >= 0))
        i, j = one[r, rows], other[s, rows]
        x, y = (np.column_stack([uv[own], np.ones(len(own))]) for own in (i, j))
        line, back = x @ F[r, s].T, y @ F[r, s]
        of_noise = (back[:, :2] ** 2).sum(1) * variance[i] + (line[:, :2] ** 2).sum(1) * variance[j]
        meet[rows] &= (line * y).sum(1) ** 2 < GATE**2 * of_noise
    return meet
