"""The perspective image of a sphere.

A sphere of radius r about c = (X, Y, Z) in the camera's frame is seen within the cone of rays d that touch it,

    (d · c)² = (|c|² − r²) |d|²,    that is  cos ∠(d, c) = √(1 − r²/|c|²)              (1)

With d = (x, y, 1) this is a conic of the normalised image plane,

    dᵀ [c cᵀ − (|c|² − r²) I] d = 0                                                    (2)

an ellipse while Z > r. Its centre makes the gradient of (2) zero. With c₂ = (X, Y), A = c₂c₂ᵀ − (|c|² − r²) I and
A c₂ = −(Z² − r²) c₂, that is

    m = −A⁻¹ Z c₂ = c₂ Z / (Z² − r²) = (c₂/Z) / (1 − r²/Z²)                            (3)

so the centre lies farther from the principal point than the projection c₂/Z of the sphere's centre, by the factor
1 / (1 − r²/Z²). The semi-axes, along and across the direction of c₂, are

    p = r √(|c|² − r²) / (Z² − r²),    q = r / √(Z² − r²)                              (4)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Camera
from ..data.array_types import Floats
from ..geometry import distort, to_camera
from .occlusion import perpendicular


class Ellipse(NamedTuple):
    """Outline of a sphere's image through an ideal lens: centre (…, 2) px, semi-axes p, q (…) px, area (…) px²."""

    centre: Floats
    along: Floats
    across: Floats
    area: Floats


def sphere_ellipse(camera: Camera, xyz: Floats, radius: Floats | float) -> Ellipse:
    """The outline of spheres at xyz (…, 3) mm through an ideal lens; NaN where a sphere is behind or about the camera.

    The axes and the area are in px of the focal length √(fx fy), exact where pixels are square.
    """
    c = to_camera(camera, np.asarray(xyz, np.float64))
    z2 = c[..., 2] ** 2 - np.square(radius)
    z2 = np.where((c[..., 2] > 0) & (z2 > 0), z2, np.nan)
    K = camera.K
    centre = (c[..., :2] * (c[..., 2] / z2)[..., None]) @ K[:2, :2].T + K[:2, 2]  # (3)
    scale = np.sqrt(abs(K[0, 0] * K[1, 1]))
    p = scale * radius * np.sqrt((c**2).sum(-1) - np.square(radius)) / z2  # (4)
    q = scale * radius / np.sqrt(z2)
    return Ellipse(centre, p, q, np.pi * p * q)


def sphere_outline(camera: Camera, xyz: Floats, radius: Floats, n: int = 16) -> Floats:
    """(M, n, 2) px on the outline of spheres (M, 3) mm as the lens draws it, from the rays of (1)."""
    c = to_camera(camera, xyz)
    far = np.linalg.norm(c, axis=-1, keepdims=True)
    sine = np.minimum(radius[:, None] / far, 1.0)
    forward = c / far
    side = perpendicular(forward)
    up = np.cross(forward, side)
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)[:, None, None]
    rays = np.sqrt(1 - sine**2) * forward + sine * (np.cos(turn) * side + np.sin(turn) * up)
    depth = np.where(rays[..., 2:] > 0.05, rays[..., 2:], np.nan)
    ideal = (rays[..., :2] / depth) @ camera.K[:2, :2].T + camera.K[:2, 2]
    return distort(camera, ideal).transpose(1, 0, 2)
