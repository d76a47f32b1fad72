"""One control point taken for another in an image: which, and for which.

The DLT's equations of point i with the image u are two rows, M_i(u) their normal matrix, and Σ M_i(u_i) has a
least eigenvalue of nearly nothing if points and images belong together. With the images of i and j swapped it is

    Σ M_k(u_k) − M_i(u_i) − M_j(u_j) + M_i(u_j) + M_j(u_i)               (1)

so that all pairs cost one batch of eigenvalues of 12 × 12. The best few pairs are judged by the camera with
a lens, whose sum of squares S over ν equations left over must fall from S0 by as much as chance does not: the ratio of
two such sums follows F(ν, ν), and its upper tail must be below `CHANCE` for any of the pairs tried (2). Leaving a
single point out takes two equations, (S0 − S) / 2 over S / (ν − 2) follows F(2, ν − 2) (3).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy

from ...data import Finding, KinemarkError, make_finding
from ...data.array_types import Floats, Ints
from ...geometry.dlt import equations
from .checks import FEWEST
from .fit_camera import ControlPoints, fit_all

CHANCE = 1e-3  # probability below which an improvement is not taken for chance; conventional
MOST_POINTS = 60  # above which all pairs are not tried; chosen for speed
MOST_SWAPS = 3  # pairs that may be swapped in one camera; chosen (see studies/calibration_quality.py)
CANDIDATES = 4  # pairs, the most promising, that are fitted in full; chosen for speed


class SwappedPoints(NamedTuple):
    """Whose image each point's own is (N), and the RMS residual before and after, px."""

    image_of: Ints
    before: float
    after: float


def find_swapped_points(xyz: Floats, uv: Floats) -> SwappedPoints | None:
    """The exchange of images (N, 2) px among points (N, 3) mm that makes one camera see them much better, if any."""
    n = len(xyz)
    if not FEWEST < n <= MOST_POINTS:
        return None
    image_of = np.arange(n)
    start = total = _start(xyz, uv)
    for _ in range(MOST_SWAPS):
        candidates = [_swapped(image_of, pair) for pair in _best_pairs(xyz, uv[image_of])]
        sums = [sum_of_squares(xyz, uv[t]) for t in candidates]
        best = int(np.argmin(sums))
        if not sums[best] < total / 2:
            break
        image_of, total = candidates[best], sums[best]
    nu = 2 * n - int(_parameters(n))
    if not total < start or scipy.special.fdtrc(nu, nu, start / max(total, 1e-12)) > CHANCE / (n * (n - 1) / 2):  # (2)
        return None
    return SwappedPoints(image_of, float(np.sqrt(start / n)), float(np.sqrt(total / n)))


def misplaced(xyz: Floats, uv: Floats) -> tuple[int, float, float] | None:
    """The one point without which the camera sees the others much better, and their RMS residuals, px, if any; (3)."""
    n = len(xyz)
    nu = 2 * n - int(_parameters(n - 1)) - 2
    if n <= FEWEST or nu < 2 or n > MOST_POINTS:
        return None
    start = _start(xyz, uv)
    without = np.array([sum_of_squares(np.delete(xyz, i, 0), np.delete(uv, i, 0)) for i in range(n)])
    i = int(without.argmin())
    if not np.isfinite(without[i]):
        return None
    ratio = (start - without[i]) / 2 / (max(without[i], 1e-12) / nu)
    if not scipy.special.fdtrc(2, nu, ratio) < CHANCE / n:
        return None
    return i, float(np.sqrt(start / n)), float(np.sqrt(without[i] / (n - 1)))


def mistaken_points(xyz: Floats, uv: Floats, names: Sequence[str], *, camera: str) -> Finding | None:
    """What one camera's images (N, 2) px of points (N, 3) mm say of points taken for one another; None if nothing."""
    if len(xyz) <= FEWEST:
        return None
    if (swap := find_swapped_points(xyz, uv)) is not None:
        moved = np.flatnonzero(swap.image_of != np.arange(len(xyz)))
        return make_finding(
            "control_points_swapped",
            cameras=[camera],
            points_list=[names[int(i)] for i in moved],
            image_of_list=[names[int(i)] for i in swap.image_of[moved]],
            before_px=swap.before,
            after_px=swap.after,
        )
    if (single := misplaced(xyz, uv)) is not None:
        i, before, after = single
        return make_finding(
            "control_point_misplaced", cameras=[camera], point=names[i], before_px=before, after_px=after
        )
    return None


def sum_of_squares(xyz: Floats, uv: Floats) -> float:
    """Of all residuals of the best camera, px²; infinite where there is none."""
    all_alike, everything = np.tile(np.eye(2), (len(xyz), 1, 1)), np.ones(len(xyz), np.bool_)
    try:
        _, fit = fit_all("", np.zeros(2, np.int64), xyz, uv, all_alike, everything, ControlPoints(), None)
    except (KinemarkError, np.linalg.LinAlgError, ValueError):
        return float("inf")
    return float((fit.residual**2).sum())


def _start(xyz: Floats, uv: Floats) -> float:
    """The sum of squares as things are; where no camera sees them so, that of the images about their mean."""
    found = sum_of_squares(xyz, uv)
    return found if np.isfinite(found) else float(((uv - uv.mean(0)) ** 2).sum())


def _parameters(n: int) -> int:
    return 11 if n > 10 else 10


def _swapped(image_of: Ints, pair: tuple[int, int]) -> Ints:
    swapped = image_of.copy()
    swapped[list(pair)] = image_of[list(pair[::-1])]
    return swapped


def _best_pairs(xyz: Floats, uv: Floats) -> list[tuple[int, int]]:
    """The pairs with the least eigenvalues of (1)."""
    A, _, U = equations(xyz, uv)
    X = A[:, 0, :4]
    x = np.column_stack([uv, np.ones(len(uv))]) @ U.T
    pairs = np.array(list(combinations(range(len(xyz)), 2)))
    i, j = pairs.T
    M = _normal(X, x[:, :2])
    each = M.sum(0) - M[i] - M[j] + _normal(X[i], x[j, :2]) + _normal(X[j], x[i, :2])  # (1)
    best = np.argsort(np.linalg.eigvalsh(each)[:, 0])[:CANDIDATES]
    return [(int(a), int(b)) for a, b in pairs[best]]


def _normal(X: Floats, uv: Floats) -> Floats:
    """M (n, 12, 12) of points (n, 4) at normalised images (n, 2)."""
    zero = np.zeros_like(X)
    rows = np.stack([np.hstack([X, zero, -uv[:, :1] * X]), np.hstack([zero, X, -uv[:, 1:] * X])], 1)
    return rows.transpose(0, 2, 1) @ rows
