"""Which of the points in an image are the markers of a wand, and from which end: by its gaps.

K ≥ 3 markers at s mm along the wand are seen along its image at

    q = (a s + b) / (c s + 1)                                            (1)  as in `spacing`

where c s + 1 is the depth of the marker in units of that of s = 0. Every choice of K points of an image is tried in
both directions. A lens bends the row and noise moves its points, so the row may be off a straight line, and off
(1), by

    tolerance = NOISE + BEND · length of the row                         (2)

Three markers fit (1) in both directions, but in the wrong one only with a wand that points at the camera: with
δ = ln (depth of the last marker / depth of the first),

    e² = (off line / tolerance)² + (off (1) / tolerance)² + δ² / (TILT² + σδ²)      (3)

with σδ from the noise of the gaps in the image. A row is read if the best choice of points is the only good one, and
the lead of its direction, e²(other direction) − e²(this one), tells how sure that is: 0 for a wand with equal gaps.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints

NOISE = 1.5
"""px by which a short row may be bent, of (2); chosen (see benchmarks/bundle.py)."""
BEND = 0.01  # of a row's length by which a lens may bend it; chosen for usual lenses (see benchmarks/bundle.py)
TILT = 0.1
"""Standard deviation of δ for a wand waved in all directions some metres away; chosen (see benchmarks/bundle.py)."""
DEEPEST = 0.6
"""Greatest δ: the far end at most 1.8 times as far as the near one; chosen."""
CENTROID = 0.3
"""px; noise of centroids that σδ reckons with; chosen (see benchmarks/bundle.py)."""
SHORTEST = 6.0
"""px; in shorter rows the markers run together; chosen (see benchmarks/bundle.py)."""
CLEAR = 4.0
"""By how much the second best choice of points must be worse, in (3); chosen (see benchmarks/bundle.py)."""
AT_ONCE = 100_000  # rows that are worked out in one go; chosen for memory


class Readings(NamedTuple):
    """Rows of one marker count. points (g, K) are indices into each image's points, −1 where no row was read.

    lead (g) is how much better this direction is than the other; ratio (g) is ln (first gap / last gap) of the
    straightest row of the image as it was seen, whether it fits the wand or not, NaN without a straight row.
    """

    points: Ints
    lead: Floats
    ratio: Floats


def read_rows(uv: Floats, along: Floats) -> Readings:
    """Which of the points (g, n, 2) px of g images are the markers at `along` (K), mm, n ≥ K ≥ 2.

    Two markers cannot be told from others: they are read where an image has just two points.
    """
    g, n = uv.shape[:2]
    K = len(along)
    if K == 2:
        points = np.tile(np.arange(2) if n == 2 else np.full(2, -1), (g, 1))
        return Readings(points, np.zeros(g), np.full(g, np.nan))
    chosen = np.array(list(combinations(range(n), K)), np.int64)
    step = max(AT_ONCE // len(chosen), 1)
    parts = [_read(uv[i : i + step], chosen, along) for i in range(0, g, step)]
    return Readings(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def _read(uv: Floats, chosen: Ints, along: Floats) -> Readings:
    order, q, line_distance = _in_order(uv[:, chosen])  # (g, m, K)
    forward, backward = (_misfit(s, q, line_distance) for s in (along, along[-1] - along[::-1]))
    cost = np.minimum(forward, backward)  # (g, m)
    best = cost.argmin(1)
    rows = np.arange(len(uv))
    least = cost[rows, best]
    cost[rows, best] = np.inf
    read = np.isfinite(least) & (cost.min(1, initial=np.inf) > least + CLEAR)
    points = np.take_along_axis(chosen[best], order[rows, best], 1)
    turned = backward[rows, best] < forward[rows, best]
    points = np.where(turned[:, None], points[:, ::-1], points)
    with np.errstate(invalid="ignore"):
        lead = np.abs(forward[rows, best] - backward[rows, best])
    lead = np.where(np.isfinite(lead), lead, 1e3)  # the other direction is out of the question
    return Readings(np.where(read[:, None], points, -1), np.where(read, lead, 0.0), _seen_ratio(q, line_distance))


def _in_order(points: Floats) -> tuple[Ints, Floats, Floats]:
    """For rows (…, K, 2): order along the row (…, K), places along it in that order, px, and off its line (…), px."""
    centred = points - points.mean(-2, keepdims=True)
    farthest = (centred**2).sum(-1).argmax(-1)[..., None, None]
    direction = np.take_along_axis(centred, np.broadcast_to(farthest, (*centred.shape[:-2], 1, 2)), -2)
    order = (centred * direction).sum(-1).argsort(-1)
    centred = np.take_along_axis(centred, order[..., None], -2)
    line = centred[..., -1, :] - centred[..., 0, :]
    length = np.linalg.norm(line, axis=-1, keepdims=True) + 1e-9
    line, at = line / length[..., None, 0], centred - centred[..., :1, :]
    line_distance = np.abs(at[..., 0] * line[..., None, 1] - at[..., 1] * line[..., None, 0]).max(-1)
    return order, (at * line[..., None, :]).sum(-1), line_distance


def _misfit(s: Floats, q: Floats, line_distance: Floats) -> Floats:
    """(3) of rows at q (…, K) px read as markers at s (K) mm; infinite where a limit is exceeded."""
    length = q[..., -1]
    s = s / s[-1]
    z = q / (length[..., None] + 1e-9)
    M = np.stack([np.broadcast_to(s, z.shape), np.ones_like(z), -z * s], -1)
    normal = np.swapaxes(M, -1, -2) @ M + 1e-10 * np.eye(3)
    abc = np.linalg.solve(normal, np.swapaxes(M, -1, -2) @ z[..., None])[..., 0]  # (1), multiplied out
    depth = np.maximum(abc[..., 2:] * s + 1, 1e-6)
    misfit = length * np.abs((abc[..., :1] * s + abc[..., 1:2]) / depth - z).max(-1)
    delta = np.log(depth[..., -1])
    gaps = np.maximum(np.diff(q, axis=-1), 1e-3)
    noise = CENTROID**2 * 2 * (1 / gaps**2).sum(-1)
    tolerance = NOISE + BEND * length  # (2)
    good = (line_distance < tolerance) & (misfit < tolerance) & (np.abs(delta) < DEEPEST) & (length > SHORTEST)
    cost = (line_distance / tolerance) ** 2 + (misfit / tolerance) ** 2 + delta**2 / (TILT**2 + noise)  # (3)
    return np.where(good, cost, np.inf)


def _seen_ratio(q: Floats, line_distance: Floats) -> Floats:
    """ln (first gap / last gap) of each image's straightest long row (g, m, K), NaN where none is straight."""
    length = q[..., -1]
    straight = np.where(length > 5 * SHORTEST, line_distance / (NOISE + BEND * length), np.inf)
    best = straight.argmin(1)
    rows = np.arange(len(q))
    gaps = np.maximum(np.diff(q[rows, best], axis=-1), 1e-3)
    return np.where(straight[rows, best] < 1, np.log(gaps[:, 0] / gaps[:, -1]), np.nan)
