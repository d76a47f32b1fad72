"""The rigid motion that best lays one set of points on another (Kabsch 1976; Söderkvist & Wedin 1993)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def rigid_align(
    source: NDArray[np.float64], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """R (3, 3), t (3,) that minimise Σ |R source + t − target|² over pairs (N, 3) without NaN.

    Raises:
        ValueError: fewer than three pairs are complete.
    """
    both = np.isfinite(source).all(1) & np.isfinite(target).all(1)
    if both.sum() < 3:
        raise ValueError(f"{both.sum()} complete pairs, wanted at least 3")
    a, b = source[both], target[both]
    ca, cb = a.mean(0), b.mean(0)
    U, _, Vt = np.linalg.svd((b - cb).T @ (a - ca))
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return R, cb - R @ ca
