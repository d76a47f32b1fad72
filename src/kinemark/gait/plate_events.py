"""Foot strikes and foot offs as force plates have them, to a sample of their channels.

A foot is on the plate while the vertical force is above 20 N. Between the samples k − 1 and k of a crossing the force
goes along a line,

    t = t_k − (F_k − 20) / (F_k − F_{k−1}) Δt                                                              (1)

Some systems write 0 below a threshold of their own, as 50 N. Then the force leaps, and goes on along the slope s that
it has beyond the leap,

    t = t_k − (F_k − 20) / s,   with half of what was added as its standard uncertainty                     (2)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import Trial
from ..data.array_types import Floats
from ..data.strides import FootEvent
from .plate_contacts import Contact, contacts, steps_of
from .reaction import reaction
from .segments import Z_UP

PLATE_N = 20.0
"""Vertical force of contact, N (Zeni et al. 2008)."""
SLOPE_S = 0.010
"""Over which the slope of (2) is taken, s; chosen: force rises and falls for 50 to 150 ms."""
LONGEST_S = 0.05
"""By which (2) moves an event at most, s; chosen: between 20 and 50 N it took 5 to 30 ms."""
NEAR_S = 0.025
"""Within which the force doubles or the slope is taken to be so slow, s; chosen."""


class _Force(NamedTuple):
    """Vertical force (N) of one plate, N, its samples a second and the s of the first one."""

    newton: Floats
    rate: float
    start: float


def plate_events(trial: Trial, points: Mapping[str, Floats]) -> tuple[FootEvent, ...]:
    """Events of feet that stood whole and alone on a plate.

    Args:
        trial: with its plates and channels. points: (F, 3) mm of its markers by name.
    """
    rate, n = trial.trajectories.rate, trial.trajectories.n_frames
    at_frames = [
        reaction(p, trial.analog, n_frames=n, rate=rate, threshold_n=PLATE_N, zeroed=True) for p in trial.plates
    ]
    found: list[FootEvent] = []
    for step in steps_of(contacts(at_frames, points, rate=rate), rate):
        each = [contact_events(trial, one) for one in step]
        strikes, offs = ([e for own in each for e in own if e.strike == strike] for strike in (True, False))
        found += [min(strikes, key=lambda e: e.time), max(offs, key=lambda e: e.time)] if strikes else []
    return tuple(sorted(found, key=lambda e: e.time))


def contact_events(trial: Trial, contact: Contact) -> list[FootEvent]:
    """Strike and off of one contact at the rate of its channels; none of a load whose foot is not known.

    Args:
        trial: with its plates and channels. contact: of a foot with one of them.
    """
    force, rate = _force(trial, contact.plate), trial.trajectories.rate
    first, stop = (round((f / rate - force.start) * force.rate) for f in (contact.first - 2, contact.stop + 2))
    window = slice(max(first, 0), max(stop, 0))
    on = np.flatnonzero(force.newton[window] > PLATE_N) + window.start
    if not len(on) or contact.side is None:
        return []
    ends = [(True, _crossing(force, int(on[0]), -1)), (False, _crossing(force, int(on[-1]), 1))]
    return [FootEvent(contact.side, strike, time, sd, "plate") for strike, (time, sd) in ends]


def _force(trial: Trial, plate: int) -> _Force:
    """Of one plate, at every sample."""
    own = trial.plates[plate]
    record = next(a for a in trial.analog if own.channels[0] in a.names)
    if own.zero_frames is not None:  # its first and last one as samples of the record
        ends = np.add(own.zero_frames, (0, 1)) / trial.trajectories.rate - record.start
        own = replace(own, zero_frames=np.subtract(ends * record.rate, (0, 1)))
    fine = reaction(
        own, [replace(record, start=0.0)], n_frames=record.values.shape[1], rate=record.rate, threshold_n=0.0,
        averaged=False, zeroed=True,
    )  # fmt: skip
    return _Force(np.abs(fine.force @ Z_UP), record.rate, record.start)


def _crossing(force: _Force, k: int, outwards: int) -> tuple[float, float]:
    """s of the crossing (1) or (2) beside the loaded sample k, before it (-1) or after it (1), and its uncertainty."""
    newton, time = force.newton, k / force.rate + force.start
    beyond = k + outwards
    if not 0 <= beyond < len(newton):
        return time, 0.5 / force.rate
    if np.isnan(newton[beyond]):  # somewhere in what is lost
        lost = np.isnan(newton[beyond::outwards])
        n = int(lost.argmin()) or len(lost)
        return time + outwards * n / 2 / force.rate, n / 2 / force.rate
    excess = newton[k] - PLATE_N
    inside = newton[k - outwards * max(1, round(SLOPE_S * force.rate)) :: outwards]
    slope = (inside[0] - newton[k]) / SLOPE_S if len(inside) else np.inf
    leap = excess / slope if slope > 0 else LONGEST_S
    if newton[beyond] == 0 and leap > 1.5 / force.rate and newton[k] > 1.5 * PLATE_N:
        leap = min(leap, LONGEST_S)
        return time + outwards * leap, max(0.5 / force.rate, leap / 2)  # (2)
    share = excess / (newton[k] - newton[beyond]) if newton[k] > newton[beyond] else 0.0
    return time + outwards * share / force.rate, _slope_sd(force, k)  # (1)


def _slope_sd(force: _Force, k: int) -> float:
    """s: half a sample, or half of what the force takes to double."""
    near = round(NEAR_S * force.rate) * 2
    start = max(k - near, 0)
    at = np.flatnonzero(force.newton[start : k + near] > 2 * PLATE_N) + start
    return float(max(0.5, np.abs(at - k).min() / 2 if len(at) else 0.5) / force.rate)
