"""Detectors of foot strikes and foot offs from markers.

With p the pelvis, h the heel, q the toe and forwards d the pelvis' own direction on the floor, an event is first looked
for where

    strike: (h − p) · d is greatest,   off: (q − p) · d is least (Zeni et al. 2008)                          (1)

which holds on a treadmill too. About it several detectors give a time each. Those of a strike say when the foot's way
down and forwards ends, those of an off when the tip of the foot begins to go forwards (`foot_motion`):

    strike:  heel lowest;  jerk upwards of the heel and of the middle greatest;  toe goes down fastest;
             jerk of the heel forwards greatest;  jerk of the pitch least;  middle slower than 0.1 of its swing    (2)
    off:     tip faster than 0.6 m/s;  tip faster than 0.3 of its swing;  tip gains speed the fastest;
             toe begins to go forwards from the pelvis                                                            (3)

Each has a mean bias against force plates. A plate is left when the force falls below 20 N, which is a large share of a
child's weight, and is long before the end where weight is shifted slowly. So the bias of an off grows with

    λ = ln(T² / l³),   T the stride in s, l the leg in units of 0.9 m                                             (4)

Sources: Zeni et al. 2008; Hreljac and Marshall 2000 (jerk of the heel); O’Connor et al. 2007 (velocity of the foot);
Ghoussayni et al. 2004 (thresholds of speed).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES
from .foot_motion import FINE_HZ, Foot, foot_motion

LEAST_SWING_MM = 60.0
"""By which a foot moves to and fro under the pelvis in a step, mm; chosen: in steps of 50 mm it is 75."""
LEAST_WAY_MM = 30.0
"""By which a foot moves in a swing, mm; chosen: where the pelvis sways, feet stay to a few."""


class Near(NamedTuple):
    """Where detectors look: slices of a foot's samples, for peaks, and for speeds that rise or fall before or after."""

    peak: slice
    speed: slice


class Detector(NamedTuple):
    """A detector: its time s about (1), NaN where there is none; its bias (5) against plates, ms."""

    time: Callable[[Foot, Near], float]
    bias_ms: float
    slow_ms: float = 0.0


STRIKE = (
    Detector(lambda f, near: greatest(-f.heel_z, f.time, near.peak), 9.0),
    Detector(lambda f, near: greatest(f.heel_jerk_up, f.time, near.peak), -21.0),
    Detector(lambda f, near: greatest(f.middle_jerk_up, f.time, near.peak), -12.0),
    Detector(lambda f, near: greatest(f.toe_down, f.time, near.peak), 0.0),
    Detector(lambda f, near: greatest(f.heel_jerk, f.time, near.peak), -9.0),
    Detector(lambda f, near: greatest(-f.turning_jerk, f.time, near.peak), 5.0),
    Detector(lambda f, near: slower(f.middle_speed, f.time, near.speed, 0.1), 14.0),
)
"""(2), with biases in ms; measured on 27 strikes of 10 subjects on plates (studies/gait_events.py)."""
OFF = (
    Detector(lambda f, near: faster(f.tip_speed, f.time, near.speed, TIP_MM_S / _top(f.tip_speed, near)), -9.0, 34.0),
    Detector(lambda f, near: faster(f.tip_speed, f.time, near.speed, 0.3), 8.0, 34.0),
    Detector(lambda f, near: greatest(f.tip_gain, f.time, near.peak), 16.0, 35.0),
    Detector(lambda f, near: faster(f.toe_forward, f.time, near.speed, 0.0), 1.0, 20.0),
)
"""(3), with biases in ms and their slopes on λ; measured on 31 offs of 10 subjects (studies/gait_events.py)."""
TIP_MM_S = 600.0
"""Speed of the tip of a foot that has left the floor, mm/s; chosen: a fifth of a swing's."""
PEAK_SHARE = {True: (-0.05, 0.13), False: (-0.12, 0.12)}
"""Of a stride, from (1), in which peaks are looked for, of strikes and offs; chosen: (1) was up to 0.12 before strikes
and within 0.05 of offs."""
SPEED_SHARE = {True: (-0.3, 0.15), False: (-0.18, 0.3)}
"""Of a stride, from (1), within which speeds fall to a strike or rise from an off; chosen: a swing takes 0.4."""
SLOW = (-0.3, 1.3)
"""Range of λ (4) that is believed; measured on 10 subjects: it was −0.1 to 1.1 (studies/gait_events.py)."""
USUAL_LEG_MM = 900.0
"""Unit of legs in (4), mm; chosen: an adult's."""
OF_A_GAP = 0.125
"""Standard uncertainty of an event in a gap, as a share of its length; measured on gaps of 0.04 to 0.24 s in heels
and toes of five walks: they moved events by 0.11 to 0.13 of their length (RMS)."""
USUAL_STRIDE_S = 1.0
"""Stride where none is whole, s; chosen: an adult's."""


class Votes(NamedTuple):
    """Times of the detectors, s, about an event (1), whose `sd` is of what was not seen; and λ (4)."""

    event: FootEvent
    times: Floats
    slow: float


