"""Which groups of white pixels may be more, or less, than one whole marker.

With the second central moments Σ of a group's white pixels (each a square, 1/12 px² to each axis), an ellipse of any
shape has the area

    A = 4π √det Σ                                                        (1)

and a disc has equal eigenvalues λ₁ = λ₂ besides. A group is suspected when

    λ₁ / λ₂ > 1 + RATIO / d    or    A / (4π √det Σ) < 1 − FILL / d² − 0.001        (2)

with d = 2 √(A/π) its diameter, or its height in lines where fields make that less. Pixels alone bring single discs of
5, 8 and 20 px to at most 1.4, 1.25 and 1.06, and down to 0.955, 0.982 and 0.9967, so these bounds pass over nearly all
of them; two discs half a diameter apart have λ₁ / λ₂ = 2.0. The sums run over whole runs: of n pixels about x̄, Σ x² is
n x̄² + n (n² − 1) / 12 (3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data import Validity
from .grouping import PixelGroups

RATIO = 2.2  # px; with it single markers of 5 to 16 px are hardly ever suspected: docs/theory/detect.md, 5100 of them
FILL = 1.75  # px²; with it single markers of 5 to 16 px are hardly ever suspected: docs/theory/detect.md, 5100 of them
LEAST = 26  # px²; of fewer pixels nothing can be said; chosen (see studies/overlapping_markers.py)


def suspicious(groups: PixelGroups, validity: NDArray[np.uint8], *, aspect: float) -> NDArray[np.int64]:
    """The groups (index) whose outline is not that of one whole disc; what is too large or too small is left out.

    `aspect` is the height of a disc's image by its width.
    """
    if not len(groups.area):
        return np.zeros(0, np.int64)
    xx, xy, yy = second_moments(groups, aspect=aspect)
    size = groups.area / aspect  # π d² / 4
    fine = min(aspect, 1.0) / np.sqrt(np.pi / 4)
    excess = RATIO / fine / np.sqrt(size)
    half, difference = xx + yy, xx - yy
    stretched = difference * difference + 4 * xy * xy > (half * excess / (2 + excess)) ** 2  # (2), first part
    least = 0.999 - FILL / fine**2 / size
    filled = size * size >= (4 * np.pi) ** 2 * (xx * yy - xy * xy) * (least * np.abs(least))  # (1), (2)
    strange = stretched | ~filled | (validity == Validity.AT_EDGE)
    return np.flatnonzero(strange & (validity != Validity.TOO_LARGE) & (groups.area >= LEAST))


def second_moments(
    groups: PixelGroups, *, aspect: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Σxx, Σxy and Σyy (G) px² of the white pixels, v divided by the aspect."""
    first, last, y = groups.runs.first, groups.runs.last, groups.runs.y
    n, x = last - first + 1, first + last  # x is doubled: all whole numbers
    columns = np.empty((5, len(n)), np.int64)
    nx, ny = np.multiply(n, x, out=columns[0]), np.multiply(n, y, out=columns[1])
    np.multiply(nx, x, out=columns[2])
    columns[2] += (n * n - 1) * n // 3  # (3), four times
    np.multiply(nx, y, out=columns[3])
    np.multiply(ny, y, out=columns[4])
    u, v, xx, xy, yy = np.add.reduceat(columns, groups.start[:-1], axis=1) / groups.area
    xx, xy, yy = (xx - u * u) / 4 + 1 / 12, (xy - u * v) / (2 * aspect), (yy - v * v + 1 / 12) / aspect**2
    return xx, xy, yy
