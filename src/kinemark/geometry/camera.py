"""Between world points and pixels, with derivatives.

The model is that of `data.rig`, equations (1)–(4). Its derivatives, with x_cam = (X, Y, Z):

    d(x, y)/d x_cam = [[1/Z, 0, −x/Z], [0, 1/Z, −y/Z]]                   (5)
    d uv / d xyz    = K₂ · lens' · (5) · R                               (6)
    d x_cam / d r   = −[x_cam − t]×    for R ← exp([r]×) R               (7)

K₂ is the upper left 2 × 2 of K.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data import Camera, Rig
from . import lens


def to_camera(camera: Camera, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """World points (…, 3) mm in the camera's frame (…, 3) mm; the third is the depth."""
    return xyz @ camera.R.T + camera.t


def pixels(camera: Camera, xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normalised image points (…, 2) as pixels (…, 2)."""
    return xy @ camera.K[:2, :2].T + camera.K[:2, 2]


def normalised(camera: Camera, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (…, 2) as points of the normalised image plane (…, 2), the lens's distortion still in."""
    y = (uv[..., 1] - camera.K[1, 2]) / camera.K[1, 1]
    return np.stack([(uv[..., 0] - camera.K[0, 2] - camera.K[0, 1] * y) / camera.K[0, 0], y], -1)


def project(camera: Camera, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (…, 2) of world points (…, 3) mm, as the lens draws them; NaN behind the camera."""
    x_cam = to_camera(camera, xyz)
    depth = np.where(x_cam[..., 2:] > 0, x_cam[..., 2:], np.nan)
    return pixels(camera, lens.distort(x_cam[..., :2] / depth, camera.distortion))


def project_all(rig: Rig, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (C, …, 2) of world points (…, 3) mm in every camera."""
    return np.stack([project(camera, xyz) for camera in rig])


def undistort(camera: Camera, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (…, 2) as an ideal lens would draw them (…, 2), so that `Camera.P` holds for them."""
    return pixels(camera, lens.undistort(normalised(camera, uv), camera.distortion))


def distort(camera: Camera, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels of an ideal lens (…, 2) as this lens draws them (…, 2)."""
    return pixels(camera, lens.distort(normalised(camera, uv), camera.distortion))


def rays(camera: Camera, uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit directions (…, 3) in the world from `camera.centre` to what is seen at pixels (…, 2)."""
    xy = lens.undistort(normalised(camera, uv), camera.distortion)
    ahead = np.concatenate([xy, np.ones_like(xy[..., :1])], -1) @ camera.R
    return ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)


def point_jacobian(camera: Camera, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """d uv / d xyz (…, 2, 3), px/mm, of `project` at world points (…, 3) mm."""
    return _camera_jacobian(camera, to_camera(camera, xyz)) @ camera.R  # (6)


def parameter_jacobian(camera: Camera, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """d uv / d parameters (…, 2, 15) of `project`, in the order of `data.PARAMETERS`."""
    x_cam = to_camera(camera, xyz)
    xy = x_cam[..., :2] / x_cam[..., 2:]
    drawn = lens.distort(xy, camera.distortion)
    J = np.zeros((*xyz.shape[:-1], 2, 15))
    J[..., 0, 0], J[..., 1, 1] = drawn[..., 0], drawn[..., 1]
    J[..., 0, 2] = J[..., 1, 3] = 1.0
    J[..., 4:9] = camera.K[:2, :2] @ _lens_parameters(xy)
    by_point = _camera_jacobian(camera, x_cam)
    J[..., 9:12] = by_point @ _cross(-(x_cam - camera.t))  # (7)
    J[..., 12:15] = by_point
    return J


def _camera_jacobian(camera: Camera, x_cam: NDArray[np.float64]) -> NDArray[np.float64]:
    """d uv / d x_cam (…, 2, 3)."""
    z = x_cam[..., 2]
    xy = x_cam[..., :2] / z[..., None]
    A = np.zeros((*xy.shape[:-1], 2, 3))
    A[..., 0, 0] = A[..., 1, 1] = 1 / z
    A[..., 2] = -xy / z[..., None]  # (5)
    return camera.K[:2, :2] @ (lens.jacobian(xy, camera.distortion) @ A)


def _lens_parameters(xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """d(x', y') / d(k1, k2, p1, p2, k3) (…, 2, 5)."""
    x, y = xy[..., 0], xy[..., 1]
    r2 = x * x + y * y
    along_x = np.stack([x * r2, x * r2**2, 2 * x * y, r2 + 2 * x * x, x * r2**3], -1)
    along_y = np.stack([y * r2, y * r2**2, r2 + 2 * y * y, 2 * x * y, y * r2**3], -1)
    return np.stack([along_x, along_y], -2)


def _cross(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """[v]×, (…, 3) → (…, 3, 3)."""
    zero = np.zeros_like(v[..., 0])
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    return np.stack(
        [np.stack([zero, -z, y], -1), np.stack([z, zero, -x], -1), np.stack([-y, x, zero], -1)],
        -2,
    )
