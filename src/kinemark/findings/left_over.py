"""Images of a camera that no point has: whether they can be of markers, or stand, or flash up.

Of the valid images of a camera, those of no point

    are *standing* at a place that has images from the beginning of the recording to its end               (1)
    are *fleeting* where none of the camera's image before lies near, nor of the one after                 (2)

A marker that moves leaves its place, and one that is seen goes on. So (1) are lamps and reflections, (2) noise, and
neither says that markers were missed. Near is NEAR_PX in (1), and in (2) farther than the tracks' own images move from
one frame to the next. Nothing is told of a camera with few images in tracks, nor (1) where most of these stand as well:
then somebody stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from ..data import Detections, Tracks
from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import scattered
from ..numerics.lasting_places import lasting_places
from .plain import share

NEAR_PX = 2.0
"""Of one place, chosen: two centroids of noise 0.8 px lie within it four times in five."""

FARTHER, MOST_MOVE = 3.0, 0.95
"""Times this quantile of what tracked images move between two frames; chosen: others do not move much faster."""

FEW = 30
"""Images in tracks, below which nothing is told; chosen, as in `diagnostics`."""

MOST = 0.5
"""Of the images in tracks, the share that stands at most where (1) is told; chosen, as in `standing_reflections`."""

LOOKED_AT = 300
"""Frames in which (2) is looked for; chosen: of one image a frame the share is then known to 0.03."""


def left_over(detections: Detections, tracks: Tracks) -> list[dict[str, Any]]:
    """Of each camera standing_spots, the number of such places, standing_at, the mean of the images at each in px, and
    standing_share and fleeting_share of its valid images, by (1) and (2)."""
    used = np.zeros(len(detections) + 1, bool)
    used[tracks.cloud.detection] = True  # −1, for none, is the last
    return [_of_camera(detections, tracks, c, used[:-1]) for c in range(len(detections.cameras))]


def used_of_possible(cameras: Sequence[dict[str, Any]]) -> tuple[Floats, Floats]:
    """By the figures of C cameras: how many valid images of each belong to a point, and how many may be of markers."""
    valid = np.array([camera["detections"] - sum(camera["invalid"].values()) for camera in cameras], float)
    names = ("used_of_valid_share", "standing_share", "fleeting_share")
    used, standing, fleeting = (np.array([camera[name] or 0.0 for camera in cameras]) for name in names)
    return valid * used, valid * (1.0 - standing - fleeting)


def shown_at_once(cameras: Sequence[dict[str, Any]], frames: int) -> float:
    """By the figures of the cameras, how many images a frame may be of markers, in the mean, in the camera with images
    that has the fewest: so many markers are worn at least, if not something else shines before every camera."""
    possible = used_of_possible(cameras)[1]
    return float(possible[possible > 0].min()) / frames if (possible > 0).any() else 0.0


def _of_camera(detections: Detections, tracks: Tracks, c: int, used: Bools) -> dict[str, Any]:
    own = np.flatnonzero(detections.valid & (detections.camera == c))
    uv, frame, used = detections.uv[own], detections.frame[own], used[own]
    at, standing, fleeting = np.zeros((0, 2)), np.zeros(len(own), bool), 0.0
    if used.sum() >= FEW:
        places = uv[lasting_places(uv, frame, detections.n_frames, NEAR_PX)]
        if len(places):
            away, place = map(np.asarray, cKDTree(places).query(uv))
            if (away[used] < NEAR_PX).mean() <= MOST:
                standing = np.asarray(~used & (away < NEAR_PX))
                at = _means(uv[standing], place[standing])
        near = max(NEAR_PX, FARTHER * _step(detections, tracks, c))
        fleeting = _fleeting(uv, frame, ~used & ~standing, near)
    return {
        "standing_spots": len(at),
        "standing_at": at.round(1).tolist(),
        "standing_share": share(float(standing.sum()), len(own)),
        "fleeting_share": fleeting if len(own) else None,
    }


def _means(uv: Floats, place: Ints) -> Floats:
    """(P, 2) px of the images (N, 2) at each of P places; a lamp that wanders is found at two, whose
    images within NEAR_PX overlap: they are one."""
    while True:
        number, images = np.unique(place, return_inverse=True, return_counts=True)[1:]
        means = np.stack([np.bincount(number, uv[:, axis]) / images for axis in (0, 1)], -1)
        near = cKDTree(means).query_pairs(2 * NEAR_PX, output_type="ndarray")
        if not len(near):
            return means
        closest = near[np.linalg.norm(means[near[:, 0]] - means[near[:, 1]], axis=1).argmin()]
        place = np.where(number == closest[1], closest[0], number)


def _step(detections: Detections, tracks: Tracks, c: int) -> float:
    """px that most images of tracks move from one frame to the next, at most; endless where no track goes on."""
    cloud = tracks.cloud
    order = np.lexsort([cloud.frame, tracks.id])
    id, frame, image = tracks.id[order], cloud.frame[order], cloud.detection[order, c]
    on = (np.diff(id) == 0) & (id[1:] >= 0) & (np.diff(frame) == 1) & (image[1:] >= 0) & (image[:-1] >= 0)
    moved = np.linalg.norm(detections.uv[image[1:][on]] - detections.uv[image[:-1][on]], axis=1)
    return float(np.quantile(moved, MOST_MOVE)) if len(moved) else np.inf


def _fleeting(uv: Floats, frame: Ints, asked: Bools, near: float) -> float:
    """(2) as a share of all images (N) of a camera, of those that are asked for, by some of its frames."""
    when = np.unique(frame, return_inverse=True)[1]  # frames that it has an image of
    looked_at = scattered(int(when.max()) + 1, LOOKED_AT)
    some = np.isin(when, looked_at)
    if not np.isfinite(near) or not (asked & some).any():
        return 0.0
    place = np.column_stack([uv / near, when])  # within 1 in each: near, in this frame or the next to it
    alone = np.zeros(len(uv), bool)
    for odd in (0, 1):
        rows, others = np.flatnonzero(asked & some & (when % 2 == odd)), when % 2 != odd
        if len(rows):
            tree = cKDTree(place[others]) if others.any() else None
            alone[rows] = tree is None or tree.query(place[rows], p=np.inf)[0] > 1
    return float(alone.sum() / some.sum())
