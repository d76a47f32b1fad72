"""A camera whose images lie beside where the others see the same from some moment on, or up to it.

A calibration leaves such images out as wrong, and is right for the other side of the moment. In blocks b of time, m_b
is the least of the median epipolar distances of camera c and each of the others. The moment t is where

    Σ_b<t (ln m_b − mean)² + Σ_b≥t (ln m_b − mean)²                      (1)

is least. One side is beside if most of its blocks have `BESIDE` times the greatest m_b of the other side (2); the block
at t may be of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats

BESIDE = 4.0
"""Of (2); chosen: where the wand crosses another part of a lens that lacks terms, m_b is up to twice as large."""
MOST = 0.25
"""Quantile of the blocks in (2); chosen: a move may be along the epipolar lines of some blocks."""
LEAST = 0.05
"""px; medians below are taken as this, no camera model being truer; chosen."""
OF_OFFSET = 0.5
"""Median epipolar distance of two images, one of which lies beside in any direction, by how far; by definition: a half
for both images, and by the angle."""


class ImagesBeside(NamedTuple):
    """From block t on images of camera c are `px` beside; whether no other camera explains it."""

    c: int
    t: int
    px: float
    alone: bool


def images_beside(medians: Floats, *, side: int) -> ImagesBeside | None:
    """The camera whose images lie beside on one side of a moment, or None.

    Args:
        medians: (C, C, B) px of epipolar distances of two cameras in B blocks of time; NaN where they share too little.
        side: blocks on each side at least, beside the one at t.
    """
    splits = [_split(_least(own), side) for own in medians]
    ratio, t, high = max(splits)
    if ratio < BESIDE:
        return None
    c = [split[0] for split in splits].index(ratio)
    rest = np.delete(np.delete(medians, c, 0), c, 1).reshape(-1, medians.shape[2])
    alone = bool(np.isfinite(rest).any()) and _split_at(np.fmax.reduce(rest, axis=0), t)[0] < BESIDE / 2
    return ImagesBeside(c, t, high / OF_OFFSET, alone)


def _least(rows: Floats) -> Floats:
    """(B) of rows (n, B), NaN where all are."""
    return np.asarray(np.fmin.reduce(rows, axis=0))


def _split(m: Floats, side: int) -> tuple[float, int, float]:
    """(1): the ratio of (2), the block t, and the median (px) of the side that is beside; of medians m (B)."""
    log = np.log(np.maximum(m, LEAST))
    scatter = [
        sum(np.nan_to_num(np.nanvar(part) * np.isfinite(part).sum(), nan=0.0) for part in (log[:t], log[t:]))
        if all(np.isfinite(part).sum() >= side for part in (log[:t], log[t:]))
        else np.inf
        for t in range(side + 1, len(m) - side)
    ]
    t = side + 1 + int(np.argmin(scatter))
    ratio, high = _split_at(m, t) if np.isfinite(min(scatter)) else (0.0, 0.0)
    return ratio, t, high


def _split_at(m: Floats, t: int) -> tuple[float, float]:
    """The greater ratio of (2) of both sides of block t, and the median (px) of the side beside."""
    sides = [part[np.isfinite(part)] for part in (np.maximum(m[: t - 1], LEAST), np.maximum(m[t + 1 :], LEAST))]
    if not all(len(part) for part in sides):
        return 0.0, 0.0
    ratios = [
        (np.quantile(high, MOST, method="lower") / low.max(), np.median(high)) for low, high in (sides, sides[::-1])
    ]
    ratio, high = max(ratios)
    return float(ratio), float(high)
