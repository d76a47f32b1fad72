"""How much of each pixel a sphere's image covers.

At the centre of every pixel the lens is undone exactly, and its derivative carries n × n lines of sight per pixel
from there. A line d meets the sphere where

    g(d) = (d · c)/(|d| |c|) − √(1 − r²/|c|²) ≥ 0                (`sphere_image`, equation 1)         (1)

The signed distance of the line from the outline is g/|∇g| px to first order, with d = (x, y, 1) and

    ∂g/∂(x, y) = [c₂ − (d · c)/|d|² (x, y)] / (|d| |c|)                                              (2)

and the share of its cell of 1/n px that the disc covers is 1/2 + n g/|∇g|, held between 0 and 1 (3). A limb that
passes before the sphere takes its share away in the same manner, from the distance between line and axis less
its radius (`occlusion`) (4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import Camera
from ..data.array_types import Floats
from ..geometry import lens, normalised, to_camera
from ..numerics.small_matrices import inverse2
from ..numerics.vectors import homogeneous
from .occlusion import line_distance

Box = tuple[int, int, int, int]
"""First and last-plus-one column, first and last-plus-one row."""


class Ball(NamedTuple):
    """One sphere to draw: centre (3) mm, radius mm, grey levels, peak of its halo."""

    xyz: Floats
    radius: float
    brightness: float
    glare: float


class Limbs(NamedTuple):
    """The limbs of one frame: ends (L, 3) mm, radius (L) mm."""

    a: Floats
    b: Floats
    radius: Floats


def pixels(box: Box) -> Floats:
    """(N, 2) u, v of all pixels in a box, line by line."""
    v, u = np.mgrid[box[2] : box[3], box[0] : box[1]]
    return np.stack([u.ravel(), v.ravel()], -1).astype(np.float64)


def sight_lines(camera: Camera, uv: Floats, n: int) -> tuple[Floats, Floats]:
    """Lines of sight (N, n·n, 2) as points of the ideal normalised plane, and d(x, y)/d(u, v) (N, 2, 2) there."""
    drawn = normalised(camera, uv)
    ideal = lens.undistort(drawn, camera.distortion)
    turn = inverse2(camera.K[:2, :2] @ lens.jacobian(ideal, camera.distortion))
    step = (np.arange(n) + 0.5) / n - 0.5
    cell = np.stack(np.meshgrid(step, step), -1).reshape(-1, 2)
    return ideal[:, None] + cell @ turn.transpose(0, 2, 1), turn


def disc(camera: Camera, ball: Ball, xy: Floats, turn: Floats, n: int) -> tuple[Floats, Floats]:
    """Share of each cell (N, S) inside the outline (3), and cosine of the angle at which the line meets the sphere."""
    c = to_camera(camera, ball.xyz)
    far = np.linalg.norm(c)
    edge = np.sqrt(1 - (ball.radius / far) ** 2)
    x, y = xy[..., 0], xy[..., 1]
    dd = x * x + y * y + 1
    dc = x * c[0] + y * c[1] + c[2]
    length = np.sqrt(dd) * far
    g = dc / length - edge  # (1)
    along = dc / dd
    slope_x, slope_y = (c[0] - along * x) / length, (c[1] - along * y) / length  # (2)
    slope_u = slope_x * turn[:, None, 0, 0] + slope_y * turn[:, None, 1, 0]
    slope_v = slope_x * turn[:, None, 0, 1] + slope_y * turn[:, None, 1, 1]
    distance = g / np.maximum(np.sqrt(slope_u * slope_u + slope_v * slope_v), 1e-15)
    share = np.clip(0.5 + n * distance, 0, 1)  # (3)
    return np.where(np.isnan(share), 0.0, share), np.sqrt(np.clip(g / (1 - edge), 0, 1))


def visible_share(camera: Camera, ball: Ball, xy: Floats, limbs: Limbs, n: int) -> Floats | float:
    """Share of each cell (N, S) that no limb hides (4)."""
    if not len(limbs.radius):
        return 1.0
    before = line_distance(camera.centre, ball.xyz - camera.centre, limbs.a, limbs.b) < limbs.radius + 1.1 * ball.radius
    if not before.any():
        return 1.0
    depth = to_camera(camera, ball.xyz)[2]
    ends = depth * homogeneous(xy) @ camera.R
    cells_per_mm = n * abs(camera.K[0, 0]) / depth
    free: Floats = np.ones(xy.shape[:-1])
    for a, b, radius in zip(limbs.a[before], limbs.b[before], limbs.radius[before], strict=True):
        clear = line_distance(camera.centre, ends, a, b) - radius
        free = free * np.clip(0.5 + cells_per_mm * clear, 0, 1)
    return free
