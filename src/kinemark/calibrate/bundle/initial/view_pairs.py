"""Pairs of cameras: which see the same points, and their epipolar geometry.

Fundamental matrices are first found for images as they are, wrong points left out by the median. Right points of
cameras whose lenses bend lines then tell by how much (`optics`), and the matrices are found again.

Points in a plane fit no F in particular: there the image in one camera is a homography of that in the other, H x₁ ~ x₂,
which four points determine, and which points at different depths are far from. Pairs for which all points fit one
within `FLAT` of the image's diagonal are no use.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ....data import KinemarkError
from ....data.array_types import Bools, Floats, Ints
from ....geometry.two_view import robust_fundamental, sampson_distance
from ....numerics.robust import SD_PER_MEDIAN
from ....numerics.vectors import homogeneous
from ..parts import complete
from .unknown_optics import UnknownOptics, straightened

FEWEST_COMMON = 24  # points that a pair must share; chosen: three times the eight of a fundamental matrix
ENOUGH = 40  # poses by which two cameras are joined well; chosen: three times the fewest
FLAT = 0.003
"""Of the image's diagonal; pairs that a homography explains to this are no use; chosen (see benchmarks/bundle.py)."""


class Pair(NamedTuple):
    """Two cameras; F of their ideal pixels; which points (N) fit it; their Sampson distances' scale, px."""

    a: int
    b: int
    F: Floats
    good: Bools
    scale: float


def common_points(uv: Floats) -> Ints:
    """(C, C) how many points two cameras both see."""
    seen = complete(uv).astype(np.int64)
    return np.asarray(seen @ seen.T)


class Link(NamedTuple):
    """Two cameras, and how many things both see."""

    a: int
    b: int
    shared: int


def weakest_link(common: Ints) -> Link:
    """Of the cameras by which all hang together, `common` (C, C), the two that share least; 0 where some are apart."""
    apart = np.divide(1.0, common, out=np.zeros(common.shape), where=common > 0)  # 0 is no link
    links = scipy.sparse.csgraph.minimum_spanning_tree(apart).tocoo()
    if not 0 < links.nnz == len(common) - 1:
        return Link(0, 0, 0)
    a, b = (int(each[links.data.argmax()]) for each in (links.row, links.col))
    return Link(a, b, int(common[a, b]))


def find_pairs(optics: list[UnknownOptics], uv: Floats, *, seed: int) -> tuple[list[UnknownOptics], list[Pair]]:
    """Cameras whose lines are straightened, and all pairs with enough points in common, most points first.

    Raises:
        KinemarkError: all points lie in a plane.
    """
    common = common_points(uv)
    ab = [(a, b) for a in range(len(uv)) for b in range(a + 1, len(uv)) if common[a, b] >= FEWEST_COMMON]
    rough = [_pair(optics, uv, a, b, seed) for a, b in ab]
    optics = straightened(optics, uv, {(p.a, p.b): p.good for p in rough})
    pairs = sorted((_pair(optics, uv, a, b, seed) for a, b in ab), key=lambda p: -p.good.sum())
    flat = [flatness(optics[p.a].ideal(uv[p.a, p.good]), optics[p.b].ideal(uv[p.b, p.good])) for p in pairs]
    limits = [FLAT * 2 * optics[p.b].half for p in pairs]
    if all(off < limit for off, limit in zip(flat, limits, strict=True)):
        raise KinemarkError(
            f"All points lie in a plane, on a line or in one place: a plane explains all images within {max(flat):.1f} "
            "px, and no calibration follows from that. Wave through the whole volume, in depth and height as well."
        )
    return optics, pairs


def _pair(optics: list[UnknownOptics], uv: Floats, a: int, b: int, seed: int) -> Pair:
    x, y = optics[a].ideal(uv[a]), optics[b].ideal(uv[b])
    F, good = robust_fundamental(x, y, seed=seed)
    return Pair(a, b, F, good, SD_PER_MEDIAN * float(np.median(np.abs(sampson_distance(F, x[good], y[good])))))


def flatness(x: Floats, y: Floats) -> float:
    """Median distance, px, of points y (N, 2) from where the best homography takes x (N, 2): small for a plane."""
    size_x, size_y = x.std() or 1.0, y.std() or 1.0
    p, q = homogeneous((x - x.mean(0)) / size_x), homogeneous((y - y.mean(0)) / size_y)
    zero = np.zeros_like(p)
    rows = np.concatenate([np.hstack([p, zero, -q[:, :1] * p]), np.hstack([zero, p, -q[:, 1:2] * p])])
    H = np.linalg.svd(rows, full_matrices=False)[2][-1].reshape(3, 3)
    image = p @ H.T
    return float(np.median(np.linalg.norm(image[:, :2] / image[:, 2:] - q[:, :2], axis=1)) * size_y)
