"""Some of the poses of a wand, spread over the images.

Thousands of poses in the middle of the volume tell no more than hundreds, and nothing about the corners of the images.
So poses are chosen one by one, each the one with the greatest

    Σ over its points of 1 / (1 + n)                                     (1)

where n counts the points of chosen poses in the same cell of the same image.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...data import Detections
from ...data.array_types import Bools, Ints
from ..bundle.initial.view_pairs import ENOUGH, weakest_link
from .identify import at_rows

FIRST_POSES = 150  # poses of the first rig, or more where cameras then share less than `ENOUGH`; chosen for speed
CELLS = 12  # across and down an image, filled evenly with poses; chosen (see benchmarks/bundle.py)


def thinned(detections: Detections, rows: Ints, sizes: ArrayLike, most: int) -> Ints:
    """The rows (C, F, K) of at most so many frames, by (1); −1 in the others, and where only one camera sees a wand."""
    frames = np.flatnonzero(shared_frames(rows))
    if len(frames) > most:
        frames = frames[_spread(detections, rows[:, frames], np.asarray(sizes, np.int64), most)]
    chosen = np.full_like(rows, -1)
    chosen[:, frames] = rows[:, frames]
    return chosen


def first_poses(detections: Detections, rows: Ints, sizes: Ints) -> Ints:
    """Rows (C, F, K) of few frames by which all cameras hang together well, or of all."""
    most = FIRST_POSES
    while True:
        chosen = thinned(detections, rows, sizes, most)
        seen = (chosen.min(2) >= 0).astype(np.int64)
        if most >= rows.shape[1] or weakest_link(seen @ seen.T).shared >= ENOUGH:
            return chosen
        most *= 2


def shared_frames(rows: Ints) -> Bools:
    """(F) whether two cameras see two markers."""
    return np.asarray(((rows >= 0).sum(2) >= 2).sum(0) >= 2)


def _spread(detections: Detections, rows: Ints, sizes: Ints, most: int) -> Ints:
    """`most` of the frames of rows (C, F, K), by (1)."""
    uv, _ = at_rows(detections, rows)
    seen = np.isfinite(uv[..., 0])
    share = np.nan_to_num(uv) / sizes[:, None, None]
    at = np.clip(share * CELLS, 0, CELLS - 1).astype(np.int64)
    camera = np.arange(len(rows))[:, None, None]
    cell = np.where(seen, (camera * CELLS + at[..., 0]) * CELLS + at[..., 1], len(rows) * CELLS**2)
    cell = cell.transpose(1, 0, 2).reshape(rows.shape[1], -1)
    weight = np.append(np.ones(len(rows) * CELLS**2), 0.0)  # 1 / (1 + n), and nothing where a marker is not seen
    left, chosen = np.ones(len(cell), np.bool_), []
    for _ in range(most):
        best = int(np.where(left, weight[cell].sum(1), -1.0).argmax())
        chosen.append(best)
        left[best] = False
        for i in cell[best]:
            weight[i] = weight[i] / (1 + weight[i])
    return np.sort(np.array(chosen))
