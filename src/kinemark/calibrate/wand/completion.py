"""All that a rig can find of a waved wand: markers that rows lacked, among strays, and the right ends.

1. Every marker is triangulated from the cameras that seem to see it and agree within `search_radius` (1).
2. The stick through the markers p_k of one frame, at s_k along it, is

       x_k = p̄ + (s_k − s̄) d,    d ~ Σ (s_k − s̄) (p_k − p̄)             (2)

   and the frame is used if no p_k lies further from x_k than `STIFF` of the wand's length (3).
3. Projected into every camera, each x_k takes the nearest detection within `search_radius`, but not where two markers
are
   so near each other that both might take one, or run together (4).
"""

from __future__ import annotations

import numpy as np
import scipy

from ...data import Detections, Rig
from ...data.array_types import Bools, Floats, Ints
from ...geometry import project
from ..bundle import sticks_through
from ..bundle.robust_points import robust_points
from .identify import at_rows

STIFF = 0.03  # of the wand's length by which a marker may be off; chosen (see benchmarks/bundle.py)
APART = 1e5
"""px between frames, where the detections of all of them are searched at once; chosen (see benchmarks/bundle.py)."""


def completed(
    rig: Rig, detections: Detections, use: Bools, rows: Ints, along: Floats, *, search_radius: float
) -> tuple[Ints, Floats]:
    """The row of each marker (C, F, K), −1 where not seen, from rows (C, F, K) of which most are right.

    Args:
        rig: that saw them.
        detections: of the rig's cameras.
        use: (D) rows that may be taken.
        rows: (C, F, K) a first reading, −1 where there is none.
        along: (K) places of the markers, mm.
        search_radius: px; the rig's own error included.

    Returns:
        The rows, and the wand's markers (F, K, 3) mm; −1 and NaN in frames that show no stick of this length.
    """
    uv, _ = at_rows(detections, rows)
    points = robust_points(rig, uv.reshape(len(rig), -1, 2), limit=search_radius)
    xyz = stiff(points.reshape(*rows.shape[1:], 3), along)
    found = [_nearest(_apart(project(camera, xyz), detections, c, search_radius), detections, use, c, search_radius)
             for c, camera in enumerate(rig)]  # fmt: skip
    return np.stack(found), xyz


def stiff(xyz: Floats, along: Floats) -> Floats:
    """The sticks (F, K, 3) through markers (F, K, 3) of which at least two are seen, by (2) and (3)."""
    stick = sticks_through(xyz, along).xyz  # (2)
    distance = np.nan_to_num(np.linalg.norm(stick - xyz, axis=-1)).max(1)
    return np.where((distance < STIFF * (along[-1] - along[0]))[:, None, None], stick, np.nan)  # (3)


def _apart(expected: Floats, detections: Detections, c: int, search_radius: float) -> Floats:
    """Markers (F, K, 2) px without those that may touch a neighbour, by (4)."""
    width = detections.width[detections.start[c, 0] : detections.start[c, -1]]
    known = np.isfinite(width)
    least = 2 * search_radius + (float(np.median(width[known])) if known.any() else 0.0)
    near = np.linalg.norm(np.diff(expected, axis=1), axis=-1) < least
    touching = np.zeros(expected.shape[:2], np.bool_)
    touching[:, 1:] |= near
    touching[:, :-1] |= near
    return np.where(touching[..., None], np.nan, expected)


def _nearest(expected: Floats, detections: Detections, use: Bools, c: int, search_radius: float) -> Ints:
    """The row (F, K) of camera c nearest to where each marker (F, K, 2) px should be, −1 where none is near."""
    first = int(detections.start[c, 0])
    mine = first + np.flatnonzero(use[first : detections.start[c, -1]])
    found = np.full(expected.shape[:2], -1, np.int64)
    if len(mine) == 0:
        return found
    frame = np.broadcast_to(np.arange(len(expected))[:, None], found.shape)
    wanted = np.isfinite(expected).all(-1)
    tree = scipy.spatial.KDTree(np.column_stack([detections.uv[mine], APART * detections.frame[mine]]))
    _, near = tree.query(np.column_stack([expected[wanted], APART * frame[wanted]]), distance_upper_bound=search_radius)
    found[wanted] = np.append(mine, -1)[near]  # the tree says its length where nothing is near
    return found
