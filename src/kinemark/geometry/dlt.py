"""The direct linear transformation of Abdel-Aziz and Karara (1971): eleven parameters a camera.

    u = (L1 X + L2 Y + L3 Z + L4) / (L9 X + L10 Y + L11 Z + 1)
    v = (L5 X + L6 Y + L7 Z + L8) / (L9 X + L10 Y + L11 Z + 1)           (1)  KISS eq. 7, UM²AS eq. B.4, B.5

These are the entries of a 3 × 4 projection P whose last one is 1. Multiplied out, (1) is linear in L,

    [X Y Z 1 0 0 0 0 −uX −uY −uZ] L = u
    [0 0 0 0 X Y Z 1 −vX −vY −vZ] L = v                                  (2)  UM²AS eq. B.6–B.8

and six points not in a plane determine it. With P = [M | m] and M = s K R, K and R come from an RQ
decomposition (3), t = K⁻¹ m / s (4); the sign of s makes the control volume lie in front of the
camera (5), and K[1, 1] < 0 where v is counted upwards, so that R is always a rotation (6).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..data import Camera, KinemarkError
from ..data.array_types import Floats
from ..numerics.vectors import across

SINGULAR = 1e12
"""Condition of M, above which no camera follows; chosen."""
PARALLEL = 0.01
"""Mean squared sine of the angle between optical axes and their common direction: about 6°; chosen."""


def to_dlt(P: Floats) -> Floats:
    """The eleven parameters (…, 11) of projections (…, 3, 4).

    Raises:
        KinemarkError: the world's origin lies in the camera's focal plane, where P[2, 3] = 0 and (1) does not exist.
    """
    scale = P[..., 2:, 3:]
    if (np.abs(scale[..., 0, 0]) < 1e-12 * np.abs(P).max((-1, -2))).any():
        raise KinemarkError(
            "The world's origin lies in a camera's focal plane, so the camera has no eleven DLT parameters. "
            "Move the origin, or keep the rig as TOML."
        )
    return (P / scale).reshape(*P.shape[:-2], 12)[..., :11]


def from_dlt(L: ArrayLike) -> Floats:
    """The projections (…, 3, 4) of eleven parameters (…, 11)."""
    L = np.asarray(L, np.float64)
    return np.concatenate([L, np.ones_like(L[..., :1])], -1).reshape(*L.shape[:-1], 3, 4)


def fit_dlt(xyz: Floats, uv: Floats) -> Floats:
    """The eleven parameters (11,) that best turn control points (N, 3) mm into pixels (N, 2), by (2).

    Both sides are first brought to zero mean and unit spread (Hartley 1997), without which (2) loses
    digits where coordinates are large. Rows with NaN are passed over.

    Raises:
        KinemarkError: fewer than six points, or points in one plane, on which (2) is singular.
    """
    seen = np.isfinite(xyz).all(1) & np.isfinite(uv).all(1)
    xyz, uv = xyz[seen], uv[seen]
    if len(xyz) < 6:
        raise KinemarkError(f"{len(xyz)} control points are seen, and a camera needs six. Place or find more of them.")
    A, T, U = equations(xyz, uv)
    _, s, Vt = np.linalg.svd(A.reshape(-1, 12), full_matrices=False)
    if s[10] < 1e-7 * s[0]:
        raise KinemarkError(
            f"The {len(xyz)} control points lie in a plane (or repeat), and no camera follows from that. "
            "Use points spread through the whole volume."
        )
    return to_dlt(np.linalg.inv(U) @ Vt[-1].reshape(3, 4) @ T)


def equations(xyz: Floats, uv: Floats) -> tuple[Floats, Floats, Floats]:
    """(2) with L12 free, (N, 2, 12), for coordinates normalised by T (4, 4) and U (3, 3).

    The vector that it takes to nearly nothing is P', and P = U⁻¹ P' T.
    """
    T, U = normalising(xyz), normalising(uv)
    X = np.column_stack([xyz, np.ones(len(xyz))]) @ T.T
    x = np.column_stack([uv, np.ones(len(uv))]) @ U.T
    zero = np.zeros_like(X)
    rows = [np.hstack([X, zero, -x[:, :1] * X]), np.hstack([zero, X, -x[:, 1:2] * X])]
    return np.stack(rows, 1), T, U


def decompose(P: Floats, *, front: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[Floats, Floats, Floats]:
    """K (3, 3), R (3, 3), t (3,) with P ~ K [R | t]; `front` is a world point (3,) that the camera has before it.

    Raises:
        KinemarkError: P has no optical centre at a finite place, so it is not a pinhole camera.
    """
    M = P[:, :3] / np.linalg.norm(P[2, :3])
    if np.linalg.cond(M) > SINGULAR:
        raise KinemarkError("The projection is singular: it is no pinhole camera. Calibrate again with other points.")
    depth = P[2] @ np.append(np.asarray(front, np.float64), 1.0)
    sign = np.sign(depth) or 1.0  # (5)
    K, R = scipy.linalg.rq(sign * M)  # (3)
    flip = np.diag(np.sign(np.diag(K)))
    K, R = K @ flip, flip @ R  # positive focal lengths; R may be a reflection
    if np.linalg.det(R) < 0:
        K, R = K @ np.diag([1.0, -1.0, 1.0]), np.diag([1.0, -1.0, 1.0]) @ R  # (6)
    t = np.linalg.solve(K, sign * P[:, 3] / np.linalg.norm(P[2, :3]))  # (4)
    return K / K[2, 2], R, t


def cameras_from_dlt(names: Sequence[str], L: Floats) -> tuple[Camera, ...]:
    """`camera_from_dlt` of cameras (C, 11) that look at one place.

    What the cameras have before them eleven parameters do not say. It is the place (3,) nearest to all optical axes,
    from a camera at c along d: the x of least Σ |(1 − d dᵀ) (x − c)|² (7). Where the axes are nearly parallel that is
    no place, and the world's origin is taken.
    """
    P = from_dlt(L)
    front = np.zeros(3)
    if len(P) > 1 and (np.linalg.cond(P[:, :, :3]) < SINGULAR).all():
        centre = -np.linalg.solve(P[:, :, :3], P[:, :, 3:])[..., 0]
        d = P[:, 2, :3] / np.linalg.norm(P[:, 2, :3], axis=1, keepdims=True)
        projectors = across(d)
        mean = centre.mean(0)
        if np.linalg.eigvalsh(projectors.mean(0))[0] > PARALLEL:
            right = (projectors @ (centre - mean)[..., None]).sum(0)[:, 0]
            front = mean + np.linalg.solve(projectors.sum(0), right)  # (7)
    return tuple(camera_from_dlt(name, row, front=front) for name, row in zip(names, L, strict=True))


def camera_from_dlt(name: str, L: ArrayLike, *, front: ArrayLike = (0.0, 0.0, 0.0), size: ArrayLike = (0, 0)) -> Camera:
    """A `Camera` without lens terms from eleven parameters (11,) in px and mm; `front` as in `decompose`."""
    K, R, t = decompose(from_dlt(L), front=front)
    return Camera(name, np.asarray(size, np.int64), K, R, t)


def normalising(points: Floats) -> Floats:
    """The homogeneous transform that brings points (N, d) to zero mean and unit spread."""
    d = points.shape[1]
    scale = 1 / max(float(np.sqrt(points.var(0).mean())), 1e-300)
    T = np.diag([scale] * d + [1.0])
    T[:d, d] = -scale * points.mean(0)
    return T
