"""Which rod a row of points in an image is, and from which end: by its spacings.

A point of a rod at s mm along it is seen along the image of the rod at

    q = (a s + b) / (c s + 1)                                            (1)

a projective map of the line with three parameters, linear in them once multiplied out:

    s a + b − q s c = q                                                  (2)

So k markers leave k − 3 residuals, which vanish for the right rod taken in the right direction and for no
other with different spacings (four points have one cross-ratio each way). The residual of (1) in pixels,

    e² = Σ (q − (a s + b) / (c s + 1))² / (k − 3)                        (3)

is judged for every choice of k points of the row, k markers of every rod, and direction; the rod must lie
before the camera, c s + 1 > 0, and its far end at most `DEPTH` times as far as its near one (4).
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

DEPTH = 4.0
WORST = 1e9


class Reading(NamedTuple):
    """A row read as a rod: index of the point for each marker of the rod, −1 where missing (K), and (3), px."""

    rod: int
    points: tuple[int, ...]
    error: float

    @property
    def seen(self) -> int:
        """How many markers have a point."""
        return sum(p >= 0 for p in self.points)


def readings(
    row: NDArray[np.int64], q: NDArray[np.float64], along: NDArray[np.float64], *, tolerance: float, fewest: int
) -> list[Reading]:
    """Readings of a row of points (m), at q (m) px along it and in that order, as rods (R, K) mm.

    Those whose error is at most `tolerance` px, with K markers down to `fewest`; the best of each rod and
    number of markers.
    """
    R, K = along.shape
    found = []
    for k in range(K, fewest - 1, -1):
        chosen = np.array(list(combinations(range(len(row)), k)), np.int64).reshape(-1, k)
        if len(chosen) == 0:
            continue
        marks = np.array(list(combinations(range(K), k)), np.int64)
        for rod in range(R):
            options = [(marks, chosen), (marks, chosen[:, ::-1])]
            best = min((_best(along[rod], q, m, c) for m, c in options), key=lambda option: option[2])
            if best[2] <= tolerance:
                points = np.full(K, -1)
                points[best[0]] = row[best[1]]
                found.append(Reading(rod, tuple(int(p) for p in points), best[2]))
    return found


def _best(
    s: NDArray[np.float64], q: NDArray[np.float64], marks: NDArray[np.int64], chosen: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], float]:
    """The markers (k) and places in the row (k) that fit best, and their error."""
    error = spacing_errors(s[marks][:, None], q[chosen][None])
    i, j = np.unravel_index(error.argmin(), error.shape)
    return marks[i], chosen[j], float(error[i, j])


def spacing_errors(s: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """(3) of points at q (…, k) px and markers at s (…, k) mm, or `WORST` where (4) is violated."""
    s, q = np.broadcast_arrays(s, q)
    k = s.shape[-1]
    s = (s - s.mean(-1, keepdims=True)) / s.std(-1, keepdims=True)
    middle, scale = q.mean(-1, keepdims=True), q.std(-1, keepdims=True) + 1e-12
    z = (q - middle) / scale
    M = np.stack([s, np.ones_like(s), -z * s], -1)
    normal = np.swapaxes(M, -1, -2) @ M + 1e-12 * np.eye(3)
    abc = np.linalg.solve(normal, np.swapaxes(M, -1, -2) @ z[..., None])[..., 0]  # (2)
    depth = abc[..., 2:] * s + 1
    ahead = (depth.min(-1) > 0) & (depth.max(-1) < DEPTH * depth.min(-1))  # (4)
    fitted = (abc[..., :1] * s + abc[..., 1:2]) / np.where(ahead[..., None], depth, 1.0)
    error = scale[..., 0] * np.sqrt(((z - fitted) ** 2).sum(-1) / max(k - 3, 1))
    return np.where(ahead, error, WORST)
