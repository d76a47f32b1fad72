"""How noisy the dark pixels of a frame are.

Neighbouring pixels of the background differ by noise alone, so with short stretches of `SPAN` pixels
scattered over the frame, the mean of half the squared differences d² / 2 is the variance in each stretch,
and the median over the stretches passes over those that a marker crosses. The median of a χ² with k degrees of
freedom lies below its mean by (1 − 2 / (9 k))³ (Wilson and Hilferty 1931) (1); differences of
neighbours are correlated by −1/2, which leaves k = SPAN · 2/3 (2).

A frame whose background is clipped at black shows less noise than its bright pixels have: set
`Centroids.noise_sd` there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SPAN = 16  # pixels of a stretch; chosen: long enough for a variance, short enough to be even
LINES = 8  # of an image that are looked at, about; chosen for speed
STRETCHES = 8  # in each of them, about; chosen for speed

ROUNDING = 1 / 12
"""Variance that rounding to whole grey levels has alone; by definition."""


def background(images: NDArray[np.uint8 | np.uint16]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n) median grey level and (n) variance of the dark pixels of frames (n, H, W), in the image's own levels."""
    n, h, w = images.shape
    span = min(SPAN, max(w - 1, 0))
    width = min(w, max(span + 1, w // STRETCHES))
    step = max(1, h // LINES)
    lines = images[:, step // 2 :: step, : w // width * width]
    count = lines.shape[1] * (w // width)
    stretches = lines.reshape(n, lines.shape[1], w // width, width)[..., : span + 1].astype(np.int64)
    stretches = stretches.reshape(n, count, span + 1)
    few = stretches[:, :, ::4]
    level = row_medians(few.reshape(n, count * few.shape[2]))
    if span == 0:
        return level, np.full(n, ROUNDING)
    k = span * 2 / 3 if span > 1 else 1.0  # (2)
    d = np.diff(stretches, axis=2)
    spread = np.einsum("nsk,nsk->ns", d, d) / (2 * span)
    variance = row_medians(spread) / (1 - 2 / (9 * k)) ** 3  # (1)
    return level, np.maximum(variance, ROUNDING)


def row_medians(values: NDArray[Any]) -> NDArray[np.float64]:
    """Median (…) of each row (…, k); for few values sorting is faster than `np.median`."""
    ordered, k = np.sort(values, axis=-1), values.shape[-1]
    return ordered[..., (k - 1) // 2] / 2.0 + ordered[..., k // 2] / 2.0
