"""Foot events, and the strides between them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from .subject_measures import Side

UNITS = {
    "stride_time": "s", "stride_length": "mm", "speed": "mm/s", "cadence": "steps/min", "step_length": "mm",
    "step_width": "mm", "step_time": "s", "foot_off": "%", "opposite_foot_off": "%", "opposite_foot_strike": "%",
    "single_support": "s", "double_support": "s",
}  # fmt: skip
"""Of each parameter."""


class FootEvent(NamedTuple):
    """A foot strike or foot off.

    Attributes:
        side: of the foot. strike: whether it is a foot strike, else a foot off.
        time: s after the first frame. sd: s, its standard uncertainty.
        source: "plate", "markers", "file" or "hand".
    """

    side: Side
    strike: bool
    time: float
    sd: float
    source: str


class Stride(NamedTuple):
    """One stride.

    Attributes:
        side: whose. first, last: s of its foot strikes.
        values, sd: by the names of `UNITS`; NaN where an event or a heel is missing.
        systematic: what of sd is the same in all strides of a session, by the names of `UNITS`; 0 where none is given.
        turned_deg: by which the pelvis turns to the left in it, or the way does. facing_deg: where it faces in the
            mean, from the x of the laboratory to the left, within half a turn; NaN where this is not known.
        stands: whether the subject stands in it or at its end, or steps on the spot. counts: in means and curves.
    """

    side: Side
    first: float
    last: float
    values: Mapping[str, float]
    sd: Mapping[str, float]
    systematic: Mapping[str, float] = {}
    turned_deg: float = 0.0
    facing_deg: float = math.nan
    stands: bool = False
    counts: bool = True
