"""Which of the found foot events are possible: strikes and offs of a foot alternate, some time apart.

With T the median stride, of one foot two events of a kind are at least `SAME` T apart, and an off and a strike at least
`OTHER` T. Of events that contradict each other those are kept that leave the most, and, where that is equal, the most
usual stances and swings of this foot (1). An event from a plate counts for many.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..data.strides import FootEvent
from ..data.subject_measures import SIDES

SAME = 0.6
"""Of a stride; chosen: strides of a limping child differed by less than a quarter."""
OTHER = 0.12
"""Of a stride; chosen: of sprinters the stance takes 0.2, of slow walkers with aids the swing 0.2."""
FROM_PLATE = 10.0
"""What an event from a plate counts, against 1 of one from markers; chosen."""
UNUSUAL = 0.5
"""What an unusual stance or swing takes off at most; chosen below 1, so that it never drops an event alone."""
FAR = 0.25
"""Of a stride, by which a stance or swing is wholly unusual; chosen."""


def ordered(events: Sequence[FootEvent]) -> tuple[FootEvent, ...]:
    """The events that can have been, in the order of time."""
    kept = [event for side in SIDES for event in _of_side([e for e in events if e.side == side])]
    return tuple(sorted(kept, key=lambda event: event.time))


def _of_side(events: Sequence[FootEvent]) -> list[FootEvent]:
    """(1) for one foot, from the left: the best way to each event."""
    events = sorted(events, key=lambda event: event.time)
    stride = _stride(events)
    if not np.isfinite(stride):
        return events
    usual = {strike: _usual(events, strike, stride) for strike in (True, False)}
    score: list[float] = []
    before: list[int | None] = []
    for k, event in enumerate(events):
        best, came = 0.0, None
        for j in range(k):
            if _possible(events[j], event, stride):
                value = score[j] - _unusual(events[j], event, stride, usual[events[j].strike])
                if value > best:
                    best, came = value, j
        score.append(best + (FROM_PLATE if event.source == "plate" else 1.0))
        before.append(came)
    k = int(np.argmax(score))
    kept = [events[k]]
    while (came := before[k]) is not None:
        kept.append(events[came])
        k = came
    return kept[::-1]


def _stride(events: Sequence[FootEvent]) -> float:
    """s, the median over both kinds; NaN where no kind comes twice."""
    each = [b.time - a.time for strike in (True, False) for a, b in pairwise(e for e in events if e.strike == strike)]
    return float(np.median(each)) if each else np.nan


def _usual(events: Sequence[FootEvent], strike: bool, stride: float) -> float:
    """s from an event of a kind to the next of the other kind, the median of those that can be; NaN where none is."""
    each = [b.time - a.time for a, b in pairwise(events) if a.strike == strike and b.strike != strike]
    each = [t for t in each if OTHER * stride <= t <= stride]
    return float(np.median(each)) if each else np.nan


def _possible(a: FootEvent, b: FootEvent, stride: float) -> bool:
    return b.time - a.time >= (SAME if a.strike == b.strike else OTHER) * stride


def _unusual(a: FootEvent, b: FootEvent, stride: float, usual: float) -> float:
    """What the time between two events takes off."""
    if a.strike == b.strike or not np.isfinite(usual):
        return UNUSUAL
    return UNUSUAL * min(1.0, abs(b.time - a.time - usual) / (FAR * stride))
