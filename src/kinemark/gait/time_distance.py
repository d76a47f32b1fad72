"""Time-distance parameters of strides: speed, cadence, lengths, width, supports.

A stride of a side goes from one of its foot strikes, t₀, to the next, t₁. With h the heel of this foot and g that of
the other, on the floor, d the direction from h(t₀) to h(t₁), and s the strike of the other foot in between,

    stride length  ℓ = |h(t₁) − h(t₀)|,   speed ℓ / (t₁ − t₀),   cadence 120 / (t₁ − t₀)                     (1)
    step length    (h(t₁) − g(s)) · d,   step width  (h(t₁) − g(s)) · b                                      (2)
    step time      t₁ − s                                                                                    (3)
    foot off, opposite foot off, opposite foot strike: as % of the stride                                     (4)
    double support = from t₀ to the other's foot off and from the other's strike to this foot off,
    single support = from the other's foot off to its strike                                                 (5)

where, of a runner, whose other foot has left before t₀ or strikes after this one left, such a double support is 0 and
single support begins with t₀ or ends with this foot off. And b is horizontal, square to d, and from the right side of
the body to its left for a left step, else the other way: a
step in which the feet cross has a width below zero, as in scissoring, so a mean of steps is true. Who walks backwards,
by the feet, has the left where d has the right. Each foot is where it struck (2), as in Plug-in Gait: at t₁ the other
heel has left the floor and gone on by some centimetres. So steps of both sides make a stride.

Standard uncertainties follow from those of the events and of the heels, each independent: of a time √(σ₀² + σ₁²), of
a length the heels' along d with what they move in the uncertainty of the event, of a ratio the shares' root sum of
squares. In the speed what a heel moves and what its event is off cancel in part, and the first is left out (6). Where
the heels' markers sit beside their landmarks, by s along each axis, a step's length and width are off by √2 s in every
stride; the way of one heel is not (7). On a treadmill heels are taken as its belt sees them (`treadmill`): of belts
that differ a stride as its own foot's does, and a step, which begins where the other foot struck, as the other's (8).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.strides import UNITS, FootEvent, Stride
from ..data.subject_measures import LETTER, Side
from .segments import Z_UP, along_floor, unit
from .treadmill import STILL, Floor

OF_BOTH_HEELS = ("step_length", "step_width")
"""Parameters that hang on where two different markers sit (7); by definition."""


ORDER: tuple[tuple[Side, Side], ...] = (("left", "right"), ("right", "left"))
"""A side and the other one; by definition."""


class _Heels(NamedTuple):
    """(F, 3) mm of a heel on the belt below it, the same on the belt below the other foot, and the other heel there."""

    own: Floats
    own_there: Floats
    other: Floats


def strides(
    events: Sequence[FootEvent],
    points: Mapping[str, Floats],
    *,
    rate: float,
    heel_sd_mm: float = 0.0,
    placement_mm: float = 0.0,
    floor: Floor = STILL,
) -> tuple[Stride, ...]:
    """All strides of both sides, in the order of their first foot strike.

    Args:
        events: of the trial, in any order.
        points: (F, 3) mm, with LHEE and RHEE; LTOE and RTOE, where known, tell who walks backwards.
        rate: frames a second. heel_sd_mm: of a heel along an axis, by noise. placement_mm: by where its marker sits.
        floor: that moves, on a treadmill.
    """
    feet = [name for name in ("LHEE", "RHEE", "LTOE", "RTOE") if name in points]
    found = []
    for side, other in ORDER:
        own_belt, other_belt = ({name: floor.still(points[name], rate, one) for name in feet} for one in (side, other))
        own = sorted((e for e in events if e.side == side and e.strike), key=lambda e: e.time)
        offs = [e for e in events if e.side == side and not e.strike]
        theirs = [e for e in events if e.side == other]
        heel, others = (LETTER[one] + "HEE" for one in (side, other))
        heels = _Heels(own_belt[heel], other_belt[heel], other_belt[others])  # (8)
        for begin, end in pairwise(own):
            one = _stride(begin, end, offs, theirs, heels, rate, heel_sd_mm, floor.sd)
            if _goes_backwards(own_belt, begin, end, rate):
                one = one._replace(values={**one.values, "step_width": -one.values["step_width"]})
            found.append(_misplaced(one, float(np.sqrt(2) * placement_mm)))
    return tuple(sorted(found, key=lambda one: one.first))


def _misplaced(stride: Stride, by: float) -> Stride:
    """With (7), mm."""
    more = {name: by if name in OF_BOTH_HEELS else 0.0 for name in UNITS}
    return stride._replace(sd={k: float(np.hypot(s, more[k])) for k, s in stride.sd.items()}, systematic=more)


def _goes_backwards(points: Mapping[str, Floats], begin: FootEvent, end: FootEvent, rate: float) -> bool:
    """Whether a foot points against its way; not where its toe is not known."""
    heel, toe = (points.get(LETTER[begin.side] + name) for name in ("HEE", "TOE"))
    if heel is None or toe is None:
        return False
    during = slice(round(begin.time * rate), round(end.time * rate) + 1)
    way = _at(heel, end, rate) - _at(heel, begin, rate)
    along = (toe - heel)[during] @ way
    return bool(np.isfinite(along).any() and np.nanmedian(along) < 0)


def _stride(
    begin: FootEvent,
    end: FootEvent,
    offs: Sequence[FootEvent],
    theirs: Sequence[FootEvent],
    heels: _Heels,
    rate: float,
    heel_sd: float,
    floor_sd: float,
) -> Stride:
    """(1) to (6) of one; floor_sd: mm/s of the floor's velocity."""
    off = _only(offs, begin, end)
    other_off = _only([e for e in theirs if not e.strike], begin, end)
    other_strike = _only([e for e in theirs if e.strike], begin, end)
    alone = other_off if not _after(other_off, other_strike) else begin  # from which on this foot stands alone
    till = off if _after(other_strike, off) else other_strike
    first_double, second_double = _between(begin, alone), _between(till, off)
    T, sd_T = _between(begin, end)
    shares = [_share(begin, event, end) for event in (off, other_off, other_strike)]
    values = {
        "stride_time": (T, sd_T),
        "cadence": (120.0 / T, 120.0 / T * sd_T / T),
        "step_time": _between(other_strike, end),
        "foot_off": shares[0],
        "opposite_foot_off": shares[1],
        "opposite_foot_strike": shares[2],
        "single_support": _between(alone, till),
        "double_support": (
            first_double[0] + second_double[0], float(np.hypot(first_double[1], second_double[1])),
        ),
    } | _distances(begin, end, other_strike, heels, rate, heel_sd, floor_sd)  # fmt: skip
    value = {name: values[name][0] for name in UNITS}
    sd = {name: values[name][1] if np.isfinite(value[name]) else np.nan for name in UNITS}
    return Stride(begin.side, begin.time, end.time, value, sd)


