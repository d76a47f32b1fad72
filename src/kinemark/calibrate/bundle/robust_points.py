"""Points in space from cameras some of which see them in the wrong place.

A point is triangulated from all cameras that see it. Where one of these is off by more than a limit, it is triangulated
from each pair of them, and the cameras that agree with the pair with which most agree are taken.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from ...data import Camera
from ...data.array_types import Floats
from ...geometry import project, triangulate, undistort
from .parts import complete


def robust_points(cameras: Iterable[Camera], uv: Floats, *, limit: ArrayLike) -> Floats:
    """(N, 3) from pixels (C, N, 2), NaN where unseen, some of them wrong; NaN where no two cameras agree.

    `limit`, px, one for all or one a camera (C), is how far off a right point may be.
    """
    cameras = tuple(cameras)
    P = np.array([camera.P for camera in cameras])
    ideal = np.stack([undistort(camera, x) for camera, x in zip(cameras, uv, strict=True)], 1)
    limits = np.broadcast_to(np.asarray(limit, np.float64), len(cameras))[:, None]
    xyz = triangulate(ideal, P)
    bad = np.flatnonzero((_distances(cameras, xyz, uv) > limits).any(0))
    xyz[bad] = _consensus(cameras, ideal[bad], uv[:, bad], P, limits)
    return xyz


def _distances(cameras: tuple[Camera, ...], xyz: Floats, uv: Floats) -> Floats:
    """(C, N) distance of points from their images, px; 0 where unseen, infinite behind the camera."""
    distance = np.stack(
        [np.linalg.norm(seen - project(camera, xyz), axis=-1) for camera, seen in zip(cameras, uv, strict=True)]
    )
    return np.where(np.isnan(uv[..., 0]), 0.0, np.where(np.isnan(distance), np.inf, distance))


def _consensus(cameras: tuple[Camera, ...], ideal: Floats, uv: Floats, P: Floats, limits: Floats) -> Floats:
    """(n, 3) each from the pair of cameras with which most others agree, then from all these."""
    seen = complete(uv)
    most, cost = np.zeros(len(ideal)), np.full(len(ideal), np.inf)
    agree = np.zeros(seen.shape, np.bool_)
    for a, b in combinations(range(len(cameras)), 2):
        rows = np.flatnonzero(seen[a] & seen[b])
        distance = _distances(cameras, triangulate(ideal[rows][:, [a, b]], P[[a, b]]), uv[:, rows])
        near = seen[:, rows] & (distance <= limits)
        count, total = near.sum(0), np.where(near, distance, 0.0).sum(0)
        better = (near[a] & near[b]) & ((count > most[rows]) | ((count == most[rows]) & (total < cost[rows])))
        rows = rows[better]
        most[rows], cost[rows], agree[:, rows] = count[better], total[better], near[:, better]
    return triangulate(np.where(agree.T[..., None], ideal, np.nan), P)
