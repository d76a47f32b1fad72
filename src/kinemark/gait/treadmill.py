"""The velocity of the floor below the feet: the belt of a treadmill.

While a foot stands flat, between `FLAT` of its stance, its heel goes with the floor: the slope of its place over time
is the floor's velocity v (1). The median over a foot's stances, and the mean of both feet, which roll outwards to
either side, is that of the trial; the deviation of a stance from it is what is not known of v in a stride: how steadily
the belt runs, and how flat the foot stood (2). In the frame of the belt, h − v t, a walk on a treadmill is one over
ground. Where the medians of both feet are apart by more than `APART` of v, and by more than the stances of a foot are,
each foot has a belt of its own, and its own median (4), if toes say so too, where they are seen: a heel that rises
early on one side goes forwards, and its toe stands.

Heels of runners, and of those who walk on their toes, go forwards while they stand, the way that they swing. A belt
carries heel and toe against that way, wherever its owner goes meanwhile: v counts where both go against their next
swing by CARRIED in the median of the stances (3); without toes only if v is STAYS times as fast as heels go from strike
to strike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES, Side
from .backwards import walks_backwards
from .foot_motion import BELT_MM_S
from .segments import along_floor, unit

FLAT = (0.25, 0.5)
"""Of a stance, counted from its end where the subject walks backwards, within which the heel stands; chosen: walkers'
heels come down until 0.15, and begin to rise between 0.5 and 0.7."""
CARRIED = 75.0
"""Of (3), mm/s; chosen: over ground heels and toes of 22 public files went against their swing by up to 13."""
STAYS = 2.0
"""Of (3); chosen: over ground no heel that stands goes faster than its owner, and on a belt owners hardly go at all."""
APART = 0.08
"""Of (4); chosen: on one belt feet were up to 0.04 apart, and who splits belts has one at 1.2 to 3 times the other."""
STEADY = 0.02
"""Of a belt's speed, to which its foot's stances tell it at best, where two belts leave nothing to compare them with;
chosen: half of what feet on one belt were apart."""
FEWEST = 3
"""Frames of a slope; chosen."""


class Floor(NamedTuple):
    """Velocity of the floor.

    Attributes:
        velocity: (3) mm/s; 0 where it stands still. sd: mm/s, its standard uncertainty in one stride.
        belts: (3) mm/s of the belt below each foot, where there are two.
    """

    velocity: Floats
    sd: float
    belts: Mapping[Side, Floats] = {}

    @property
    def moves(self) -> bool:
        """Whether it is a treadmill's."""
        return bool(np.any(self.velocity))

    def still(self, xyz: Floats, rate: float, side: Side) -> Floats:
        """(F, 3) mm of a marker as the belt below the foot of this side sees it."""
        return np.asarray(xyz - self.below(side) * (np.arange(len(xyz)) / rate)[:, None])

    def below(self, side: Side) -> Floats:
        """(3) mm/s of the belt below a foot."""
        return self.belts.get(side, self.velocity)


STILL = Floor(np.zeros(3), 0.0)
"""A floor that does not move; by definition."""


def floor_velocity(events: Sequence[FootEvent], points: Mapping[str, Floats], *, rate: float) -> Floor:
    """Velocity of the floor by (1) to (4); `STILL` where it is below `CARRIED`, or no stance is seen.

    Args:
        events: of both feet. points: (F, 3) mm, with LHEE and RHEE. rate: frames a second.
    """
    flat = (1 - FLAT[1], 1 - FLAT[0]) if walks_backwards(points) else FLAT

    def stood(marker: str) -> dict[Side, Floats]:
        seen = [side for side in SIDES if LETTER[side] + marker in points]
        each = {side: [e for e in events if e.side == side] for side in seen}
        found = {side: _stood(points[LETTER[side] + marker], own, flat, rate) for side, own in each.items()}
        return {side: slopes for side, slopes in found.items() if len(slopes)}

    heels = stood("HEE")
    if not heels:
        return STILL
    v = np.mean([np.median(slopes, axis=0) for slopes in heels.values()], axis=0)
    speed = float(np.linalg.norm(v))
    if not _carried(events, points, flat, rate) and speed < max(BELT_MM_S, STAYS * _gone(events, points, rate)):
        return STILL
    along, toes = ({side: slopes @ v / speed for side, slopes in one.items()} for one in (heels, stood("TOE")))
    if _two_belts(along) and (len(toes) < len(SIDES) or _two_belts(toes)):  # (4)
        belts = {side: v / speed * np.median(own) for side, own in along.items()}
        own = np.concatenate([own - np.median(own) for own in along.values()])
        return Floor(v, float(np.hypot(np.sqrt(np.mean(own**2)), STEADY * speed)), belts)
    return Floor(v, float(np.sqrt(np.mean((np.concatenate(list(along.values())) - speed) ** 2))))


