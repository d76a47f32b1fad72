"""Placing cameras in the laboratory.

A camera is given by its position, three orientation angles and a focal length (Swamidas 4.1.2). At zero angles
it looks level along world +Y with world +X to its right and world +Z up; its image has u to the right and v down,
so that the rows of its world → camera rotation are

    R₀ = [[1, 0, 0], [0, 0, −1], [0, 1, 0]]                                        (1)

The angles turn it about its own axes in the order z, x, y:

    R = R₀ Rᵧ(θy)ᵀ Rₓ(θx)ᵀ R_z(θz)ᵀ                                                (2)

θz is the heading, counter-clockwise seen from above; θx the elevation of the optical axis; θy the roll about the
optical axis, clockwise seen from behind the camera. A camera that looks along the unit vector d has

    θz = atan2(−d_x, d_y),    θx = atan2(d_z, √(d_x² + d_y²))                      (3)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..data import Camera, Rig
from ..data.array_types import Floats

VOLUME = np.array([[0.0, 0.0, 0.0], [2400.0, 1400.0, 2000.0]])
"""The control volume of KISS, mm: 2.4 m along the walkway (x), 1.4 m across (y), 2 m high."""

LEVEL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""R₀ of (1); by definition."""


def focal_pixels(focal_mm: float, pitch_um: float) -> float:
    """Focal length in px of a lens of `focal_mm` before pixels `pitch_um` wide.

    Raises:
        ValueError: one of them is not above 0.
    """
    if not (focal_mm > 0 and pitch_um > 0):
        raise ValueError(f"focal_mm and pitch_um must be positive, found {focal_mm} and {pitch_um}")
    return 1000.0 * focal_mm / pitch_um


def place_camera(
    name: str,
    position: ArrayLike,
    angles_deg: ArrayLike,
    *,
    focal_px: float | tuple[float, float] = 1300.0,
    size: tuple[int, int] = (1280, 1024),
    distortion: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0),
) -> Camera:
    """A camera from its position (3) mm, its angles (θx, θy, θz) deg of (2) and its focal length.

    Args:
        name: of the camera.
        position: (3) the optical centre in the world, mm.
        angles_deg: (3) about the camera's x, y and z, deg; applied in the order z, x, y.
        focal_px: one focal length, or two where pixels are not square, as in the fields of interlaced video.
        size: width and height, px; the optical axis meets the image at its centre.
        distortion: (5) k1 k2 p1 p2 k3.

    Raises:
        ValueError: a focal length is not positive.
    """
    focal = np.broadcast_to(np.asarray(focal_px, np.float64), 2)
    if not (focal > 0).all():
        raise ValueError(f"focal_px must be positive, found {focal_px}")
    x, y, z = np.asarray(angles_deg, np.float64)
    R = LEVEL @ scipy.spatial.transform.Rotation.from_euler("ZXY", [z, x, y], degrees=True).as_matrix().T  # (2)
    K = np.array([[focal[0], 0.0, (size[0] - 1) / 2], [0.0, focal[1], (size[1] - 1) / 2], [0.0, 0.0, 1.0]])
    t = -R @ np.asarray(position, np.float64)
    return Camera(name, np.asarray(size, np.int64), K, R, t, np.asarray(distortion, np.float64))


def look_at(
    name: str,
    position: ArrayLike,
    target: ArrayLike,
    *,
    roll_deg: float = 0.0,
    focal_px: float | tuple[float, float] = 1300.0,
    size: tuple[int, int] = (1280, 1024),
    distortion: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0),
) -> Camera:
    """A camera at `position` (3) mm that has `target` (3) mm in the centre of its image, its sides upright.

    One that looks straight down has world +Y upwards in its image.

    Raises:
        ValueError: the target is where the camera is.
    """
    d = np.asarray(target, np.float64) - np.asarray(position, np.float64)
    if not np.linalg.norm(d) > 0:
        raise ValueError(f"camera {name}: target and position are the same, {np.asarray(position)}")
    level = float(np.hypot(d[0], d[1]))
    heading = np.arctan2(-d[0], d[1]) if level > 1e-9 * abs(d[2]) else 0.0
    angles = (*np.degrees([np.arctan2(d[2], level)]), roll_deg, np.degrees(heading))  # (3)
    return place_camera(name, position, angles, focal_px=focal_px, size=size, distortion=distortion)


def ring(
    n: int,
    *,
    radius: float = 4200.0,
    height: Sequence[float] = (1100.0, 2300.0),
    target: ArrayLike = (1200.0, 700.0, 850.0),
    start_deg: float = 5.0,
    sweep_deg: float = 360.0,
    focal_px: float | tuple[float, float] = 1300.0,
    size: tuple[int, int] = (1280, 1024),
    distortion: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0),
    volume: ArrayLike = VOLUME,
) -> Rig:
    """`n` cameras `cam1`, `cam2`, … on a circle about the target, their heights (mm) taken from `height` in turn.

    Args:
        n: how many cameras.
        radius: of the circle, mm, level.
        height: of the cameras above the floor, mm, used cyclically.
        target: (3) what every camera has in its image's centre, mm.
        start_deg: direction of the first camera seen from the target, from +X counter-clockwise; by default no camera
            looks along a diagonal of the KISS volume, where two rods of the control frame would stand in line.
        sweep_deg: the arc they stand on; 360 is the whole circle, less puts the last camera at its end.
        focal_px: as in `place_camera`.
        size: of the images, px.
        distortion: (5) of every lens.
        volume: (2, 3) control volume to note on the rig, mm.

    Raises:
        ValueError: fewer than one camera.
    """
    if n < 1:
        raise ValueError(f"n is {n}, wanted at least one camera")
    centre = np.asarray(target, np.float64)
    angles = np.radians(start_deg + _steps(n, sweep_deg))
    cameras = []
    for i, turn in enumerate(angles):
        place = np.array([*(centre[:2] + radius * np.array([np.cos(turn), np.sin(turn)])), height[i % len(height)]])
        cameras.append(look_at(f"cam{i + 1}", place, centre, focal_px=focal_px, size=size, distortion=distortion))
    return Rig(tuple(cameras), "placed in the virtual laboratory", np.asarray(volume, np.float64))


def _steps(n: int, sweep_deg: float) -> Floats:
    """(n) deg along the arc; a whole circle does not repeat its first place."""
    gaps = n if abs(sweep_deg) >= 360 else max(n - 1, 1)
    return np.arange(n) * sweep_deg / gaps
