"""A camera that was knocked after its calibration, put right by the points that the other cameras show.

Its images lie beside those points by the same offset (`misfitting_cameras`). Images that lie alone near where the
offset lets a point be are the point's; with these pairs (X, u) the camera's turn ω, its way z ε and its focal lengths'
factor 1 + s (`rig_of_tracks` (1)) minimise

    Σ w |u − û|² / σ² + Σ (θ / θ₀)²                                                       (1)

with w Cauchy's weights and σ the spread of the residuals. Pairs are looked for again where the camera then has the
points, in a smaller circle (2). The other cameras, and with them the world, stay as they are.

The camera is right where enough points in its view have an image that is theirs, with no more than usual noise (3).
The inverse of the normal matrix of (1) is the covariance of θ (4).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....data import Camera, Detections, Rig, Tracks
from ....data.array_types import Floats, Ints
from ....geometry import project
from ....numerics.robust import cauchy_weight, plane_scale
from ..detection_index import Images, read_images
from .rig_of_tracks import EXACT, SOFT, changed_camera, depths_of_points, image_derivatives

REACH = (9.0, 5.0, 3.0, 3.0)
"""px of (2), a round each; chosen: offsets are known to some 3 px, and turns about the axis add some at the edges."""

USUAL_ERROR = np.array([0.1, 0.1, 0.1, 3e-4, 3e-4, 3e-4, 3e-4])
"""θ₀ of (1) in a round: rad, shares of the depth, and of the focal length; chosen: knocks turn cameras, and move them
by a millimetre. With 0.01 positions are as good, and cameras of files 1 px off stand 25 mm astray for 11 (164001)."""

STEPS = 3
"""Of Gauss–Newton in a round; chosen: the next round goes on."""

LEAST_PAIRS, LEAST_SHARE = 100, 0.15
"""Of (3), and the share of points in view, chosen: by chance few have one image within 3 px, and a camera behind a
subject sees a third of what the others see (164033)."""

MOST_SD = 1.0
"""px of (3), of residuals of one axis; chosen: other pairs than those of markers leave 1.5."""

NOWHERE = -1e6
"""px, of points that are not in view, where no image is; by definition."""

MOST_POINTS = 4000
"""Points that are looked at; chosen: more say the same."""


class PutRight(NamedTuple):
    """A camera as the points of the others show it, and what of its images that leaves open: the covariance (2, 2) px²
    by (4) of the image of a point in the middle of them, on average."""

    camera: Camera
    cov: Floats


def put_right(c: int, offset: Floats, tracks: Tracks, detections: Detections, rig: Rig) -> PutRight | None:
    """Camera c as the points of the others show it; None where they cannot tell (3).

    Args:
        c: its number. offset: (2) px by which its images lie beside. tracks: of the other cameras.
        detections, rig: of all cameras, this one as it was calibrated.
    """
    cloud = tracks.cloud
    rows = np.flatnonzero((np.delete(cloud.detection, c, axis=1) >= 0).sum(1) >= 2)
    rows = rows[:: -(-len(rows) // MOST_POINTS) or 1]
    xyz, camera, seen = cloud.xyz[rows], rig[c], detections.keep(detections.camera == c)
    for k, reach in enumerate(REACH):
        images = read_images(seen, with_camera(rig, c, camera))
        there = project(replace(camera, distortion=np.zeros(5)), xyz) + (offset if k == 0 else 0.0)
        in_view = ((there >= 0) & (there < images.size[c])).all(1) & (xyz @ camera.R[2] + camera.t[2] > 0)
        there[~in_view] = NOWHERE
        point, image = _pairs(images, cloud.frame[rows] * len(rig) + c, there, reach)
        if len(point) < max(LEAST_PAIRS, LEAST_SHARE * in_view.sum()):
            return None
        camera, sd, cov = _fitted(camera, xyz[point], images.uv[image])
    return PutRight(camera, cov) if sd < MOST_SD else None


def with_camera(rig: Rig, c: int, camera: Camera) -> Rig:
    """The rig with another camera c."""
    return replace(rig, cameras=(*rig.cameras[:c], camera, *rig.cameras[c + 1 :]))


def _pairs(images: Images, cell: Ints, uv: Floats, reach: float) -> tuple[Ints, Ints]:
    """Places (n) of those at uv (P, 2) px in cells (P) that one image alone is within reach of, and the image (n)."""
    place, image = images.near(cell, uv[:, 0], np.full(len(uv), reach))
    close = np.linalg.norm(images.uv[image] - uv[place], axis=1) < reach
    place, image = place[close], image[close]
    alone = np.bincount(place, minlength=len(uv))[place] == 1
    return place[alone], image[alone]


def _fitted(camera: Camera, xyz: Floats, uv: Floats) -> tuple[Camera, float, Floats]:
    """The camera by (1) of points (n, 3) mm and their images (n, 2) px, what is left, px, and `PutRight.cov`."""
    theta, sigma = np.zeros(len(USUAL_ERROR)), np.inf
    now, seen = camera, np.ones((1, len(xyz)), bool)
    for _ in range(STEPS):
        rig = Rig((now,))
        by = image_derivatives(rig, xyz, uv[None], depth := depths_of_points(rig, xyz, seen))
        r, A = by.r[0], by.A[0]
        squared = (r**2).sum(-1)
        sigma = max(plane_scale(np.sqrt(squared)), EXACT)
        weight = cauchy_weight(squared / sigma**2, SOFT) / sigma**2
        normal = np.einsum("s,sai,saj->ij", weight, A, A) + np.diag(USUAL_ERROR**-2)
        pull = np.einsum("s,sai,sa->i", weight, A, r) - theta / USUAL_ERROR**2
        step = np.linalg.solve(normal, pull)
        theta, now = theta + step, changed_camera(now, step, float(depth[0]))
    return now, sigma, np.einsum("sai,ij,sbj->ab", A, np.linalg.inv(normal), A) / len(A)  # (4)
