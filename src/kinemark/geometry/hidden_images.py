"""Images that show less, or more, of a marker than they should, and how far that may move their centroids.

A marker of one size is seen by several cameras. From the area A of each image, the depth z and the focal length f,

    D = 2 √(A / π) z / f                                                 (1)

is its diameter in space. Where a limb or the edge of another marker hides a part, D is smaller than what the other
cameras say; where two markers run together, it is larger. With D₀ the upper median of a point's own images, the share
that each shows is φ = (D / D₀)², and the part that is missing or too much moves the centroid by up to

    |1 − φ| R                                                            (2)

with R the radius in px: a disc cut straight through has its centroid at 0.85 (1 − φ) R. The direction is not known, so
half of the square of (2) is added to the variance along each axis. Noise along a rim of length 2πR scatters the
area by 0.1 √(2πR), so differences within 2.5 of these standard deviations mean nothing:

    C_hidden = max(0, (1 − φ)² − ε²) R² / 2 · 1,   ε = 2.5 · 0.1 √(2πR) / (πR²)          (3)
"""

from __future__ import annotations

import numpy as np

from ..data import Rig
from ..data.array_types import Floats


def hidden_variance(rig: Rig, xyz: Floats, area: Floats) -> Floats:
    """Variance (P, C) px² along each axis by (3), for points (P, 3) mm and areas (P, C) px² of their images.

    Zero where an area is not known (NaN) or a point has a single image of known area.
    """
    scale = np.stack([np.abs(c.K[0, 0]) / np.maximum(xyz @ c.R[2] + c.t[2], 1.0) for c in rig], 1)  # px/mm
    diameter = 2 * np.sqrt(area / np.pi) / scale  # (1)
    known = np.sum(~np.isnan(diameter), axis=1)
    falling = -np.sort(-np.nan_to_num(diameter, nan=-1.0), axis=1)
    median = falling[np.arange(len(xyz)), np.maximum(known - 1, 0) // 2][:, None]
    radius = median * scale / 2
    with np.errstate(divide="ignore", invalid="ignore"):  # points without areas
        change = np.abs(1 - (diameter / median) ** 2)  # (2)
        chance = 2.5 * 0.1 * np.sqrt(2 * np.pi * radius) / (np.pi * radius**2)
        variance = np.maximum(change**2 - chance**2, 0.0) * radius**2 / 2  # (3)
    return np.where(known[:, None] >= 2, np.nan_to_num(variance, posinf=0.0), 0.0)
