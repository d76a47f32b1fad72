"""A plain ring of cameras that look at the middle of a room."""

import numpy as np

from kinemark.data import Camera, Rig


def ring(n: int) -> Rig:
    """So many cameras all round, 4 m from the middle, of 1280 × 1024 px and 1000 px of focal length."""
    cameras = []
    for c in range(n):
        a = 2 * np.pi * c / n
        centre = np.array([4000 * np.cos(a), 4000 * np.sin(a), 2000.0])
        z = (np.array([0.0, 0.0, 1000.0]) - centre) / np.linalg.norm(centre - [0, 0, 1000])
        x = np.cross(z, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(z, [0.0, 0.0, 1.0]))
        R = np.stack([x, np.cross(z, x), z])
        K = np.array([[1000.0, 0.0, 640.0], [0.0, 1000.0, 512.0], [0.0, 0.0, 1.0]])
        cameras.append(Camera(f"cam{c}", np.array([1280, 1024]), K, R, -R @ centre))
    return Rig(tuple(cameras))
