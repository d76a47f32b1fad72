"""Whether two trials are of one body that wears the same markers, and whether a standing trial stands.

Two markers of one segment keep their distance but for skin, in every trial in which they were not put on anew. Skin
moves as the joint beside it bends: a leg that climbs has other distances than one that stands, by more than 10 mm, and
in its own steps has both. With a to b the middle 95 % of such a distance over the frames of a trial, that of another
trial lies beyond it by

    δ = max(a₂ − b₁, 0) − max(a₁ − b₂, 0)                                                                     (1)

Of one body the RMS of δ over the pairs of stiff segments and the greatest |δ| of all pairs are small. The foot bends
between heel and toe, so its toes count in the second alone. A leg that stands keeps the distance from the front of its
pelvis to its ankle; one that steps bends it (2).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.subject_measures import LETTER
from .marker_doubts import MIDDLE, SEGMENTS

OF_THE_PELVIS = (("LASI", "RASI"), ("LASI", "SACR"), ("RASI", "SACR"), ("LASI", "LPSI"), ("RASI", "RPSI"))
"""Pairs of (1) beside those of the legs; conventional."""
UNLIKE_MM = 3.0
"""RMS of (1), mm; chosen: of 15 public walks, turns and stairs against their own standing trials it was up to 0.9,
against those of others of like size from 4.9 where all pairs were worn."""
APART_MM = 10.0
"""Greatest of (1), mm; chosen: of the same it was up to 4.4, from ankle to toe, against those of others from 10.2."""
STEPS_MM = 30.0
"""Width of the middle 95 % of (2), mm; chosen: in 10 standing trials it was up to 2, in walks from 56."""


class BodyChange(NamedTuple):
    """How much bodies differ.

    Attributes:
        rms_mm: of (1); NaN where no pair tells. pairs: the markers of the greatest |δ|, first the worst.
        most_mm: δ of the first, mm; greater than 0 where the second body is larger.
    """

    rms_mm: float
    pairs: tuple[tuple[str, str], ...]
    most_mm: float


def body_change(first: Mapping[str, Floats], second: Mapping[str, Floats]) -> BodyChange | None:
    """How the body in one trial differs from that in another; None where it does not.

    Args:
        first, second: (F, 3) mm of the markers that each wears, by the model's names.
    """
    one, other = _lengths(first), _lengths(second)
    by = {pair: _beyond(one[pair], other[pair]) for pair in one if pair in other}
    stiff = [mm for (_, b), mm in by.items() if not b.endswith("TOE")]
    rms = float(np.sqrt(np.mean(np.square(stiff)))) if stiff else float("nan")
    pairs = sorted(by, key=lambda pair: -abs(by[pair]))
    if not pairs or not (rms > UNLIKE_MM or abs(by[pairs[0]]) > APART_MM):
        return None
    return BodyChange(rms, tuple(pairs[:3]), by[pairs[0]])


def steps_mm(standing: Mapping[str, Floats]) -> float:
    """Width of (2) of the leg that bends more, mm; 0 where it stands, or nothing is known.

    Args:
        standing: (F, 3) mm by the model's names.
    """
    widths = [0.0]
    for side in LETTER.values():
        if {side + "ASI", side + "ANK"} <= set(standing):
            apart = np.linalg.norm(standing[side + "ASI"] - standing[side + "ANK"], axis=-1)
            apart = apart[np.isfinite(apart)]
            widths.append(float(np.ptp(np.percentile(apart, MIDDLE))) if len(apart) else 0.0)
    return max(widths) if max(widths) > STEPS_MM else 0.0


def _beyond(one: Floats, other: Floats) -> float:
    """mm δ (1)."""
    return float(max(other[0] - one[1], 0.0) - max(one[0] - other[1], 0.0))


def _lengths(points: Mapping[str, Floats]) -> dict[tuple[str, str], Floats]:
    """(2) mm, from a to b (1), of each pair that is worn and seen together."""
    legs = [(side + a, side + b) for side in LETTER.values() for a, b in SEGMENTS]
    found = {}
    for a, b in (*OF_THE_PELVIS, *legs):
        apart = np.linalg.norm(points[a] - points[b], axis=-1) if {a, b} <= set(points) else np.zeros(0)
        if len(apart := apart[np.isfinite(apart)]):
            found[a, b] = np.percentile(apart, MIDDLE)
    return found
