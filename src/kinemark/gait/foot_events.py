"""Foot strikes and foot offs, from plates where they speak and from markers elsewhere, each with its expected error.

With p the pelvis, h the heel, q the toe, m their middle, forwards d the pelvis' own direction on the floor, markers
low-passed at 15 Hz, and z upwards, an event is first looked for where

    strike: (h − p) · d is greatest,   off: (q − p) · d is least (Zeni et al. 2008)                          (1)

which holds on a treadmill too. Within an eighth of a stride of it each of these detectors gives a time t_i:

    strike:  toe falls fastest, min q̇_z (foot slap);  foot stops falling, max m̈_z;  heel is braked, max ḧ_z;
             heel is slower than a tenth of the foot's fastest swing                                          (2)
    off:     toe is pulled up, max q̈_z;  toe is pulled along the floor, max |q̈_xy|                           (3)

Their mean biases b_i and deviations s_i against force plates are known from other subjects. The time is the mean of
t_i − b_i weighted by 1/s_i². Where plates give n events of the same kind in the trial, the mean difference from them is
taken off, shrunk as n / (n + ν) with ν = (deviation within a subject / between subjects)² (4). The expected error is
made of both deviations and of how far the detectors are apart (5).

Events that contradict each other are not kept together (`event_order`).

Sources: Zeni et al. 2008; Hreljac and Marshall 2000 (accelerations of heel and toe); O’Connor et al. 2007 (velocity of
the foot).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..data import Trial
from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES, Side
from ..signal.filters import butterworth, edge_samples
from .event_order import ordered
from .lower_limb import pelvis_of
from .plate_contacts import Contact, contacts
from .reaction import Reaction, reaction
from .segments import Z_UP, level_axes, unit

CUTOFF_HZ = 15.0
"""Of the markers; chosen: between 10 and 30 Hz errors against plates were the same."""
WINDOW = 0.125
"""Share of a stride about (1) in which detectors look; chosen: (1) is within 60 ms of the event."""
LEAST_SWING_MM = 100.0
"""By which a foot moves to and fro under the pelvis in a step, mm; chosen: less is no step."""
PLATE_N = 20.0
"""Vertical force of contact, N (Zeni et al. 2008)."""
BETWEEN_MS = {True: 6.5, False: 9.0}
"""Deviation of the mean of the detectors between subjects, ms, of strikes and offs; measured on 24 strides of 8
subjects on plates (docs/theory/gait.md), each subject judged by the biases of the others."""
WITHIN_MS = {True: 5.5, False: 6.0}
"""Deviation within a subject, ms; measured on the same strides."""

COMMON = 0.7
"""Of the expected error (5), as its parts have causes in common; measured on 40 events of 6 subjects, each judged by
the others: errors are 1.03 of it (RMS)."""


class Detector(NamedTuple):
    """A detector: its times s, from the foot; bias and deviation against plates, ms."""

    times: Callable[[Foot], Floats]
    bias_ms: float
    deviation_ms: float


class Foot(NamedTuple):
    """(F, 3) mm/s and mm/s² of one foot, and (F) s.

    Attributes:
        time: (F) s. forward: (F) mm heel, toe before the pelvis, as a pair.
        heel_v, toe_v, heel_a, toe_a, middle_a: (F, 3). fastest: mm/s of its swing.
    """

    time: Floats
    heel_ahead: Floats
    toe_ahead: Floats
    heel_v: Floats
    toe_v: Floats
    heel_a: Floats
    toe_a: Floats
    middle_a: Floats
    fastest: float


STRIKE = (
    Detector(lambda f: peaks(-f.toe_v[:, 2], f.time), 1.0, 8.0),
    Detector(lambda f: peaks(f.middle_a[:, 2], f.time), 33.0, 10.0),
    Detector(lambda f: peaks(f.heel_a[:, 2], f.time), 3.0, 20.0),
    Detector(lambda f: crossings(_speed(f.heel_v), f.time, 0.1 * f.fastest, upwards=False), -10.0, 9.0),
)
"""(2), with biases and deviations in ms; measured on 24 strikes of 8 subjects on plates (docs/theory/gait.md)."""
OFF = (
    Detector(lambda f: peaks(f.toe_a[:, 2], f.time), -14.0, 10.0),
    Detector(lambda f: peaks(_speed(f.toe_a[:, :2]), f.time), 25.0, 9.0),
)
"""(3), with biases and deviations in ms; measured on 20 offs of 6 of these subjects."""


def foot_events(trial: Trial, points: Mapping[str, Floats], *, up: Floats = Z_UP) -> tuple[FootEvent, ...]:
    """All foot strikes and offs of a trial, in the order of time.

    Args:
        trial: with its plates and channels. points: (F, 3) mm of its markers by name.
        up: of the laboratory.
    """
    rate = trial.trajectories.rate
    measured = plate_events(trial, points, up=up)
    found: list[FootEvent] = []
    for strike, detectors in ((True, STRIKE), (False, OFF)):
        seen = [e for side in SIDES for e in _from_markers(points, side, strike, detectors, rate, up)]
        known = [e for e in measured if e.strike == strike]
        found += _calibrated(seen, known, strike)
    return ordered(found)


def plate_events(trial: Trial, points: Mapping[str, Floats], *, up: Floats = Z_UP) -> tuple[FootEvent, ...]:
    """Events of feet that stood whole and alone on a plate, to a sample of its channels."""
    rate, n = trial.trajectories.rate, trial.trajectories.n_frames
    at_frames = [reaction(p, trial.analog, n_frames=n, rate=rate, threshold_n=PLATE_N, up=up) for p in trial.plates]
    found: list[FootEvent] = []
    for one in contacts(at_frames, points, rate=rate, up=up):
        if one.side is not None and not one.reason:
            found += _of_contact(trial, one, up)
    return tuple(sorted(found, key=lambda e: e.time))


def _of_contact(trial: Trial, contact: Contact, up: Floats) -> list[FootEvent]:
    """Strike and off of one contact at the rate of its channels."""
    plate, rate = trial.plates[contact.plate], trial.trajectories.rate
    record = next(a for a in trial.analog if plate.channels[0] in a.names)
    fine = reaction(
        plate, trial.analog, n_frames=record.values.shape[1], rate=record.rate, threshold_n=PLATE_N, averaged=False,
        up=up,
    )  # fmt: skip
    first, stop = (round(frame / rate * record.rate) for frame in (contact.first - 2, contact.stop + 2))
    window = slice(max(first, 0), max(stop, 0))
    on = np.flatnonzero(fine.loaded[window]) + window.start
    if not len(on) or contact.side is None:
        return []
    ends = ((True, on[0]), (False, on[-1]))
    return [
        FootEvent(contact.side, strike, k / record.rate + record.start, _slope_sd(fine, k, record.rate, up), "plate")
        for strike, k in ends
    ]


def _slope_sd(fine: Reaction, k: int, rate: float, up: Floats) -> float:
    """s: a sample, or half of what the force takes to double."""
    force = np.abs(fine.force @ up)
    near = force[max(k - 50, 0) : k + 50] > 2 * PLATE_N
    at = np.flatnonzero(near) + max(k - 50, 0)
    return float(max(0.5, np.abs(at - k).min() / 2 if len(at) else 0.5) / rate)


def _from_markers(
    points: Mapping[str, Floats], side: Side, strike: bool, detectors: Sequence[Detector], rate: float, up: Floats
) -> list[FootEvent]:
    """Events of one kind and side by (1) to (3), without calibration."""
    foot = _foot(points, side, rate, up)
    if foot is None:
        return []
    rough = _swings(foot.heel_ahead if strike else -foot.toe_ahead, foot.time)
    stride = float(np.median(np.diff(rough))) if len(rough) > 1 else 1.0
    times = [(d, d.times(foot)) for d in detectors]
    found = []
    for t in rough:
        votes = [_near(each, t, d.bias_ms / 1000, WINDOW * stride) for d, each in times]
        weights = np.array(
            [0.0 if np.isnan(v) else 1 / d.deviation_ms**2 for v, (d, _) in zip(votes, times, strict=True)]
        )
        if weights.any():
            time = float(np.nansum(weights * votes) / weights.sum())
            spread = np.sqrt(np.nansum(weights * (np.array(votes) - time) ** 2) / weights.sum())
            found.append(FootEvent(side, strike, time, float(spread), "markers"))
    return found


def _near(times: Floats, t: float, bias: float, window: float) -> float:
    """The time nearest to t, without its bias; NaN where none is in the window."""
    if not len(times):
        return np.nan
    best = times[np.abs(times - bias - t).argmin()] - bias
    return float(best) if abs(best - t) < window else np.nan


def _calibrated(seen: Sequence[FootEvent], known: Sequence[FootEvent], strike: bool) -> list[FootEvent]:
    """Events of plates where there are, and of markers calibrated by (4) with the expected error (5)."""
    pairs = [(m, p) for p in known for m in seen if m.side == p.side and abs(m.time - p.time) < 0.1]
    off = np.array([m.time - p.time for m, p in pairs])
    n, ratio = len(off), (WITHIN_MS[strike] / BETWEEN_MS[strike]) ** 2
    shift = float(off.mean() * n / (n + ratio)) if n else 0.0
    between = BETWEEN_MS[strike] * np.sqrt(ratio / (n + ratio))
    floor = float(np.hypot(WITHIN_MS[strike], between)) / 1000
    used = {id(m) for m, _ in pairs}
    rest = [
        m._replace(time=m.time - shift, sd=COMMON * float(np.hypot(floor, m.sd / 2))) for m in seen if id(m) not in used
    ]
    return [*known, *rest]


def _foot(points: Mapping[str, Floats], side: Side, rate: float, up: Floats) -> Foot | None:
    """What the detectors look at; None where the foot is hardly seen."""
    letter = LETTER[side]
    pelvis = pelvis_of(points)[0]
    heel, toe, middle = (_smooth(xyz, rate) for xyz in (points[letter + "HEE"], points[letter + "TOE"], pelvis.origin))
    seen = np.isfinite(heel + toe + middle).all(1)
    if seen.sum() < 0.3 * rate:
        return None
    x = pelvis.R[..., 0]
    d = unit(_filled(x - (x @ up)[:, None] * up))
    heel_v, toe_v = _derivative(heel, rate), _derivative(toe, rate)
    turn = level_axes(up)
    swing = _speed((heel_v + toe_v) / 2)
    return Foot(
        np.arange(len(heel)) / rate,
        ((heel - middle) * d).sum(1),
        ((toe - middle) * d).sum(1),
        heel_v @ turn,
        toe_v @ turn,
        _derivative(heel_v, rate) @ turn,
        _derivative(toe_v, rate) @ turn,
        _derivative((heel_v + toe_v) / 2, rate) @ turn,
        float(np.nanmax(swing)),
    )


def _derivative(x: Floats, rate: float) -> Floats:
    """(F, 3) a second, by differences of neighbours."""
    return np.asarray(np.gradient(x, axis=0) * rate)


def _smooth(xyz: Floats, rate: float) -> Floats:
    """(F, 3) low-passed between its first and last sample, gaps bridged by lines; NaN outside."""
    filled = _filled(xyz)
    known = np.flatnonzero(np.isfinite(filled).all(1))
    if len(known) <= edge_samples(2):
        return np.full_like(filled, np.nan)
    a, b = known[0], known[-1] + 1
    filled[a:b] = butterworth(filled[a:b], rate=rate, cutoff_hz=min(CUTOFF_HZ, 0.4 * rate), order=2)
    return filled


def _filled(xyz: Floats) -> Floats:
    """(F, 3) with lines over gaps; NaN before the first and after the last sample."""
    out = xyz.copy()
    known = np.flatnonzero(np.isfinite(xyz).all(1))
    if len(known):
        inside = np.arange(known[0], known[-1] + 1)
        for k in range(3):
            out[inside, k] = np.interp(inside, known, xyz[known, k])
    return out


def _speed(v: Floats) -> Floats:
    return np.asarray(np.linalg.norm(v, axis=-1))


def _swings(y: Floats, time: Floats) -> Floats:
    """Times of the greatest values (1) between which y falls by a step."""
    found: list[int] = []
    for k in _peak_indices(y):
        if found and y[k] - np.nanmin(y[found[-1] : k + 1]) < LEAST_SWING_MM:
            if y[k] > y[found[-1]]:
                found[-1] = k
        else:
            found.append(k)
    falls = [k for k in found if y[k] - min(np.nanmin(y[: k + 1]), np.nanmin(y[k:])) >= LEAST_SWING_MM]
    return time[falls]


def _peak_indices(y: Floats) -> list[int]:
    with np.errstate(invalid="ignore"):
        return [int(k) for k in np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:])) + 1]


def peaks(y: Floats, time: Floats) -> Floats:
    """Times of the local greatest values of y (F), to a part of a frame by a parabola."""
    k = np.array(_peak_indices(y), np.int64)
    a, b, c = y[k - 1], y[k], y[k + 1]
    return time[k] + 0.5 * (a - c) / (a - 2 * b + c) * (time[1] - time[0]) if len(k) else np.zeros(0)


def crossings(y: Floats, time: Floats, level: float, *, upwards: bool) -> Floats:
    """Times at which y (F) crosses a level, to a part of a frame by a line."""
    s = y - level if upwards else level - y
    with np.errstate(invalid="ignore"):
        k = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
    return np.asarray(time[k] + s[k] / (s[k] - s[k + 1]) * (time[1] - time[0])) if len(k) else np.zeros(0)
