"""Foot strikes and foot offs, from plates where they speak and from markers elsewhere, each with its expected error.

With p the pelvis, h the heel, q the toe, m their middle, forwards d the pelvis' own direction on the floor, markers
low-passed at 15 Hz, and z upwards, an event is first looked for where

    strike: (h − p) · d is greatest,   off: (q − p) · d is least (Zeni et al. 2008)                          (1)

which holds on a treadmill too. Within an eighth of a stride of it each of these detectors gives a time t_i, with d the
direction of walking, φ the pitch of the foot, heel up, and v the speed at which a standing toe goes back under p:

    strike:  toe is braked, max |q̈|;  heel begins to stop, max jerk of h · d;
             foot turns down: max φ̇ before it, min jerk of φ                                                 (2)
    off:     foot turns fastest, max φ̇;  toe has been pulled up, min jerk of q_z;
             toe goes back under the pelvis by less than 0.8 v                                                (3)

Their mean biases b_i against force plates are known from other subjects. The time is the median of t_i − b_i. Where
plates give n events of the same kind in the trial, the mean difference from them is taken off, shrunk as n / (n + ν)
with ν = (deviation within a subject / between subjects)² (4). The expected error is made of both deviations, or half of
how far the detectors are apart where that is more (5).

Events that contradict each other are not kept together (`event_order`).

Sources: Zeni et al. 2008; Hreljac and Marshall 2000 (accelerations and jerks of heel and toe); O’Connor et al. 2007
(velocity of the foot).
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
from .segments import Z_UP, unit

CUTOFF_HZ = 15.0
"""Of the markers; chosen: between 10 and 30 Hz errors against plates were the same."""
WINDOW = 0.125
"""Share of a stride about (1) in which detectors look; chosen: (1) is within 60 ms of the event."""
LEAST_SWING_MM = 100.0
"""By which a foot moves to and fro under the pelvis in a step, mm; chosen: less is no step."""
PLATE_N = 20.0
"""Vertical force of contact, N (Zeni et al. 2008)."""
BETWEEN_MS = {True: 4.5, False: 8.0}
"""Deviation of the mean of the detectors between subjects, ms, of strikes and offs; measured on 25 strides of 9
subjects on plates (docs/theory/gait.md), each subject judged by the biases of the others."""
WITHIN_MS = {True: 6.0, False: 7.0}
"""Deviation within a subject, ms; measured on the same strides."""


class Detector(NamedTuple):
    """A detector: its time s in frames of a foot, NaN where there is none; bias against plates, ms."""

    time: Callable[[Foot, slice], float]
    bias_ms: float


class Foot(NamedTuple):
    """Motion of one foot over frames (F), mm and rad, s.

    Attributes:
        time: s. heel_ahead, toe_ahead: before the pelvis as it faces.
        toe_a: size of the toe's acceleration. heel_jerk, toe_jerk: of the heel forwards, of the toe upwards.
        turning, turning_jerk: first and third derivative of the pitch.
        toe_back: speed of the toe forwards from the pelvis. v: at which it goes back while it stands.
    """

    time: Floats
    heel_ahead: Floats
    toe_ahead: Floats
    toe_a: Floats
    heel_jerk: Floats
    toe_jerk: Floats
    turning: Floats
    turning_jerk: Floats
    toe_back: Floats
    v: float


STRIKE = (
    Detector(lambda f, near: greatest(f.toe_a, f.time, near), -65.0),
    Detector(lambda f, near: greatest(f.heel_jerk, f.time, near), -14.0),
    Detector(lambda f, near: greatest(f.turning, f.time, near), 7.0),
    Detector(lambda f, near: greatest(-f.turning_jerk, f.time, near), 0.0),
)
"""(2), with biases in ms; measured on 19 strikes of 6 subjects on plates (docs/theory/gait.md)."""
OFF = (
    Detector(lambda f, near: greatest(f.turning, f.time, near), -32.0),
    Detector(lambda f, near: greatest(-f.toe_jerk, f.time, near), 32.0),
    Detector(lambda f, near: _first(crossings(f.toe_back[near], f.time[near], -0.8 * f.v, upwards=True)), -33.0),
)
"""(3), with biases in ms; measured on 20 offs of the same subjects."""
STANDING_SHARE = 10.0
"""Percentile of the toe's speed under the pelvis that is −v; chosen: a foot stands for a third of the time or more."""


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
    found = []
    for t in rough:
        near = slice(max(round((t - WINDOW * stride) * rate), 0), round((t + WINDOW * stride) * rate) + 1)
        votes = np.array([d.time(foot, near) - d.bias_ms / 1000 for d in detectors])
        votes = votes[np.isfinite(votes)]
        if len(votes):
            time = float(np.median(votes))
            found.append(FootEvent(side, strike, time, float(np.abs(votes - time).mean()), "markers"))
    return found