def _distances(
    begin: FootEvent,
    end: FootEvent,
    struck: FootEvent | None,
    heels: _Heels,
    rate: float,
    heel_sd: float,
    floor_sd: float,
) -> dict[str, tuple[float, float]]:
    """Lengths and width, mm, and speed of a stride, each with its standard uncertainty; steps where the other foot
    `struck` in between."""
    T, sd_T = _between(begin, end)
    first, last = _at(heels.own, begin, rate), _at(heels.own, end, rate)
    other, other_sd = np.full(3, np.nan), np.nan
    if struck is not None:
        other, other_sd = _at(heels.other, struck, rate), _heel_sd(heels.other, struck, rate, heel_sd)
    path, step = along_floor(last - first), along_floor(_at(heels.own_there, end, rate) - other)
    length, along = float(np.linalg.norm(path)), unit(path)
    first_sd, last_sd = (_heel_sd(heels.own, event, rate, heel_sd) for event in (begin, end))
    both_heels, belt = heel_sd * np.sqrt(2), floor_sd * T
    return {
        "stride_length": (length, float(np.linalg.norm([first_sd, last_sd, belt]))),
        "speed": _ratio((length, float(np.hypot(both_heels, belt))), (T, sd_T)),
        "step_length": (float(step @ along), float(np.hypot(last_sd, other_sd))),
        "step_width": (float(step @ np.cross(Z_UP, along)) * (1 if begin.side == "left" else -1), float(both_heels)),
    }


def _only(events: Sequence[FootEvent], begin: FootEvent, end: FootEvent) -> FootEvent | None:
    """The one event between two; None where there is none or more than one."""
    inside = [e for e in events if begin.time < e.time < end.time]
    return inside[0] if len(inside) == 1 else None


def _after(a: FootEvent | None, b: FootEvent | None) -> bool:
    """Whether an event comes after another one; not where one is missing."""
    return a is not None and b is not None and a.time > b.time


def _between(a: FootEvent | None, b: FootEvent | None) -> tuple[float, float]:
    """s, and its standard uncertainty."""
    if a is None or b is None:
        return np.nan, np.nan
    return b.time - a.time, float(np.hypot(a.sd, b.sd))


def _share(begin: FootEvent, event: FootEvent | None, end: FootEvent) -> tuple[float, float]:
    """% of the stride (4), whose beginning counts in both its parts."""
    if event is None:
        return np.nan, np.nan
    T = end.time - begin.time
    share = (event.time - begin.time) / T
    sd = np.linalg.norm([event.sd, share * end.sd, (1 - share) * begin.sd]) / T
    return 100 * share, float(100 * sd)


def _ratio(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """a / b by (6)."""
    value = a[0] / b[0]
    return value, float(abs(value) * np.hypot(a[1] / a[0] if a[0] else 0.0, b[1] / b[0]))


def _at(xyz: Floats, event: FootEvent, rate: float) -> Floats:
    """(3) mm at the time of an event, along a line between frames; NaN outside."""
    x = event.time * rate
    k = int(np.clip(np.floor(x), 0, max(len(xyz) - 2, 0)))
    if not -1e-9 <= x <= len(xyz) - 1 + 1e-9:
        return np.full(3, np.nan)
    w = x - k
    after = xyz[min(k + 1, len(xyz) - 1)]
    return np.asarray(xyz[k] if w == 0 else after if w == 1 else (1 - w) * xyz[k] + w * after)


def _heel_sd(xyz: Floats, event: FootEvent, rate: float, heel_sd: float) -> float:
    """mm along an axis of a heel at an event: its own, and what it moves in the uncertainty of the event."""
    around = (_at(xyz, event._replace(time=event.time + shift), rate) for shift in (-event.sd, event.sd))
    moved = np.linalg.norm(np.subtract(*around)) / 2
    return float(np.hypot(heel_sd, np.nan_to_num(moved)))


def averages(found: Sequence[Stride], side: Side) -> dict[str, tuple[float, float, int]]:
    """Of each parameter: mean over strides, their standard deviation, and how many there are."""
    own = [stride for stride in found if stride.side == side]
    out = {}
    for name in UNITS:
        known = np.array([s.values[name] for s in own if np.isfinite(s.values[name])])
        spread = float(known.std(ddof=1)) if len(known) > 1 else np.nan
        out[name] = (float(known.mean()) if len(known) else np.nan, spread, len(known))
    return out
