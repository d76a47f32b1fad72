"""First guesses for the shapes of `native.shape_images`, from a group's white pixels alone.

One ellipse has the second moments of the white pixels: Σ = (M²)⁻¹ / 4 (1). For k discs the white pixels are parted
into k clusters by Lloyd's rule (1982), begun in a row along the longer axis and in a ring (2); k discs on each other
cover about 0.8 k π r² (3); of these starts that counts which leaves the least sum of squares. A disc is cut across the
shorter axis, on the side away from where the third moment points, as the round side is the longer tail; what is left is
nearly as long as the whole disc, so that its radius is twice the longer standard deviation (4).
"""

from __future__ import annotations

import numpy as np

from .. import native
from ..data.array_types import Floats
from .discs import DiscFit
from .patches import CutOut

LLOYD_STEPS = 6  # of grouping bright pixels round centres; chosen: few settle it (see studies/overlapping_markers.py)
ROUNDING = 1e-9
"""Of a sum of squares; of layouts that come to the same clusters, numbered otherwise, the first counts; chosen."""
BLUR = 0.65  # px, first guess of w; chosen for usual lenses (see studies/overlapping_markers.py)


def _tail(cut: CutOut) -> Floats:
    """(n, 3) w, A and b; A is larger where the sensor is saturated."""
    bright = np.where(np.isfinite(cut.patches.white), 1.15, 0.97) * (cut.peak - cut.ground)
    return np.stack([np.full(len(bright), BLUR), np.maximum(bright, 2.0), cut.ground], 1)


def second_moments(cut: CutOut) -> tuple[Floats, Floats]:
    """(n, 2) centroid and (n, 2, 2) second moments of the white pixels, px and px²."""
    w = cut.white / np.maximum(cut.white.sum(1, keepdims=True), 1)
    u, v = (w * cut.patches.x).sum(1), (w * cut.patches.y).sum(1)
    dx, dy = cut.patches.x - u[:, None], cut.patches.y - v[:, None]
    xx, xy, yy = ((w * a).sum(1) for a in (dx * dx, dx * dy, dy * dy))
    return np.stack([u, v], 1), np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2) + np.eye(2) / 12


def ellipse_start(cut: CutOut) -> Floats:
    """Parameters (n, 8) of `shape_images.ellipse` by (1)."""
    middle, spread = second_moments(cut)
    value, vector = np.linalg.eigh(spread)
    M = vector @ ((0.5 / np.sqrt(value))[:, :, None] * vector.transpose(0, 2, 1))  # (1)
    return np.column_stack([middle, M[:, 0, 0], M[:, 0, 1], M[:, 1, 1], _tail(cut)])


def motion_start(one: DiscFit) -> Floats:
    """Parameters (n, 8) of `shape_images.motion` from those of an ellipse: along its longer axis, by the excess."""
    x, y, xx, xy, yy = one.parameters[:, :5].T
    value, vector = np.linalg.eigh(np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2))
    long, short = (1 / np.maximum(np.abs(value[:, i]), 1e-3) for i in (0, 1))
    by = (2 * np.maximum(long - short, 0.1))[:, None] * vector[:, :, 0]
    return np.column_stack([x, y, short, by, one.parameters[:, 5:]])


def disc_start(cut: CutOut, k: int) -> Floats:
    """Parameters (n, 3k + 3) of `shape_images.discs` by (2)."""
    middle, spread = second_moments(cut)
    value, vector = np.linalg.eigh(spread)
    long, short = (np.sqrt(value[:, i, None]) * vector[:, :, i] for i in (1, 0))
    row = (np.arange(k) - (k - 1) / 2) * (3.0 / k)
    layouts = [middle[:, None] + row[:, None] * long[:, None]]
    if k > 2:
        for first in (0.0, np.pi / k):
            turn = first + 2 * np.pi * np.arange(k)[:, None] / k
            layouts.append(middle[:, None] + np.cos(turn) * long[:, None] + np.sin(turn) * short[:, None])
    places = cut.patches.x, cut.patches.y, cut.white
    clusters = [native.cluster_pixels(*places, c, turns=LLOYD_STEPS) for c in layouts]
    left = np.stack([spread for _, spread in clusters])
    best = (left <= (1 + ROUNDING) * left.min(0)).argmax(0)
    centres = np.stack([c for c, _ in clusters])[best, np.arange(len(best))]
    r = np.sqrt(cut.white.sum(1) * cut.pixel / ((0.8 if k > 1 else 1.0) * k * np.pi))  # (3)
    r = np.broadcast_to(r[:, None, None], (len(r), k, 1))
    return np.column_stack([np.concatenate([centres, r], 2).reshape(len(r), -1), _tail(cut)])


def cut_start(cut: CutOut) -> Floats:
    """Parameters (n, 8) of `shape_images.cut` by (4)."""
    middle, spread = second_moments(cut)
    value, vector = np.linalg.eigh(spread)
    n = vector[:, :, 0]
    along = (cut.patches.x - middle[:, :1]) * n[:, :1] + (cut.patches.y - middle[:, 1:]) * n[:, 1:]
    side = np.where((cut.white * along**3).sum(1) > 0, -1.0, 1.0)
    n, along = n * side[:, None], along * side[:, None]
    r = 2 * np.sqrt(value[:, 1])
    h = np.where(cut.white, along, -np.inf).max(1) + (middle * n).sum(1)
    back = np.where(cut.white, along, np.inf).min(1)
    centre = middle + (back + r)[:, None] * n
    return np.column_stack([centre, r, np.arctan2(n[:, 1], n[:, 0]), h, _tail(cut)])
