"""How a foot moves: what the detectors of foot events look at, at one rate for all recordings.

Heel h, toe q and pelvis p are low-passed, joined by quintic splines, whose third derivatives have no steps, and read at
500 Hz, so that an event has the same time at 50 and at 250 frames a second. With e from heel to toe and L their usual
distance,

    m = (h + q) / 2,   t = q + 0.4 L e                                                                     (1)

are the middle and the tip of the foot, which leaves the floor last. Velocities count from the floor: on a treadmill it
moves as the foot's middle does while it stands, that is while it goes back under the pelvis the fastest (2).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Bools, Floats, Ints
from ..data.subject_measures import LETTER, Side
from ..signal.filters import butterworth, edge_samples
from .lower_limb import pelvis_of
from .segments import Z_UP, along_floor, unit

FINE_HZ = 500.0
"""Rate at which a foot is looked at, Hz; chosen: jerks of 15 Hz hardly change in 2 ms."""
CUTOFF_HZ = 15.0
"""Of the markers, Hz; chosen: between 10 and 25 Hz errors against plates were the same."""
TIP = 0.4
"""By which the toes reach beyond the toe's marker, as a share of its distance from the heel's; chosen: between 0.2 and
0.8 errors against plates were the same."""
STANDING = 35.0
"""Percentile of the speed of the middle before the pelvis below which the foot stands; chosen: it stands for 40 to 80 %
of the time."""
BELT_MM_S = 150.0
"""Speed of the floor below which it is no treadmill, mm/s; chosen: feet that stand seem to move by up to 50."""
LEAST_S = 0.3
"""Length of time in which a foot must be seen, s; chosen: shorter, and there is no step."""


class Foot(NamedTuple):
    """Motion of one foot at N times, mm and rad, s.

    Attributes:
        time: (N) s after the first frame. seen: whether both markers and the pelvis were, and not bridged.
        middle: (N, 3) of (1), from the pelvis' first place.
        heel_ahead, toe_ahead: before the pelvis as it faces. toe_forward: speed of the toe from the pelvis.
        heel_z, toe_down: height of the heel, speed of the toe downwards.
        heel_jerk, heel_jerk_up, middle_jerk_up: forwards and upwards. turning_jerk: third derivative of the pitch.
        middle_speed: from the floor. tip_speed, tip_gain: of (1) along the floor, and its rate.
    """

    time: Floats
    seen: Bools
    middle: Floats
    heel_ahead: Floats
    toe_ahead: Floats
    toe_forward: Floats
    heel_z: Floats
    toe_down: Floats
    heel_jerk: Floats
    heel_jerk_up: Floats
    middle_jerk_up: Floats
    turning_jerk: Floats
    middle_speed: Floats
    tip_speed: Floats
    tip_gain: Floats


def foot_motion(points: Mapping[str, Floats], side: Side, rate: float) -> Foot | None:
    """What the detectors look at; None where the foot is hardly seen.

    Args:
        points: (F, 3) mm by the model's names. side: of the foot. rate: frames a second.
    """
    pelvis = pelvis_of(points)[0]
    raw = [points[LETTER[side] + "HEE"], points[LETTER[side] + "TOE"], pelvis.origin, pelvis.R[..., 0]]
    there = np.asarray(np.isfinite(np.concatenate(raw, 1)).all(axis=1))
    known = np.flatnonzero(there)
    if len(known) < LEAST_S * rate or known[-1] + 1 - known[0] <= edge_samples(2):
        return None
    raw[:3] = [xyz - pelvis.origin[known[0]] for xyz in raw[:3]]  # third derivatives would show a far origin's rounding
    frames = np.arange(known[0], known[-1] + 1)
    time = np.arange(known[0] / rate, known[-1] / rate, 1 / FINE_HZ)
    heel, toe, centre, x = (_read(each, frames, known, rate, time) for each in raw)
    seen = np.interp(time, frames / rate, there[frames]) == 1.0
    return _moving(time, seen, heel, toe, centre, unit(along_floor(x)))


def _moving(time: Floats, seen: Bools, heel: Floats, toe: Floats, pelvis: Floats, d: Floats) -> Foot:
    """Of markers and the pelvis' own direction d on the floor, (N, 3)."""
    sole, centre = toe - heel, (heel + toe) / 2
    e, length = unit(sole), float(np.median(np.linalg.norm(sole, axis=1)))
    floor = _floor(_rate(centre), _rate(pelvis), d)
    tip = _rate(toe + TIP * length * e) - floor
    tip_speed = np.linalg.norm(along_floor(tip), axis=1)
    forward = ((toe - pelvis) * d).sum(1)
    return Foot(
        time, seen, centre,
        heel_ahead=((heel - pelvis) * d).sum(1),
        toe_ahead=forward,
        toe_forward=_rate(forward),
        heel_z=heel @ Z_UP,
        toe_down=-_rate(toe @ Z_UP),
        heel_jerk=(_rate(heel, 3) * d).sum(1),
        heel_jerk_up=_rate(heel @ Z_UP, 3),
        middle_jerk_up=_rate(centre @ Z_UP, 3),
        turning_jerk=_rate(np.arcsin(np.clip(-(e @ Z_UP), -1, 1)), 3),
        middle_speed=np.linalg.norm(_rate(centre) - floor, axis=1),
        tip_speed=tip_speed,
        tip_gain=_rate(tip_speed),
    )  # fmt: skip


def _floor(centre: Floats, pelvis: Floats, d: Floats) -> Floats:
    """(3) mm/s velocity of the floor (2), from velocities (N, 3) of the foot's middle and the pelvis."""
    back = ((centre - pelvis) * d).sum(1)
    v = along_floor(np.median(centre[back <= np.percentile(back, STANDING)], axis=0))
    return v if np.linalg.norm(v) >= BELT_MM_S else np.zeros(3)


def _rate(x: Floats, times: int = 1) -> Floats:
    """(N, …) a second, by differences of neighbours, so many times."""
    for _ in range(times):
        x = np.gradient(x, axis=0) * FINE_HZ
    return x


def _read(xyz: Floats, frames: Ints, known: Ints, rate: float, time: Floats) -> Floats:
    """(N, 3) at times, low-passed between the first and the last known frame, gaps bridged by cubics (Akima 1970)."""
    bridged = scipy.interpolate.Akima1DInterpolator(known, xyz[known])(frames)
    smooth = butterworth(bridged, rate=rate, cutoff_hz=min(CUTOFF_HZ, 0.4 * rate), order=2)
    return np.asarray(scipy.interpolate.make_interp_spline(frames / rate, smooth, k=5)(time))
