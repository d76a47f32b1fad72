"""Events of the cycle: when they were, and how long from one to the next (recommended by Swamidas 1997, 5.2).

An event is a percent of the cycle; the phase of each frame (`signal.phase`) says when the motion passes it, between
frames too. The
model itself offers some: where a component angle of a segment is greatest and least. Others can be placed by
whoever knows the motion: the percent of one foot strike, seen once, finds all others.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....data import AngleModel, Events
from ....data.array_types import Floats
from ....signal.phase import CyclePhase

FLAT = 2.0
"""Degrees that an angle must range over for its extremes to be events; chosen (see studies/missing_markers.py)."""


def model_events(model: AngleModel) -> dict[str, float]:
    """Percent of the cycle at which each component angle is greatest and least, as "hip-knee x greatest"; refined by
    a parabola."""
    found = {}
    steps = model.direction.shape[1]
    for (a, b), angles in zip(model.links, model.angles, strict=True):
        for axis, curve in zip("xyz", angles.T, strict=True):
            if np.ptp(curve) < FLAT:
                continue
            for word, sign in (("greatest", 1.0), ("least", -1.0)):
                k = int((sign * curve).argmax())
                left, here, right = curve[k - 1], curve[k], curve[(k + 1) % steps]
                bend = left - 2 * here + right
                shift = 0.5 * (left - right) / bend if abs(bend) > 1e-12 else 0.0
                found[f"{model.names[a]}-{model.names[b]} {axis} {word}"] = 100 * ((k + shift) / steps % 1.0)
    return found


def cycle_events(phase: CyclePhase, percents: Mapping[str, float], *, rate: float) -> Events:
    """When the motion passes each percent of its cycle, in the order of time.

    Args:
        phase: of each frame.
        percents: label → percent of the cycle.
        rate: Hz.
    """
    times = [(t / rate, label) for label, percent in percents.items() for t in phase.frames_at(percent)]
    times.sort()
    labels = tuple(label for _, label in times)
    return Events(labels, ("General",) * len(labels), np.array([t for t, _ in times], np.float64))


def intervals(events: Events, first: str, then: str) -> Floats:
    """(N) s from each event `first` to the next one `then`; with the same label twice, the lengths of the cycles."""
    starts = events.time[[label == first for label in events.label]]
    ends = events.time[[label == then for label in events.label]]
    place = np.searchsorted(ends, starts, side="right")
    use = place < len(ends)
    return np.asarray(ends[place[use]] - starts[use])
