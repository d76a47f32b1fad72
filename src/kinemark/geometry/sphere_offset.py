"""How far the centroid of a sphere's image lies from the projection of the sphere's centre.

A sphere of radius r about c = (X, Y, Z) in the camera's frame is seen within the cone of rays that touch it. An ideal
lens draws that cone as an ellipse on the normalised image plane whose centre is

    m = (c₂ / Z) / (1 − r²/Z²),    c₂ = (X, Y)                            (1)

and not the projection c₂ / Z of the sphere's centre: it lies farther from the principal point by c₂ r² / (Z (Z² − r²)).
Its semi-axes, along and across the direction of c₂, are

    p = r √(|c|² − r²) / (Z² − r²),    q = r / √(Z² − r²)                 (2)

A lens with distortion D draws the point x of the ellipse at D(x), and an area there larger by |D'(x)|, so that the
centroid of an evenly bright image is the mean over the ellipse

    ⟨ D(x) |D'(x)| ⟩ / ⟨ |D'(x)| ⟩                                        (3)

taken by the rule of seven points that is exact on a disc for polynomials of degree 5 (the centre by 1/4, six points at
√(2/3) of the radius by 1/8 each); what is left out is of the order (r/Z)⁶. The offset is (3) less D(c₂ / Z) (4), times
the focal lengths. Without distortion (3) is m itself.

For a marker of 15 mm at 3 m, 1500 px of focal length and 20° off the axis, (4) is 0.003 px; for one of 40 mm at 1 m it
is 0.2 px, and it has the same sign in all cameras: away from their principal points.
"""

from __future__ import annotations

import numpy as np

from ..data import Camera
from ..data.array_types import Floats
from . import lens
from .camera import to_camera

_SIXTH = np.arange(6) * np.pi / 3  # rad; six directions of `NODES`; by definition
NODES = np.concatenate([np.zeros((1, 2)), np.sqrt(2 / 3) * np.stack([np.cos(_SIXTH), np.sin(_SIXTH)], -1)])
"""Of a rule for the unit disc, exact to degree 5."""
WEIGHTS = np.array([1 / 4] + [1 / 8] * 6)  # of the same rule; exact


def sphere_offset(camera: Camera, xyz: Floats, *, diameter: float) -> Floats:
    """Centroid of the image of spheres at xyz (…, 3) mm minus the projection of their centres, (…, 2) px.

    NaN where a sphere is behind the camera or reaches its focal plane.

    Raises:
        ValueError: the diameter, mm, is not a number of 0 or more.
    """
    if not 0 <= diameter < np.inf:
        raise ValueError(f"diameter is {diameter}, wanted 0 or more, mm")
    c = to_camera(camera, np.asarray(xyz, np.float64))
    r2 = (diameter / 2) ** 2
    z2 = np.where((c[..., 2] > 0) & (c[..., 2] ** 2 > r2), c[..., 2] ** 2 - r2, np.nan)
    ideal = c[..., :2] / c[..., 2:]
    if camera.distortion.any():
        centroid = _drawn_centroid(c, z2, np.sqrt(r2), camera.distortion)
        offset = centroid - lens.distort(ideal, camera.distortion)  # (4)
    else:
        offset = ideal * (r2 / z2)[..., None]  # (1)
    return np.asarray(offset @ camera.K[:2, :2].T)


def _drawn_centroid(c: Floats, z2: Floats, r: float, k: Floats) -> Floats:
    """(3) for spheres at c (…, 3) in the camera's frame, with z2 = Z² − r²; (…, 2), normalised."""
    m = c[..., :2] * (c[..., 2] / z2)[..., None]  # (1)
    far = np.linalg.norm(c[..., :2], axis=-1, keepdims=True)
    e = np.where(far > 0, c[..., :2] / np.where(far > 0, far, 1.0), [1.0, 0.0])
    across = np.stack([-e[..., 1], e[..., 0]], -1)
    p = r * np.sqrt((c**2).sum(-1) - r * r) / z2  # (2)
    q = r / np.sqrt(z2)
    x = (
        m[..., None, :]
        + NODES[:, :1] * (p[..., None] * e)[..., None, :]
        + NODES[:, 1:] * (q[..., None] * across)[..., None, :]
    )
    J = lens.jacobian(x, k)
    weight = WEIGHTS * (J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0])
    return np.asarray((lens.distort(x, k) * weight[..., None]).sum(-2) / weight.sum(-1)[..., None])
