"""Foot strikes and foot offs, from plates where they speak and from markers elsewhere, each with its expected error.

The detectors of `foot_detectors` give times t_i with mean biases against force plates that are known from other
subjects,

    b_i = a_i + c_i λ                                                                                       (1)

and the event is the mean of the middle half of t_i − b_i (2). Where plates give n events of the same kind in the trial,
the mean difference from them is taken off, shrunk as n / (n + ν) with ν = (deviation within a subject / between
subjects)² (3). The expected error is made of both deviations, or is half of how far the detectors are apart where that
is more (4).

Who walks backwards (`backwards`), in a part or throughout, has the events of a walk with time turned: a strike is an
off there. Events that contradict each other are not kept together (`event_order`), and where the subject does not walk
forwards on a level floor (`way_of_walking`) those from markers are known worse. Of a runner, whose swing is the
fastest, shares of it come late: an off is there when the tip of the foot goes faster than 0.6 m/s, whatever the others
say (5).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..data import Trial
from ..data.array_types import Floats
from ..data.strides import FootEvent
from .backwards import walked_parts
from .event_order import ordered
from .foot_detectors import OFF, STRIKE, voted
from .plate_events import plate_events
from .way_of_walking import way_of_walking

BETWEEN_MS = {True: 3.7, False: 3.7}
"""Deviation of the mean of the detectors between subjects, ms, of strikes and offs; measured on 10 subjects
(studies/gait_events.py), each subject judged by the biases of the others."""
WITHIN_MS = {True: 4.6, False: 6.6}
"""Deviation within a subject, ms; measured on the same strides."""
UNLIKE_MS = 30.0
"""Deviation where the subject runs or climbs, ms; chosen: on stairs strikes were off by 18 and offs by 25 (RMS,
studies/gait_events.py), and of runs no plates are at hand."""
TIP = 0
"""Which of `OFF` is the detector of (5); by definition."""
ALIKE_S = 0.1
"""Within which an event from markers and one from a plate are one, s; chosen: a fifth of a step."""


def foot_events(trial: Trial, points: Mapping[str, Floats]) -> tuple[FootEvent, ...]:
    """All foot strikes and offs of a trial, in the order of time.

    Args:
        trial: with its plates and channels. points: (F, 3) mm of its markers by name.
    """
    measured, rate = plate_events(trial, points), trial.trajectories.rate
    kept = _together(marker_events(points, rate), measured)
    way = way_of_walking(kept, points, rate=rate)
    if way == "level":
        return kept
    if way == "running":
        kept = _together(marker_events(points, rate, runs=True), measured)
    return tuple(e if e.source == "plate" else e._replace(sd=max(e.sd, UNLIKE_MS / 1000)) for e in kept)


def _together(seen: Sequence[FootEvent], measured: Sequence[FootEvent]) -> tuple[FootEvent, ...]:
    """Events from markers and from plates, of both kinds, that can have been."""
    found: list[FootEvent] = []
    for strike in (True, False):
        own, plates = ([e for e in each if e.strike == strike] for each in (seen, measured))
        found += _calibrated(own, plates, strike)
    return ordered(found)


def marker_events(points: Mapping[str, Floats], rate: float, *, runs: bool = False) -> list[FootEvent]:
    """Events by (2), of all plates unaware; their `sd` is half of how far the detectors are apart.

    Where the subject walks backwards they are found with time turned.

    Args:
        points: (F, 3) mm by the model's names. rate: frames a second. runs: offs by (5).
    """
    found: list[FootEvent] = []
    for first, stop, backwards in walked_parts(points):
        part = {name: xyz[first:stop] for name, xyz in points.items()}
        if backwards:
            turned = _forward_events({name: xyz[::-1] for name, xyz in part.items()}, rate, runs)
            found += [e._replace(time=(stop - 1) / rate - e.time, strike=not e.strike) for e in turned]
        else:
            found += [e._replace(time=first / rate + e.time) for e in _forward_events(part, rate, runs)]
    return found


def _forward_events(points: Mapping[str, Floats], rate: float, runs: bool) -> list[FootEvent]:
    """Events by (2) of who walks forwards, or by (5), points (F, 3) mm by the model's names."""
    found = []
    for one in voted(points, rate):
        biases = np.array([d.bias_ms + d.slow_ms * one.slow for d in (STRIKE if one.event.strike else OFF)])
        votes = one.times - biases / 1000
        if runs and not one.event.strike and np.isfinite(one.times[TIP]):
            votes = one.times[TIP : TIP + 1]  # (5)
        time = middle_half(votes)
        if np.isfinite(time):
            apart = float(np.nanmean(np.abs(votes - time))) / 2
            found.append(one.event._replace(time=time, sd=float(np.hypot(apart, one.event.sd))))
    return found


def middle_half(votes: Floats) -> float:
    """Mean of the middle half of those that are there; NaN where none is."""
    votes = np.sort(votes[np.isfinite(votes)])
    k = len(votes) // 4
    return float(votes[k : len(votes) - k].mean()) if len(votes) else np.nan


def _calibrated(seen: Sequence[FootEvent], known: Sequence[FootEvent], strike: bool) -> list[FootEvent]:
    """Events of plates where there are, and of markers calibrated by (3) with the expected error (4)."""
    pairs = [(m, p) for p in known for m in seen if m.side == p.side and abs(m.time - p.time) < ALIKE_S]
    within, ratio = WITHIN_MS[strike] / 1000, (WITHIN_MS[strike] / BETWEEN_MS[strike]) ** 2
    weight = np.array([1 / (1 + (p.sd / within) ** 2) for _, p in pairs])  # a plate that hardly knows teaches little
    n = float(weight.sum())
    shift = float(weight @ [m.time - p.time for m, p in pairs]) / (n + ratio)
    between = BETWEEN_MS[strike] * np.sqrt(ratio / (n + ratio))
    floor = float(np.hypot(within, between / 1000))
    used = {id(m) for m, _ in pairs}
    rest = [m._replace(time=m.time - shift, sd=max(floor, m.sd)) for m in seen if id(m) not in used]
    return [*known, *rest]
