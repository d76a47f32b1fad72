"""Between world points and pixels, with derivatives.

The model is that of `data.rig`, equations (1)–(4). Its derivatives, with x_cam = (X, Y, Z):

    d(x, y)/d x_cam = [[1/Z, 0, −x/Z], [0, 1/Z, −y/Z]]                   (5)
    d uv / d xyz    = K₂ · lens' · (5) · R                               (6)
    d x_cam / d r   = −[x_cam − t]×    for R ← exp([r]×) R               (7)

K₂ is the upper left 2 × 2 of K.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Camera, Rig
from ..data.array_types import Floats
from ..numerics.vectors import homogeneous
from . import lens


def to_camera(camera: Camera, xyz: Floats) -> Floats:
    """World points (…, 3) mm in the camera's frame (…, 3) mm; the third is the depth."""
    return xyz @ camera.R.T + camera.t


def pixels(camera: Camera, xy: Floats) -> Floats:
    """Normalised image points (…, 2) as pixels (…, 2)."""
    return xy @ camera.K[:2, :2].T + camera.K[:2, 2]


def normalised(camera: Camera, uv: Floats) -> Floats:
    """Pixels (…, 2) as points of the normalised image plane (…, 2), the lens's distortion still in."""
    y = (uv[..., 1] - camera.K[1, 2]) / camera.K[1, 1]
    return np.stack([(uv[..., 0] - camera.K[0, 2] - camera.K[0, 1] * y) / camera.K[0, 0], y], -1)


def project(camera: Camera, xyz: Floats) -> Floats:
    """Pixels (…, 2) of world points (…, 3) mm, as the lens draws them; NaN behind the camera."""
    x_cam = to_camera(camera, xyz)
    depth = np.where(x_cam[..., 2:] > 0, x_cam[..., 2:], np.nan)
    return pixels(camera, lens.distort(x_cam[..., :2] / depth, camera.distortion))


def in_image(size: Sequence[int], u: float, v: float) -> bool:
    """Whether pixel (u, v) is in an image of `size` (width, height) px; (0, 0) is the centre of its first pixel."""
    return -0.5 <= u < size[0] - 0.5 and -0.5 <= v < size[1] - 0.5


def project_all(rig: Rig, xyz: Floats) -> Floats:
    """Pixels (C, …, 2) of world points (…, 3) mm in every camera."""
    return np.stack([project(camera, xyz) for camera in rig])


def undistort(camera: Camera, uv: Floats) -> Floats:
    """Pixels (…, 2) as an ideal lens would draw them (…, 2), so that `Camera.P` holds for them."""
    return pixels(camera, lens.undistort(normalised(camera, uv), camera.distortion))


def undistort_all(rig: Rig, uv: Floats) -> Floats:
    """Pixels (P, C, 2) of every camera as ideal lenses would draw them (P, C, 2)."""
    return np.stack([undistort(camera, uv[:, c]) for c, camera in enumerate(rig)], 1)


def distort(camera: Camera, uv: Floats) -> Floats:
    """Pixels of an ideal lens (…, 2) as this lens draws them (…, 2)."""
    return pixels(camera, lens.distort(normalised(camera, uv), camera.distortion))


def rays(camera: Camera, uv: Floats) -> Floats:
    """Unit directions (…, 3) in the world from `camera.centre` to what is seen at pixels (…, 2)."""
    xy = lens.undistort(normalised(camera, uv), camera.distortion)
    direction = homogeneous(xy) @ camera.R
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


def project_with_jacobian(camera: Camera, xyz: Floats) -> tuple[Floats, Floats]:
    """`project` (2, n), px, and `point_jacobian` (2, 3, n), px/mm, of world points (3, n) mm; NaN behind the camera.

    The points stand along the last axis, so that NumPy's innermost loop runs over them: much faster for many points.
    """
    x_cam = camera.R @ xyz + camera.t[:, None]
    z = np.where(x_cam[2] > 0, x_cam[2], np.nan)
    x, y = x_cam[:2] / z
    uv = np.stack(_scaled(camera, *lens.distorted_entries(x, y, camera.distortion))) + camera.K[:2, 2:]
    return uv, camera.R.T @ _by_camera(camera, x, y, z)  # (6)


def point_jacobian(camera: Camera, xyz: Floats) -> Floats:
    """d uv / d xyz (…, 2, 3), px/mm, of `project` at world points (…, 3) mm."""
    x, y, z = np.moveaxis(to_camera(camera, xyz), -1, 0)
    return _last(_by_camera(camera, x / z, y / z, z)) @ camera.R  # (6)


def parameter_jacobian(camera: Camera, xyz: Floats) -> Floats:
    """d uv / d parameters (…, 2, 15) of `project`, in the order of `data.PARAMETERS`."""
    return _last(_by_parameters(camera, *np.moveaxis(to_camera(camera, xyz), -1, 0)))


def calibration_errors(camera: Camera, xyz: Floats) -> tuple[Floats, Floats]:
    """What a calibration's errors do to images at (3, n) mm: J_θ C_θ J_θᵀ (2, 2, n) px², and J_θ F (2, k, n) px.

    J_θ is that of `parameter_jacobian`, C_θ is `Camera.cov` and F is `Camera.common`.
    """
    J = _by_parameters(camera, *(camera.R @ xyz + camera.t[:, None]))
    return np.asarray(np.einsum("ikn,jkn->ijn", camera.cov @ J, J)), camera.common.T @ J


def _by_parameters(camera: Camera, X: Floats, Y: Floats, Z: Floats) -> Floats:
    """d uv / d parameters (2, 15, …) at x_cam = (X, Y, Z)."""
    x, y = X / Z, Y / Z
    r2, xy = x * x + y * y, x * y
    J = np.zeros((2, 15, *x.shape))
    J[0, 0], J[1, 1] = lens.distorted_entries(x, y, camera.distortion)
    J[0, 2] = J[1, 3] = 1.0
    along_x = x * r2, x * r2**2, 2 * xy, r2 + 2 * x * x, x * r2**3  # dx' / d(k1, k2, p1, p2, k3)
    along_y = y * r2, y * r2**2, r2 + 2 * y * y, 2 * xy, y * r2**3
    for i in range(5):
        J[:, 4 + i] = _scaled(camera, along_x[i], along_y[i])
    J[:, 12:] = _by_camera(camera, x, y, Z)
    a, b, c = J[:, 12], J[:, 13], J[:, 14]
    u, v, w = X - camera.t[0], Y - camera.t[1], Z - camera.t[2]
    J[:, 9], J[:, 10], J[:, 11] = c * v - b * w, a * w - c * u, b * u - a * v  # (7)
    return J


def _by_camera(camera: Camera, x: Floats, y: Floats, Z: Floats) -> Floats:
    """d uv / d x_cam (2, 3, …) at normalised x and y and depth Z."""
    xx, xy, yy = lens.jacobian_entries(x, y, camera.distortion)
    J = np.empty((2, 3, *x.shape))
    J[:, 0], J[:, 1] = _scaled(camera, xx / Z, xy / Z), _scaled(camera, xy / Z, yy / Z)
    J[:, 2] = -(x * J[:, 0] + y * J[:, 1])  # (5)
    return J


def _scaled(camera: Camera, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """K₂ (x, y)."""
    return camera.K[0, 0] * x + camera.K[0, 1] * y, camera.K[1, 1] * y


def _last(J: Floats) -> Floats:
    """(2, k, …) as (…, 2, k)."""
    return np.ascontiguousarray(np.moveaxis(J, (0, 1), (-2, -1)))
