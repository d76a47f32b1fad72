"""Whether a trial is level walking, on which the errors of foot events from markers were measured.

In walking a foot leaves the floor while the other stands. Where it mostly leaves while the other one is in the air, the
subject runs (1). Where heels stand at other heights from one strike to the next, it is on stairs or a ramp (2). Who
faces against the way walks backwards (`backwards`), in some parts alone to and fro.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES, Side
from .backwards import walked_parts
from .segments import Z_UP

Way = Literal["level", "running", "stairs", "backward", "to and fro"]
RISE_MM = 40.0
"""From one strike to the next in the median, beyond which the floor is not level, mm; chosen: level walks had up to 23,
a stair has 150."""


def way_of_walking(events: Sequence[FootEvent], points: Mapping[str, Floats], *, rate: float, up: Floats = Z_UP) -> Way:
    """How the subject walks; "level" where too few events tell.

    Args:
        events: of both feet. points: (F, 3) mm by the model's names. rate: frames a second. up: of the laboratory.
    """
    flights = [_flies(events, event) for event in events if not event.strike]
    known = [each for each in flights if each is not None]
    if known and 2 * sum(known) >= len(known):  # (1)
        return "running"
    heights = [_height(points[LETTER[e.side] + "HEE"] @ up, e.time * rate) for e in events if e.strike]
    rises = [abs(b - a) for a, b in pairwise(h for h in heights if np.isfinite(h))]
    if rises and float(np.median(rises)) > RISE_MM:  # (2)
        return "stairs"
    behind = {part.backwards for part in walked_parts(points, up=up)} if known else {False}
    return "to and fro" if len(behind) > 1 else "backward" if True in behind else "level"


def faced_aside(x: Floats) -> Floats:
    """(F) deg between directions x (F, 3), z up, along the floor and their mean; NaN where they are unknown."""
    flat = x[:, :2] / np.linalg.norm(x[:, :2], axis=1, keepdims=True)
    mean = np.nanmean(flat, axis=0) if np.isfinite(flat).any() else np.full(2, np.nan)
    return np.asarray(np.degrees(np.abs(np.arctan2(flat[:, 0] * mean[1] - flat[:, 1] * mean[0], flat @ mean))))


def _flies(events: Sequence[FootEvent], off: FootEvent) -> bool | None:
    """Whether the other foot is in the air when this one leaves; None where its last event is not known."""
    other: Side = SIDES[1 - SIDES.index(off.side)]
    before = [e for e in events if e.side == other and e.time < off.time]
    return not before[-1].strike if before else None


def _height(z: Floats, frame: float) -> float:
    k = round(frame)
    return float(z[k]) if 0 <= k < len(z) else np.nan
