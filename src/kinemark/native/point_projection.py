"""Points in cameras: where they are expected, and what images there say of them.

A point expected at X with covariance V is expected in a camera at its projection u, with the covariance of the
difference from a centroid of variance s²

    S = J V Jᵀ + s² I,   J = ∂u/∂X                                       (1)

and an image there at v says of the point N = Jᵀ J / s², g = Jᵀ (v − u) / s² (2), added up over the cameras.

The points are along the last axis of every array.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats, Ints
from .array_checks import FLOAT, Arrays, index
from .compiled_library import library

_PROJECT = Arrays(P=(FLOAT, "C", 3, 4), xyz=(FLOAT, 3, "n"), cov=(FLOAT, 3, 3, "n"))
_INFORMATION = Arrays(
    uv=(FLOAT, "C", 2, "n"),
    J=(FLOAT, "C", 2, 3, "n"),
    detection=(index("D", none=True), "C", "n"),
    variance=(FLOAT, "C", "n"),
    images=(FLOAT, "D", 2),
)


def project(P: Floats, xyz: Floats, cov: Floats) -> tuple[Floats, Floats, Floats]:
    """Where cameras see points, by (1) without s².

    Args:
        P: (C, 3, 4) projections.
        xyz: (3, n) mm.
        cov: (3, 3, n) their covariance, mm².

    Returns:
        uv (C, 2, n) px, NaN behind a camera; J (C, 2, 3, n) px/mm; the xx, xy and yy of S (C, 3, n) px².

    Raises:
        ValueError: an array has another shape or dtype.
    """
    P, xyz, cov = _PROJECT(P, xyz, cov)
    if compiled := library():
        C, n = len(P), xyz.shape[1]
        out = np.empty((C, 2, n)), np.empty((C, 2, 3, n)), np.empty((C, 3, n))
        compiled.project(C, n, P, xyz, cov, *out)
        return out
    return _numpy_project(P, xyz, cov)


@np.errstate(all="ignore")
def _numpy_project(P: Floats, xyz: Floats, cov: Floats) -> tuple[Floats, Floats, Floats]:
    h = (P[:, :, :3].reshape(-1, 3) @ xyz + P[:, :, 3].reshape(-1, 1)).reshape(len(P), 3, xyz.shape[1])
    z = np.where(h[:, 2:] > 0, h[:, 2:], np.nan)
    uv = h[:, :2] / z
    J = (P[:, :2, :3, None] - uv[:, :, None] * P[:, 2:, :3, None]) * (1 / z)[:, None]
    JV = np.einsum("cait,ijt->cajt", J, cov)
    S = np.einsum("cait,cait->cat", JV[:, [0, 0, 1]], J[:, [0, 1, 1]])  # (1)
    return uv, J, S


def information(uv: Floats, J: Floats, detection: Ints, variance: Floats, images: Floats) -> tuple[Floats, Floats]:
    """What images say of points, by (2).

    Args:
        uv: (C, 2, n) px where cameras expect the points, of `project`.
        J: (C, 2, 3, n) px/mm, of `project`.
        detection: (C, n) index of the image of each point in each camera; −1 for none.
        variance: (C, n) px² of these.
        images: (D, 2) px, all images.

    Returns:
        N (3, 3, n) 1/mm² and g (3, n) 1/mm.

    Raises:
        ValueError: an array has another shape or dtype, or an index is out of range.
    """
    arrays = uv, J, detection, variance, images = _INFORMATION(uv, J, detection, variance, images)
    if compiled := library():
        C, n = detection.shape
        out = np.zeros((3, 3, n)), np.zeros((3, n))
        if compiled.information(C, n, len(images), *arrays, *out):
            return out
    _INFORMATION.check_indices(arrays)
    return _numpy_information(*arrays)


@np.errstate(all="ignore")
def _numpy_information(
    uv: Floats, J: Floats, detection: Ints, variance: Floats, images: Floats
) -> tuple[Floats, Floats]:
    has = detection >= 0
    images = images if len(images) else np.zeros((1, 2))  # something that index −1 may mean
    off = np.where(has[:, None], images[detection].swapaxes(1, 2) - uv, 0.0)
    J = np.where(has[:, None, None], J, 0.0)
    JW = J * np.where(has, 1 / variance, 0.0)[:, None, None]
    return np.einsum("cait,cajt->ijt", JW, J), np.einsum("cait,cat->it", JW, off)  # (2)
