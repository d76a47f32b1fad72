"""White pixels of groups parted into clusters by Lloyd's rule (1982).

Every centre goes to the mean of the pixels that are nearest to it, the first of equally near ones, a few turns over;
one without pixels stays. Sums run over the pixels in their order, so that compiled code and NumPy give the same.
"""

from __future__ import annotations

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from .array_checks import BOOL, FLOAT, Arrays
from .compiled_library import library

_GROUPS = Arrays(x=(FLOAT, "n", "N"), y=(FLOAT, "n", "N"), white=(BOOL, "n", "N"), centres=(FLOAT, "n", "k", 2))


def cluster_pixels(x: Floats, y: Floats, white: Bools, centres: Floats, *, turns: int) -> tuple[Floats, Floats]:
    """Where the centres of the clusters of n groups of N pixels come to lie.

    Args:
        x: (n, N) px.
        y: (n, N) px.
        white: (n, N) which pixels count.
        centres: (n, k, 2) px, where they begin.
        turns: how often they move at most.

    Returns:
        (n, k, 2) px, the centres; (n) px², the sum of squares of what their pixels were from them in the last turn.

    Raises:
        ValueError: an array has another shape or dtype, or there is no centre.
    """
    x, y, white, centres = _GROUPS(x, y, white, centres)
    (n, k, _), N = centres.shape, x.shape[1]
    if k < 1:
        raise ValueError("centres has none for each group, wanted at least one")
    if compiled := library():
        moved, spread = centres.copy(), np.empty(n)
        compiled.cluster_pixels(n, N, k, turns, x, y, white, moved, spread, np.empty(2 * N + 3 * k))
        return moved, spread
    return _numpy_clusters(x, y, white, centres, turns)


@np.errstate(all="ignore")
def _numpy_clusters(x: Floats, y: Floats, white: Bools, centres: Floats, turns: int) -> tuple[Floats, Floats]:
    n, k, _ = centres.shape
    row, column = np.nonzero(white)
    x, y, spread = x[row, column], y[row, column], np.zeros(n)
    for _ in range(turns):
        nearest, far = _nearest(x, y, centres, row)
        number, *sums = (np.bincount(row * k + nearest, weights, n * k) for weights in (None, x, y))
        spread = np.bincount(row, far, n).astype(np.float64)  # of no pixels whole numbers come
        means = np.stack(sums, -1) / np.maximum(number, 1)[:, None]
        centres = np.where((number > 0)[:, None], means, centres.reshape(-1, 2)).reshape(centres.shape)
    return centres, spread


def _nearest(x: Floats, y: Floats, centres: Floats, row: Ints) -> tuple[Ints, Floats]:
    """(M) which of the centres (n, k, 2) of its row is nearest to each pixel, and how far that is, squared, px²."""
    nearest, least = np.zeros(len(x), np.int64), np.full(len(x), np.inf)
    for i, (u, v) in enumerate(centres.transpose(1, 2, 0)):
        far = (x - u[row]) ** 2 + (y - v[row]) ** 2
        nearest[far < least] = i
        least = np.fmin(far, least)
    return nearest, least
