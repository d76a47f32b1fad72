"""Vectors of space: lengths, cross products and perpendiculars."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats

T = TypeVar("T", bound=np.floating)
AFTER, BEFORE = [1, 2, 0], [2, 0, 1]  # places of y z x and of z x y; by definition


def lengths(v: NDArray[T]) -> NDArray[T]:
    """(…) of vectors (…, 3), to the last digit as NumPy sums their squares, which takes several times as long."""
    x, y, z = (v[..., k] for k in range(3))
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def cross(a: Floats, b: Floats) -> Floats:
    """a × b (…, 3), without the overhead of `numpy.cross`, which takes ten times as long for few vectors."""
    return np.asarray(a[..., AFTER] * b[..., BEFORE] - a[..., BEFORE] * b[..., AFTER])


def cross_matrix(v: Floats) -> Floats:
    """[v]× (…, 3, 3) of vectors (…, 3): its product with b is v × b."""
    x, y, z = np.moveaxis(v, -1, 0)
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -z, y, -x
    return out - out.mT


def across(direction: Floats) -> Floats:
    """(…, 3, 3) what takes of a vector the part that is perpendicular to a unit vector d (…, 3): I − d dᵀ."""
    return np.eye(3) - direction[..., :, None] * direction[..., None, :]


def homogeneous(x: Floats) -> Floats:
    """(…, d) → (…, d + 1), a one appended."""
    return np.concatenate([x, np.ones_like(x[..., :1])], -1)


def perpendicular_pair(direction: Floats) -> Floats:
    """(n, 3, 2) two unit vectors, perpendicular to each other and to unit vectors (n, 3); NaN where these are."""
    least = np.eye(3)[np.abs(np.nan_to_num(direction)).argmin(1)]
    first = np.cross(direction, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(direction, first)], -1)
