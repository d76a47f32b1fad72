"""Cameras and places about another origin, for sums of products of coordinates.

Where the world has its origin is arbitrary, but products of coordinates lose digits where it is far away: of a turn
about an origin 10 km off and a shift that undoes it, each moves an image ten million times as much as both together. So
what solves for poses first takes a whole number of millimetres near the middle of the points for the origin, which
leaves differences exact. With X' = X − o a camera has

    R' = R,   t' = t + R o                                               (1)

and as R ← exp([r]×) R turns about the new origin too, errors of its parameters become

    r' = r,   d t' = d t − [R o]× r                                      (2)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import PARAMETERS, Camera, Rig
from ..data.array_types import Floats

TURN, PLACE = PARAMETERS.index("rx"), PARAMETERS.index("tx")


def origin_near(xyz: Floats) -> Floats:
    """(3,) mm, whole numbers: about the mean of the places (…, 3) mm that are known; 0 where none is."""
    flat = xyz.reshape(-1, 3)
    known = flat[np.isfinite(flat).all(1)]
    return np.round(known.mean(0)) if len(known) else np.zeros(3)


def camera_about(camera: Camera, origin: Floats) -> Camera:
    """The camera in a world whose origin is at `origin` (3,) mm of this one, by (1) and (2)."""
    M = parameters_about(camera, origin)
    return replace(camera, t=camera.t + camera.R @ origin, cov=M @ camera.cov @ M.T, common=M @ camera.common)


def rig_about(rig: Rig, origin: Floats) -> Rig:
    """`camera_about` of all cameras and of the control volume; `origin` (3,) mm."""
    return Rig(tuple(camera_about(camera, origin) for camera in rig), rig.method, rig.volume - origin)


def parameters_about(camera: Camera, origin: Floats) -> Floats:
    """M (15, 15) of (2): how errors of `data.PARAMETERS` change with the origin."""
    x, y, z = camera.R @ origin
    M = np.eye(len(PARAMETERS))
    M[PLACE : PLACE + 3, TURN : TURN + 3] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    return M


def joint_about(rig: Rig, joint: Floats, origin: Floats) -> Floats:
    """The covariance (15 C, 15 C) of all cameras' parameters together, about another origin."""
    p = len(PARAMETERS)
    M = np.zeros_like(joint)
    for c, camera in enumerate(rig):
        M[p * c : p * (c + 1), p * c : p * (c + 1)] = parameters_about(camera, origin)
    return M @ joint @ M.T
