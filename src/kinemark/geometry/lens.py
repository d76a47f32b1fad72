"""Lens distortion on the normalised image plane (Brown 1966, with OpenCV's names and order).

With r² = x² + y² and the terms k1 k2 p1 p2 k3

    g  = 1 + k1 r² + k2 r⁴ + k3 r⁶                                       (1)
    x' = x g + 2 p1 x y + p2 (r² + 2 x²)                                 (2)
    y' = y g + p1 (r² + 2 y²) + 2 p2 x y                                 (3)

(2) and (3) have no closed inverse; `undistort` solves them by Newton's method with the Jacobian of
`jacobian`, which converges in three or four steps wherever the model is one to one.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Floats

NEWTON_STEPS = 12  # at most; three or four are enough wherever the model is one to one; chosen


def distort(xy: Floats, k: Floats) -> Floats:
    """Where the lens draws the ideal point: (…, 2) → (…, 2), normalised; `k` is (5,)."""
    return np.stack(distorted_entries(xy[..., 0], xy[..., 1], k), -1)


def distorted_entries(x: Floats, y: Floats, k: Floats) -> tuple[Floats, Floats]:
    """x' and y' of `distort`, each as x and y are."""
    k1, k2, p1, p2, k3 = k
    xx, yy, xy = x * x, y * y, x * y
    r2 = xx + yy
    g = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))  # (1)
    return x * g + 2 * p1 * xy + p2 * (r2 + 2 * xx), y * g + p1 * (r2 + 2 * yy) + 2 * p2 * xy  # (2), (3)


def jacobian(xy: Floats, k: Floats) -> Floats:
    """d(x', y') / d(x, y) of `distort`: (…, 2) → (…, 2, 2)."""
    xx, cross, yy = jacobian_entries(xy[..., 0], xy[..., 1], k)
    return np.stack([np.stack([xx, cross], -1), np.stack([cross, yy], -1)], -2)


def jacobian_entries(x: Floats, y: Floats, k: Floats) -> tuple[Floats, Floats, Floats]:
    """dx'/dx, dx'/dy = dy'/dx and dy'/dy of `distort`, each as x and y are."""
    k1, k2, p1, p2, k3 = k
    r2 = x * x + y * y
    g = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    dg = 2 * (k1 + r2 * (2 * k2 + 3 * k3 * r2))  # 2 dg / d(r²)
    cross = x * y * dg + 2 * (p1 * x + p2 * y)
    xx = g + x * x * dg + 2 * p1 * y + 6 * p2 * x
    yy = g + y * y * dg + 6 * p1 * y + 2 * p2 * x
    return xx, cross, yy


def undistort(xy: Floats, k: Floats) -> Floats:
    """The ideal point that the lens draws at `xy`: (…, 2) → (…, 2); NaN where the model has no inverse there."""
    if not np.any(k):
        return xy.copy()
    x, y = xy[..., 0].copy(), xy[..., 1].copy()
    with np.errstate(all="ignore"):  # points outside the model's range run away and become NaN below
        for _ in range(NEWTON_STEPS):
            residual_x, residual_y = _residual(x, y, xy, k)
            xx, cross, yy = jacobian_entries(x, y, k)
            det = xx * yy - cross * cross
            x, y = x - (yy * residual_x - cross * residual_y) / det, y - (xx * residual_y - cross * residual_x) / det
            if not max(np.nanmax(np.abs(residual), initial=0.0) for residual in (residual_x, residual_y)) > 1e-13:
                break
        xx, cross, yy = jacobian_entries(x, y, k)
        residual_x, residual_y = _residual(x, y, xy, k)
        good = (np.abs(residual_x) < 1e-9) & (np.abs(residual_y) < 1e-9)
        good &= xx * yy > cross * cross  # not folded over
    return np.stack([np.where(good, x, np.nan), np.where(good, y, np.nan)], -1)


def _residual(x: Floats, y: Floats, xy: Floats, k: Floats) -> tuple[Floats, Floats]:
    """How far the lens draws ideal points x, y from xy (…, 2)."""
    drawn_x, drawn_y = distorted_entries(x, y, k)
    return drawn_x - xy[..., 0], drawn_y - xy[..., 1]
