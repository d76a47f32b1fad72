"""Markers followed in the image of one camera (KISS section 4, "2D temporal matching").

The two successive fields f, f + 1 that show all markers and have the least average movement are the start: the nearest
neighbours of their overlaid images belong together (1). From there the paths go forward, and then backward. With two
points known the next is expected on their line,

    û = 2 u(0) − u(−1)                                                   (2)

and with three on the line that fits them best, û = (4 u(0) + u(−1) − 2 u(−2)) / 3 (3), both by `signal.weights`. The
image nearest to the prediction is taken if it lies within the association window (4). Where none does, the marker is
taken to be hidden, and the prediction stands for it (5), for as long as it stays within the image. Where two paths want
one image, the nearer has it.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Floats, Ints
from ...signal import assign_nearest, weights

FAR = 1e9
"""px: no limit; by definition."""


class Paths(NamedTuple):
    """T paths over F fields: uv (T, F, 2) ideal px, NaN where a path is not; detection (T, F) index, −1: predicted."""

    uv: Floats
    detection: Ints


def paths_of(uv: Floats, fields: list[Ints], *, size: NDArray[np.int64], window: float, markers: int | None) -> Paths:
    """The paths of the markers that are seen in the two fields of least movement.

    Args:
        uv: (D, 2) images, px.
        fields: (F) the rows of each field.
        size: (2) of the image, px; zero where it is not known.
        window: half width of the association window, px.
        markers: how many there are; None: as many as two successive fields show at most.

    Raises:
        ValueError: no two successive fields show so many.
    """
    first, before, after = start_of(uv, fields, markers)
    shape = (len(before), len(fields))
    paths = Paths(np.full((*shape, 2), np.nan), np.full(shape, -1))
    for f, rows in ((first, before), (first + 1, after)):
        if len(rows):
            paths.uv[:, f], paths.detection[:, f] = uv[rows], rows
    low, high = np.minimum(uv.min(0, initial=0.0), -0.5), np.maximum(uv.max(0, initial=0.0), size - 0.5)
    for step, order in ((1, range(first + 2, len(fields))), (-1, range(first - 1, -1, -1))):
        for f in order if len(before) else ():
            done = range(first, f) if step > 0 else range(f + 1, len(fields))
            past = [p for p in (f - 3 * step, f - 2 * step, f - step) if p in done]
            _extend(paths, f, past, uv, fields[f], window)
            gone = (paths.detection[:, f] < 0) & ((paths.uv[:, f] < low) | (paths.uv[:, f] > high)).any(1)
            paths.uv[gone, f] = np.nan
    return paths


def start_of(uv: Floats, fields: list[Ints], markers: int | None) -> tuple[int, Ints, Ints]:
    """The first of the two fields of (1), and the rows (T) of the images in both that belong together."""
    both = np.array([min(len(a), len(b)) for a, b in pairwise(fields)], np.int64)
    most = int(both.max(initial=0))
    wanted = most if markers is None else markers
    if most < wanted:
        raise ValueError(
            f"at most {most} of {wanted} markers in two successive fields, and the former method starts where it sees "
            "all. Choose another camera, give fewer markers (those not seen are then not followed), or use another "
            "method, which lets markers come and go."
        )
    best = (np.inf, 0, np.zeros(0, np.int64), np.zeros(0, np.int64))
    for f in np.flatnonzero(both >= max(wanted, 1)).tolist():
        apart = np.linalg.norm(uv[fields[f]][:, None] - uv[fields[f + 1]], axis=-1)
        i, j = assign_nearest(apart, np.full(len(apart), FAR))
        i, j = i[:wanted], j[:wanted]
        moved = float(apart[i, j].mean())
        if moved < best[0]:
            best = (moved, f, fields[f][i], fields[f + 1][j])
    return best[1:]


def _extend(paths: Paths, f: int, past: list[int], uv: Floats, rows: Ints, window: float) -> None:
    """Fill field f of all paths from up to three fields before (or, going backward, after) it."""
    predicted = np.einsum("n,tnk->tk", weights(len(past), 1), paths.uv[:, past])  # (2) (3)
    off = np.abs(uv[rows] - predicted[:, None])
    cost = np.where((off <= window).all(-1), np.hypot(off[..., 0], off[..., 1]), np.inf)
    which, taken = assign_nearest(cost, np.full(len(cost), FAR))  # (4)
    paths.uv[:, f] = predicted  # (5)
    paths.uv[which, f], paths.detection[which, f] = uv[rows[taken]], rows[taken]
