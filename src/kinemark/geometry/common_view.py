"""The centre of what cameras see together.

Where the optical axes (c, d) of the cameras meet, the place X nearest to all of them,

    Σ (I − d dᵀ) (X − c) = 0                                             (1)

is in the middle of their views. Axes of cameras that are toed out, or stand in a row, meet behind them or nowhere,
though the cameras see much in common. Then rays through a grid of pixels of each camera are followed to several depths,
and of the places reached that most cameras have in their images, X is the median (2).
"""

from __future__ import annotations

import numpy as np

from ..data import Camera, Rig
from ..data.array_types import Floats, Ints
from ..numerics.vectors import across

GRID = np.linspace(0.1, 0.9, 5)
"""Shares of an image's width and height at which rays are followed; chosen: five by five rays."""

DEPTHS = np.geomspace(0.5, 4.0, 13)
"""Depths of (2), by the extent of the cameras' places; chosen: a volume is about as large as its rig."""


def common_view_centre(rig: Rig) -> Floats | None:
    """(3) mm, a place in the middle of what two and more cameras see; None where no two see anything in common."""
    axes = np.array([camera.R[2] for camera in rig]).reshape(-1, 3)
    projectors = across(axes)
    try:
        centre = np.linalg.solve(projectors.sum(0), np.einsum("cij,cj->i", projectors, rig.centres))  # (1)
    except np.linalg.LinAlgError:
        centre = np.full(3, np.nan)
    if seen_by(rig, centre[None])[0] >= 2:
        return centre
    extent = float(np.linalg.norm(np.ptp(rig.centres, axis=0))) if len(rig) else 0.0
    places = np.concatenate([_along_rays(camera, DEPTHS * extent) for camera in rig] or [np.zeros((0, 3))])
    count = seen_by(rig, places)
    most = int(count.max(initial=0))
    return np.median(places[count == most], axis=0) if most >= 2 else None  # (2)


def seen_by(rig: Rig, places: Floats) -> Ints:
    """(N) how many cameras have the places (N, 3) mm within their images, lenses aside."""
    total = np.zeros(len(places), np.int64)
    for camera in rig:
        h = places @ camera.R.T + camera.t
        with np.errstate(divide="ignore", invalid="ignore"):
            uv = (h / h[:, 2:]) @ camera.K[:2].T
            total += (h[:, 2] > 0) & ((uv >= 0) & (uv < image_size(camera))).all(1)
    return total


def image_size(camera: Camera) -> Floats:
    """(2) px; twice the principal point where it is not known."""
    return np.asarray(camera.size if camera.size.all() else 2 * camera.K[:2, 2], np.float64)


def _along_rays(camera: Camera, depths: Floats) -> Floats:
    """(N, 3) mm, places along rays through a grid of the camera's pixels."""
    u, v = np.meshgrid(*(share * GRID for share in image_size(camera)), indexing="ij")
    rays = np.linalg.solve(camera.K, np.stack([u.ravel(), v.ravel(), np.ones(u.size)])).T
    local = (rays[:, None] * depths[:, None]).reshape(-1, 3)
    return (local - camera.t) @ camera.R
