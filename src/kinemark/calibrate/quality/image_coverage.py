"""Where in its images a camera was calibrated, and how sure it is of the rest.

A lens term that fits the middle may be far off in the corners. Two figures tell: whether the places of the control
volume are seen within the hull of the points that the camera was calibrated with, and how uncertain the image of
a place at the volume's depth is by the parameters' covariance Σ alone,

    aim² = greatest eigenvalue of T Σ Tᵀ,    T = d uv / d parameters     (1)

at points spread over the image. A lens term that was held has no covariance: (1) takes it for known.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ...data import Camera, Rig
from ...data.array_types import Floats
from ...geometry import parameter_jacobian, project, rays, to_camera, undistort
from .predicted_covariance import visible

COLUMNS, ROWS = 16, 12
"""Places of the map of (1) over an image; chosen (see studies/calibration_quality.py)."""


class ImageCoverage(NamedTuple):
    """How one camera's image was calibrated.

    points: how many points it rests on; hull: (h, 2) px corners of their convex hull; image_share: of the image within
    the hull; volume_share: of the control volume, as far as the camera sees it, within the hull; u (COLUMNS) and
    v (ROWS) px, the places of aim (ROWS, COLUMNS) px by (1); folded: share of these where the lens has no inverse;
    aim_volume: (M) px by (1) at the places of the volume that the camera sees. NaN where unknown.
    """

    points: int
    hull: Floats
    image_share: float
    volume_share: float
    u: Floats
    v: Floats
    aim: Floats
    folded: float
    aim_volume: Floats


def image_coverage(camera: Camera, uv: Floats, xyz: Floats) -> ImageCoverage:
    """What points at (N, 2) px, NaN unseen, tell of the image of a camera, for a control volume of places (M, 3) mm."""
    uv = uv[np.isfinite(uv).all(1)]
    places = xyz[visible(Rig((camera,)), xyz)[0]]
    hull = hull_of(uv)
    known = bool((camera.size > 0).all())
    area = float(scipy.spatial.ConvexHull(hull).volume) if len(hull) else 0.0
    u, v = (
        np.linspace(0, (n - 1) if known else 2 * c, k)
        for n, c, k in zip(camera.size, np.abs(camera.K[:2, 2]), (COLUMNS, ROWS), strict=True)
    )
    depth = float(np.median(to_camera(camera, places)[:, 2])) if len(places) else np.nan
    pixels = np.stack(np.meshgrid(u, v), -1)
    return ImageCoverage(
        points=len(uv),
        hull=hull,
        image_share=area / float(np.prod(camera.size)) if known else np.nan,
        volume_share=share_within(hull, project(camera, places)),
        u=u,
        v=v,
        aim=aim_deviation(camera, at_depth(camera, pixels, depth)),
        folded=float(np.isnan(undistort(camera, pixels)[..., 0]).mean()),
        aim_volume=aim_deviation(camera, places),
    )


def hull_of(uv: Floats) -> Floats:
    """(h, 2) px the corners of the convex hull of points (N, 2); none where they span no area."""
    try:
        return np.asarray(uv[scipy.spatial.ConvexHull(uv).vertices]) if len(uv) > 2 else np.zeros((0, 2))
    except scipy.spatial.QhullError:  # all on one line
        return np.zeros((0, 2))


def share_within(hull: Floats, uv: Floats) -> float:
    """Share of points (M, 2) px within a convex hull (h, 2); NaN without points."""
    if not len(uv):
        return float("nan")
    return float((scipy.spatial.Delaunay(hull).find_simplex(uv) >= 0).mean()) if len(hull) else 0.0


def at_depth(camera: Camera, uv: Floats, depth: float) -> Floats:
    """(…, 3) mm what is seen at pixels (…, 2) so far along the camera's axis; NaN where the lens has no inverse."""
    direction = rays(camera, uv)
    return camera.centre + direction * (depth / np.maximum(direction @ camera.R[2], 1e-3))[..., None]


def aim_deviation(camera: Camera, xyz: Floats) -> Floats:
    """(…) px by (1) of the images of places (…, 3) mm; NaN where the camera states no covariance."""
    T = parameter_jacobian(camera, xyz)
    cov = T @ camera.cov @ np.swapaxes(T, -1, -2)
    known = np.asarray(np.isfinite(cov).all((-2, -1)) & bool(camera.cov.any()))
    largest = np.linalg.eigvalsh(np.where(known[..., None, None], cov, 0.0))[..., -1]
    return np.where(known, np.sqrt(np.maximum(largest, 0.0)), np.nan)