def greatest(y: Floats, time: Floats, near: slice) -> float:
    """Time of the greatest value of y (F) in some frames, to a part of a frame by a parabola; NaN at their ends."""
    if not np.isfinite(y[near]).any():
        return np.nan
    k = int(np.nanargmax(y[near])) + near.start
    if not 0 < k < len(y) - 1:
        return np.nan
    a, b, c = y[k - 1], y[k], y[k + 1]
    return float(time[k] + 0.5 * (a - c) / (a - 2 * b + c) * (time[1] - time[0])) if a + c < 2 * b else np.nan


def _first(times: Floats) -> float:
    return float(times[0]) if len(times) else np.nan


def _calibrated(seen: Sequence[FootEvent], known: Sequence[FootEvent], strike: bool) -> list[FootEvent]:
    """Events of plates where there are, and of markers calibrated by (4) with the expected error (5)."""
    pairs = [(m, p) for p in known for m in seen if m.side == p.side and abs(m.time - p.time) < 0.1]
    off = np.array([m.time - p.time for m, p in pairs])
    n, ratio = len(off), (WITHIN_MS[strike] / BETWEEN_MS[strike]) ** 2
    shift = float(off.mean() * n / (n + ratio)) if n else 0.0
    between = BETWEEN_MS[strike] * np.sqrt(ratio / (n + ratio))
    floor = float(np.hypot(WITHIN_MS[strike], between)) / 1000
    used = {id(m) for m, _ in pairs}
    rest = [m._replace(time=m.time - shift, sd=max(floor, m.sd / 2)) for m in seen if id(m) not in used]
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
    ahead, sole = ((toe - middle) * d).sum(1), heel - toe
    pitch = np.arctan2(sole @ up, -(sole * d).sum(1))
    toe_a, back = _derivative(toe, rate, 2), _derivative(ahead, rate)
    return Foot(
        time=np.arange(len(heel)) / rate,
        heel_ahead=((heel - middle) * d).sum(1),
        toe_ahead=ahead,
        toe_a=np.linalg.norm(toe_a, axis=1),
        heel_jerk=(_derivative(heel, rate, 3) * d).sum(1),
        toe_jerk=_derivative(toe_a @ up, rate),
        turning=_derivative(pitch, rate),
        turning_jerk=_derivative(pitch, rate, 3),
        toe_back=back,
        v=-float(np.nanpercentile(back, STANDING_SHARE)),
    )


def _derivative(x: Floats, rate: float, times: int = 1) -> Floats:
    """(F, …) a second, by differences of neighbours, so many times."""
    for _ in range(times):
        x = np.gradient(x, axis=0) * rate
    return x


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


def crossings(y: Floats, time: Floats, level: float, *, upwards: bool) -> Floats:
    """Times at which y (F) crosses a level, to a part of a frame by a line."""
    s = y - level if upwards else level - y
    with np.errstate(invalid="ignore"):
        k = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
    return np.asarray(time[k] + s[k] / (s[k] - s[k + 1]) * (time[1] - time[0])) if len(k) else np.zeros(0)
