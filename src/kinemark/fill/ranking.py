"""Donors in order: those that keep their distance from a marker move with it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .motion import Motion

FEWEST = 12
"""Frames to learn from, at least."""


def ranked(motion: Motion, marker: int) -> NDArray[np.int64]:
    """The other markers, that whose distance from this one varies least first; only those seen with it often enough."""
    thin = motion.xyz[:, :: max(1, motion.xyz.shape[1] // 400)]
    way = thin - thin[marker]
    square = np.einsum("mfi,mfi->mf", way, way)
    n = np.isfinite(square).sum(1)
    square = np.where(np.isfinite(square), square, 0.0)
    sum_, square = np.sqrt(square).sum(1), square.sum(1)
    vary = np.sqrt(np.maximum(square / np.maximum(n, 1) - (sum_ / np.maximum(n, 1)) ** 2, 0.0))
    vary[(n < FEWEST) | (n < 0.5 * n[marker])] = np.inf
    vary[marker] = np.inf
    order = np.argsort(vary, kind="stable")
    return order[np.isfinite(vary[order])]
