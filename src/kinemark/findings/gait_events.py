"""Whether the foot events of a walk are those that its file has, and what of the way it is walked they hang on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..data import Events, Finding, make_finding
from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import SIDES, Side
from ..gait.foot_events import UNLIKE_MS
from ..gait.treadmill import Floor

FAR_MS = 50.0
"""Difference of an event in the file from the one that was found, ms; chosen: five times the expected error."""
OTHER_MS = 200.0
"""Difference from which it is another event, ms; chosen: a step takes 500."""


def of_events(
    trial: str, events: Sequence[FootEvent], file_events: Events, start_s: float, bare: Side | None = None
) -> Iterator[Finding]:
    """Whence the events of a trial are, and whether its file has others.

    Args:
        trial: its name. events: that were found. file_events: that the file has; start_s: of its first frame on their
            clock. bare: the side whose leg has no marker, of which none are found.
    """
    if events and not any(event.source == "plate" for event in events):
        sd = 1000 * float(np.median([event.sd for event in events]))
        yield make_finding("events_without_plates", trial=trial, sd_ms=sd)
    off: list[float] = []
    absent = 0
    for label, side, time in zip(file_events.label, file_events.side, file_events.time, strict=True):
        strike = {"foot strike": True, "foot off": False}.get(label.lower())
        if strike is None or side.lower() == bare:
            continue
        near = [e.time for e in events if e.strike == strike and e.side == side.lower()]
        ms = 1000 * min((abs(t - (time - start_s)) for t in near), default=np.inf)
        if ms <= OTHER_MS:
            off.append(ms)
        else:
            absent += 1
    if absent:
        yield make_finding("file_events_not_found", trial=trial, events=absent)
    far = [ms for ms in off if ms > FAR_MS]
    if far:
        yield make_finding("file_events_differ", trial=trial, events=len(far), most_ms=max(far))


def of_way(trial: str, way: str, floor: Floor) -> Iterator[Finding]:
    """That a trial of this name is no level walk, and that its floor moves."""
    if way != "level":
        yield make_finding("gait_not_level", trial=trial, way=way, sd_ms=UNLIKE_MS)
    if floor.moves:
        left, right = (None if not floor.belts else _speed(floor.below(side)) for side in SIDES)
        yield make_finding(
            "gait_on_treadmill", trial=trial, speed=_speed(floor.velocity), left_speed=left, right_speed=right
        )


def _speed(velocity: Floats) -> float:
    """m/s of mm/s."""
    return float(np.linalg.norm(velocity)) / 1000
