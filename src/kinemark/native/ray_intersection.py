"""Where the rays of images of several cameras meet, for many points at once.

The linear solution, (3) of `geometry.triangulate`, then one step of least squares by the noise of the images, as if the
projection were linear about it:

    cov = (Σ Jᵀ J / s²)⁻¹,   moved = cov Σ Jᵀ (image − u) / s²           (1)
    d² = |image − u − J moved|² / s²                                     (2)

with u the projection of the linear solution and s² the variance of the image. The points are along the last axis.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints
from .array_checks import FLOAT, Arrays, index
from .compiled_library import library
from .symmetric3 import inverse, solve

_INTERSECT = Arrays(
    P=(FLOAT, "C", 3, 4),
    uv=(FLOAT, "D", 2),
    variance=(FLOAT, "D"),
    detection=(index("D", none=True), "k", "n"),
    camera=(index("C"), "k", "n"),
)


def intersect(P: Floats, uv: Floats, variance: Floats, detection: Ints, camera: Ints) -> tuple[Floats, Floats, Floats]:
    """Points from their images, by (1) and (2).

    Args:
        P: (C, 3, 4) projections.
        uv: (D, 2) px of all images.
        variance: (D) px².
        detection: (k, n) indices of the images of each point; −1 for none.
        camera: (k, n) of each image.

    Returns:
        xyz (3, n) mm, NaN where rays are parallel; cov (3, 3, n) mm²; d² (k, n), −1 where there is no image.

    Raises:
        ValueError: an array has another shape or dtype, or an index is out of range.
    """
    arrays = P, uv, variance, detection, camera = _INTERSECT(P, uv, variance, detection, camera)
    if compiled := library():
        k, n = detection.shape
        out = np.empty((3, n)), np.empty((3, 3, n)), np.empty((k, n))
        if compiled.intersect(len(P), k, n, len(uv), *arrays, *out):
            return out
    _INTERSECT.check_indices(arrays)
    return _numpy_intersect(*arrays)


@np.errstate(all="ignore")
def _numpy_intersect(
    P: Floats, uv: Floats, variance: Floats, detection: Ints, camera: Ints
) -> tuple[Floats, Floats, Floats]:
    if not len(uv):
        uv, variance = np.zeros((1, 2)), np.ones(1)  # something that index −1 may mean
    seen, P, uv = detection >= 0, P.transpose(1, 2, 0)[:, :, camera], uv.T[:, detection]
    variance = np.where(seen, variance[detection], 1.0)
    rows = np.where(seen, P[:2] - uv[:, None] * P[2], 0.0)  # (2, 4, k, n)
    guess = solve(_squares(rows[:, :3], rows[:, :3]), -_sums(rows[:, :3], rows[:, 3]))
    h = np.einsum("ijkn,jn->ikn", P[:, :3], guess) + P[:, 3]
    z = np.where(h[2] > 0, h[2], np.nan)
    off = np.where(seen, uv - h[:2] / z, 0.0)
    J = np.where(seen, (P[:2, :3] - (h[:2] / z)[:, None] * P[2, :3]) / z, 0.0)
    cov = inverse(_squares(J / variance, J))
    moved = np.einsum("ijn,jn->in", cov, _sums(J / variance, off))  # (1)
    off -= np.einsum("ijkn,jn->ikn", J, moved)
    squared = (off * off).sum(0) / variance  # (2)
    squared = np.where(np.isnan(squared), np.inf, squared)
    return guess + moved, cov, np.where(seen, squared, -1.0)


def _squares(A: Floats, B: Floats) -> Floats:
    """Σ A Bᵀ (3, 3, n) over the coordinates and cameras of (2, 3, k, n)."""
    return np.einsum("aikn,ajkn->ijn", A, B)


def _sums(A: Floats, b: Floats) -> Floats:
    """Σ A b (3, n) over the coordinates and cameras of (2, 3, k, n) and (2, k, n)."""
    return np.einsum("aikn,akn->in", A, b)