def _two_belts(along: Mapping[Side, Floats]) -> bool:
    """Whether (N) mm/s of the stances of each foot, along the way, are those of two belts (4)."""
    if len(along) < len(SIDES):
        return False
    left, right = medians = [float(np.median(along[side])) for side in SIDES]
    own = max(float(np.abs(along[side] - median).max()) for side, median in zip(SIDES, medians, strict=True))
    return abs(left - right) > max(APART * abs(left + right) / 2, 2 * own)


def _carried(events: Sequence[FootEvent], points: Mapping[str, Floats], flat: tuple[float, float], rate: float) -> bool:
    """Whether the floor carries heels and toes against their swing (3)."""
    return all(np.median(_along_swing(events, points, part, flat, rate)) < -CARRIED for part in ("HEE", "TOE"))


def _along_swing(
    events: Sequence[FootEvent], points: Mapping[str, Floats], part: str, flat: tuple[float, float], rate: float
) -> list[float]:
    """mm/s at which this part of the feet goes in each stance along its next swing; 0 alone where none is seen."""
    found = []
    for side in SIDES:
        own = sorted((e for e in events if e.side == side), key=lambda e: e.time)
        xyz = points.get(LETTER[side] + part, np.empty((0, 3)))
        for strike, off, next_strike in zip(own, own[1:], own[2:], strict=False):
            if len(xyz) and strike.strike and not off.strike and next_strike.strike:
                begin, end = (strike.time + share * (off.time - strike.time) for share in flat)
                swing = unit(along_floor(_at(xyz, next_strike.time * rate) - _at(xyz, off.time * rate)))
                found.append(float(along_floor(_slope(xyz, begin, end, rate)) @ swing))
    return [v for v in found if np.isfinite(v)] or [0.0]


def _at(xyz: Floats, frame: float) -> Floats:
    """(3) mm of a marker (F, 3) in the frame next to this one."""
    return np.asarray(xyz[min(max(round(frame), 0), len(xyz) - 1)])


def _gone(events: Sequence[FootEvent], points: Mapping[str, Floats], rate: float) -> float:
    """mm/s at which heels go from strike to strike, the median; infinite where none is seen to strike twice."""
    speeds = []
    for side in SIDES:
        heel = points[LETTER[side] + "HEE"]
        times = sorted(e.time for e in events if e.side == side and e.strike)
        for begin, end in pairwise(times):
            way = _at(heel, end * rate) - _at(heel, begin * rate)
            speeds.append(float(np.linalg.norm(along_floor(way))) / (end - begin))
    seen = [speed for speed in speeds if np.isfinite(speed)]
    return float(np.median(seen)) if seen else np.inf


def _stood(heel: Floats, own: Sequence[FootEvent], flat: tuple[float, float], rate: float) -> Floats:
    """(N, 3) mm/s along the floor, of a heel (F, 3) in each stance that is seen, between these shares of it."""
    at = [[begin + share * (end - begin) for share in flat] for begin, end in _stances(own)]
    slopes = [_slope(heel, first, last, rate) for first, last in at]
    return np.array([along_floor(v) for v in slopes if np.isfinite(v).all()]).reshape(-1, 3)


def _stances(own: Sequence[FootEvent]) -> list[tuple[float, float]]:
    """s of the strike and the off of each whole stance of a foot."""
    own = sorted(own, key=lambda e: e.time)
    return [(a.time, b.time) for a, b in pairwise(own) if a.strike and not b.strike]


def _slope(heel: Floats, begin: float, end: float, rate: float) -> Floats:
    """(3) mm/s (1), of a heel (F, 3) between two times, s; NaN where it is not seen."""
    first, last = int(np.round(begin * rate)), int(np.round(end * rate))
    xyz = heel[max(first, 0) : last + 1]
    if len(xyz) < FEWEST or not np.isfinite(xyz).all():
        return np.full(3, np.nan)
    t = (np.arange(len(xyz)) - (len(xyz) - 1) / 2) / rate
    return np.asarray(t @ xyz / (t @ t))