def voted(points: Mapping[str, Floats], rate: float) -> list[Votes]:
    """The detectors' times for both feet, as (2) and (3) have them.

    Args:
        points: (F, 3) mm by the model's names. rate: frames a second.
    """
    feet = {side: foot for side in SIDES if (foot := foot_motion(points, side, rate)) is not None}
    rough = {
        (side, strike): foot.time[_swings(foot.heel_ahead if strike else -foot.toe_ahead, foot.middle)]
        for side, foot in feet.items()
        for strike in (True, False)
    }
    stride = _stride(list(rough.values()))
    slow = float(np.clip(np.log(stride**2 / (_leg_mm(points) / USUAL_LEG_MM) ** 3), *SLOW))  # (4)
    found = []
    for (side, strike), times in rough.items():
        foot = feet[side]
        for t in times:
            near = Near(*(_window(foot, t, stride, share[strike]) for share in (PEAK_SHARE, SPEED_SHARE)))
            event = FootEvent(side, strike, float(t), _unseen(foot, near.peak), "markers")
            votes = [d.time(foot, near) for d in (STRIKE if strike else OFF)]
            found.append(Votes(event, np.array(votes), slow))
    return found


def _window(foot: Foot, t: float, stride: float, share: tuple[float, float]) -> slice:
    first, stop = np.searchsorted(foot.time, [t + share[0] * stride, t + share[1] * stride])
    return slice(int(first), int(stop))


def _unseen(foot: Foot, near: slice) -> float:
    """s, the standard uncertainty of an event by what was bridged of its frames."""
    return float((~foot.seen[near]).sum() / FINE_HZ * OF_A_GAP)


def _stride(rough: Sequence[Floats]) -> float:
    """s, the median over feet and kinds of events."""
    each = np.concatenate([np.diff(times) for times in rough] or [np.zeros(0)])
    return float(np.median(each)) if len(each) else USUAL_STRIDE_S


def _leg_mm(points: Mapping[str, Floats]) -> float:
    """From the front of the pelvis to the ankle, as long as it gets; the usual leg where it is not seen."""
    found = []
    for letter in LETTER.values():
        if {letter + "ASI", letter + "ANK"} <= set(points):
            length = np.linalg.norm(points[letter + "ASI"] - points[letter + "ANK"], axis=1)
            found += [np.quantile(known, 0.85)] if len(known := length[np.isfinite(length)]) else []
    return float(np.mean(found)) if found else USUAL_LEG_MM


def greatest(y: Floats, time: Floats, near: slice) -> float:
    """Time of the greatest value of y (F) in some frames, to a part of a frame by a parabola; NaN at their ends."""
    if not np.isfinite(y[near]).any():
        return np.nan
    k = int(np.nanargmax(y[near])) + near.start
    if not max(near.start, 0) < k < min(near.stop, len(y)) - 1:
        return np.nan
    a, b, c = y[k - 1], y[k], y[k + 1]
    return float(time[k] + 0.5 * (a - c) / (a - 2 * b + c) * (time[1] - time[0])) if a + c < 2 * b else np.nan


FAST = 0.6
"""Share of the way from a level to a swing's greatest speed from which on a foot swings; chosen."""


def faster(speed: Floats, time: Floats, near: slice, share: float) -> float:
    """When a speed (F) rose through a share of its greatest value in some frames the last time before the swing."""
    y, t = speed[near], time[near]
    if not len(y) or not 0 <= share < 1 or (top := y.max()) <= 0:
        return np.nan
    swing = int(np.argmax(y > (share + FAST * (1 - share)) * top))
    below = np.flatnonzero(y[:swing] <= share * top)
    return _between(y, t, int(below[-1]), share * top) if len(below) else np.nan


def slower(speed: Floats, time: Floats, near: slice, share: float) -> float:
    """When a speed (F) fell through a share of its greatest value in some frames the first time after the swing."""
    y, t = speed[near], time[near]
    return -faster(y[::-1], -t[::-1], slice(0, len(y)), share)


def _between(y: Floats, t: Floats, k: int, level: float) -> float:
    """Time at which y crosses a level between samples k and k + 1."""
    return float(t[k] + (level - y[k]) / (y[k + 1] - y[k]) * (t[k + 1] - t[k]))


def _top(speed: Floats, near: Near) -> float:
    return float(speed[near.speed].max(initial=1.0))


def _swings(y: Floats, middle: Floats) -> list[int]:
    """Samples of the greatest values (1) between which y (N) falls by a step, before or after which the foot, whose
    middle is at (N, 3) mm, swings: where it stays, the pelvis sways above it."""
    found: list[int] = []
    for k in _peak_indices(y):
        if found and y[k] - np.nanmin(y[found[-1] : k + 1]) < LEAST_SWING_MM:
            if y[k] > y[found[-1]]:
                found[-1] = k
        else:
            found.append(k)
    falls = [k for k in found if y[k] - min(np.nanmin(y[: k + 1]), np.nanmin(y[k:])) >= LEAST_SWING_MM]
    bounds = [0, *falls, len(y)]
    return [k for a, k, b in zip(bounds, falls, bounds[2:], strict=False) if _goes(y, middle, k, (a, b))]


def _goes(y: Floats, middle: Floats, k: int, between: tuple[int, int]) -> bool:
    """Whether the foot moves from the peak k to the least value of y before or after it, between its neighbours."""
    a, b = between
    least = [a + int(np.argmin(y[a : k + 1])), k + int(np.argmin(y[k:b]))]
    return bool((np.linalg.norm(middle[least] - middle[k], axis=1) > LEAST_WAY_MM).any())


def _peak_indices(y: Floats) -> list[int]:
    with np.errstate(invalid="ignore"):
        return [int(k) for k in np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:])) + 1]
