"""Whether a subject walks backwards: events of the feet come in the reverse order then, and the way goes behind.

Over ground, with the pelvis at p and d its own direction on the floor, the way that it goes as it faces

    w = Σ (pₖ₊₁ − pₖ) · dₖ                                                                                    (1)

is below zero. On a treadmill w tells nothing; there a foot that swings is high, and goes the way of the walk from the
pelvis, so that the correlation of its height and of this speed has the sign of the way (2).

Backward walking is forward walking with time turned, as far as the motion of legs goes (Winter et al. 1989).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import LETTER
from .lower_limb import pelvis_of
from .segments import Z_UP, Segment, unit
from .straight_passes import WALKED_MM

AGAINST = -0.2
"""Correlation (2), mean of both feet, below which the walk goes behind; chosen: in 13 public walks and turns forward it
was 0.51 and more, and in one on stairs 0.25."""


def walks_backwards(points: Mapping[str, Floats], *, up: Floats = Z_UP) -> bool:
    """By (1), or by (2) where the pelvis stays.

    Args:
        points: (F, 3) mm by the model's names; without pelvis or feet nothing is known. up: of the laboratory.
    """
    feet = [s + name for s in LETTER.values() for name in ("HEE", "TOE")]
    if not {"LASI", "RASI", *feet} <= set(points) or not ({"SACR"} <= set(points) or {"LPSI", "RPSI"} <= set(points)):
        return False
    pelvis = pelvis_of(points)[0]
    w = way_as_faced(pelvis, up)
    if abs(w) >= WALKED_MM:
        return w < 0
    each = [_correlation(points[s + "HEE"] + points[s + "TOE"], pelvis, up) for s in LETTER.values()]
    return float(np.mean(each)) < AGAINST


def way_as_faced(pelvis: Segment, up: Floats = Z_UP) -> float:
    """(1), mm, over the frames in which the pelvis (F) is known."""
    d = _faced(pelvis, up)
    steps = (np.diff(pelvis.origin, axis=0) * (d[1:] + d[:-1]) / 2).sum(-1)
    return float(np.nansum(steps))


def _faced(pelvis: Segment, up: Floats) -> Floats:
    """(F, 3) d."""
    x = pelvis.R[..., 0]
    return unit(x - (x @ up)[:, None] * up)


def _correlation(twice_middle: Floats, pelvis: Segment, up: Floats) -> float:
    """(2) of a foot, of twice its middle (F, 3); 0 where it is hardly known, or does not move."""
    ahead = ((twice_middle / 2 - pelvis.origin) * _faced(pelvis, up)).sum(-1)
    if len(ahead) < 2:
        return 0.0
    both = np.stack([twice_middle @ up, np.gradient(ahead)])
    both = both[:, np.isfinite(both).all(0)]
    if both.shape[1] < 2 or not both.std(axis=1).all():
        return 0.0
    return float(np.corrcoef(both)[0, 1])
