"""Times in a walk at which the subject stands, and the strides that are no walking for that reason.

Both feet are on the floor at the end of every step, for a tenth of the stride, and for a third of it in who hardly
gets forward. Where they both stay for longer than `LEAST_S` and than the share `SHARE` of the median stride, without
a toe that goes on, the subject stands (1). A stride in which they stand is as long as they like to, one that ends in
standing sets a foot beside the other, and one that is shorter than `SPOT_MM` is a step on the spot: none is a stride of
walking (2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.strides import FootEvent, Stride
from ..data.subject_measures import LETTER, SIDES, Side
from .treadmill import STILL, Floor

LEAST_S = 0.5
"""Of (1), s; chosen: both feet of slow walkers are on the floor for 0.3."""
SHARE = 0.45
"""Of the median stride, of (1); chosen: a swing takes a fifth at least, so that both feet have 0.3."""
SPOT_MM = 40.0
"""Length of (2), mm; chosen: who shuffles by 50 mm a step has strides of 100."""
STAYS_MM = 100.0
"""By which a toe may move, mm; chosen: a step that was not seen moves it by more."""


class Stand(NamedTuple):
    """From when to when the subject stands, s after the first frame."""

    first: float
    last: float


def stands(
    events: Sequence[FootEvent], points: Mapping[str, Floats], *, rate: float, floor: Floor = STILL
) -> tuple[Stand, ...]:
    """When the subject stands, by (1).

    Args:
        events: of both feet. points: (F, 3) mm by the model's names. rate: frames a second. floor: of a treadmill.
    """
    toes = {s: floor.still(points[LETTER[s] + "TOE"], rate, s) for s in SIDES if LETTER[s] + "TOE" in points}
    n = max(map(len, toes.values()), default=0)
    least = max(LEAST_S, SHARE * _median_stride(events))
    return tuple(one for one in _on_both(events, n / rate) if one.last - one.first > least and _stays(one, toes, rate))


def with_standing(strides: Sequence[Stride], found: Sequence[Stand]) -> tuple[Stride, ...]:
    """The strides, told by (2) in which of them the subject stands."""
    return tuple(one._replace(stands=_stood(one, found)) for one in strides)


def _stood(one: Stride, found: Sequence[Stand]) -> bool:
    """(2)."""
    return one.values["stride_length"] < SPOT_MM or any(s.first <= one.last and s.last > one.first for s in found)


def _on_both(events: Sequence[FootEvent], end: float) -> list[Stand]:
    """Times at which both feet are on the floor; before its first event a foot is where that begins."""
    in_time = sorted(events, key=lambda e: e.time)
    on = {side: next((not e.strike for e in in_time if e.side == side), False) for side in SIDES}
    found, since = [], 0.0
    for event in in_time:
        if all(on.values()):
            found.append(Stand(since, event.time))
        on[event.side], since = event.strike, event.time
    return [*found, Stand(since, end)] if all(on.values()) else found


def _median_stride(events: Sequence[FootEvent]) -> float:
    """s, of both feet; 0 where none strikes twice."""
    each = [np.diff(sorted(e.time for e in events if e.side == side and e.strike)) for side in SIDES]
    times = np.concatenate(each)
    return float(np.median(times)) if len(times) else 0.0


def _stays(one: Stand, toes: Mapping[Side, Floats], rate: float) -> bool:
    """Whether no toe (F, 3) mm goes on; what is not seen does not."""
    ends = [[xyz[min(round(t * rate), len(xyz) - 1)] for t in one] for xyz in toes.values()]
    return not any(np.linalg.norm(b - a) > STAYS_MM for a, b in ends)
