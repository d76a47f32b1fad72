"""Whether a trial is level walking, on which the errors of foot events from markers were measured.

In walking a foot leaves the floor while the other stands. Where it mostly leaves while the other one is in the air, the
subject runs (1). Where heels stand at other heights from one strike to the next, it is on stairs or a ramp (2). Markers
show offs of runners late, by which short flights are lost. But who walks goes over the leg that stands as over a stilt,
and who runs sinks into it as into a spring (Cavagna et al. 1977): with u from 0 to 1 between strikes, the pelvis is
highest where the first harmonic of its height is,

    u = −arg(Σ z exp(−2πi u)) / 2π                                                                          (3)

half-way in walks, about the strikes in runs. Who faces against the way walks backwards (`backwards`), in some parts
alone to and fro.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Literal

import numpy as np

from ..data.array_types import Floats
from ..data.strides import FootEvent
from ..data.subject_measures import LETTER, SIDES, Side
from .backwards import walked_parts
from .segments import Z_UP

PELVIS = ("LASI", "RASI", "SACR", "LPSI", "RPSI")
"""Markers whose mean height counts in (3); conventional."""
Way = Literal["level", "running", "stairs", "backward", "to and fro"]
RISE_MM = 40.0
"""From one strike to the next in the median, beyond which the floor is not level, mm; chosen: level walks had up to 23,
a stair has 150."""
SPRINGS = 0.25
"""Of a step, about its strikes, within which the pelvis of a runner is highest (3); chosen: in walks it was highest
0.28 from them at least, and a run on a stance of 0.35 of the stride has it 0.15 before them."""
SPRINGS_MM = 12.0
"""Of (3) at least, mm; chosen: who shuffles goes up and down by less, runners by 30 to 50."""
STEP_POINTS = 40
"""Of (3) in a step; chosen."""


def way_of_walking(events: Sequence[FootEvent], points: Mapping[str, Floats], *, rate: float) -> Way:
    """How the subject walks; "level" where too few events tell.

    Args:
        events: of both feet. points: (F, 3) mm by the model's names. rate: frames a second.
    """
    flights = [_flies(events, event) for event in events if not event.strike]
    known = [each for each in flights if each is not None]
    if known and 2 * sum(known) >= len(known):  # (1)
        return "running"
    heights = [_height(points[LETTER[e.side] + "HEE"] @ Z_UP, e.time * rate) for e in events if e.strike]
    rises = [abs(b - a) for a, b in pairwise(h for h in heights if np.isfinite(h))]
    if rises and float(np.median(rises)) > RISE_MM:  # (2)
        return "stairs"
    if _springs(events, points, rate):  # (3)
        return "running"
    behind = {part.backwards for part in walked_parts(points)} if known else {False}
    return "to and fro" if len(behind) > 1 else "backward" if True in behind else "level"


def _springs(events: Sequence[FootEvent], points: Mapping[str, Floats], rate: float) -> bool:
    """Whether the pelvis is highest about the strikes (3), in most of the steps."""
    markers = [points[name] @ Z_UP for name in PELVIS if name in points]
    strikes = sorted(event.time for event in events if event.strike)
    if not markers or len(strikes) < 2:
        return False
    z, u = np.mean(markers, axis=0), np.arange(STEP_POINTS) / STEP_POINTS
    found = []
    for a, b in pairwise(strikes):
        y = np.interp((a + u * (b - a)) * rate, np.arange(len(z)), z)
        y = y - u * (np.interp(b * rate, np.arange(len(z)), z) - y[0])  # as if the step ended as high as it began
        found.append(2 * np.mean(y * np.exp(-2j * np.pi * u)))
    at, size = -np.angle(found) / (2 * np.pi), np.abs(found)
    return bool(np.mean((np.abs(at) < SPRINGS) & (size > SPRINGS_MM)) > 0.5)


def faced_aside(x: Floats) -> Floats:
    """(F) deg between directions x (F, 3), z up, along the floor and their mean; NaN where they are unknown."""
    flat = x[:, :2] / np.linalg.norm(x[:, :2], axis=1, keepdims=True)
    mean = np.nanmean(flat, axis=0) if np.isfinite(flat).any() else np.full(2, np.nan)
    return np.asarray(np.degrees(np.abs(np.arctan2(flat[:, 0] * mean[1] - flat[:, 1] * mean[0], flat @ mean))))


def _flies(events: Sequence[FootEvent], off: FootEvent) -> bool | None:
    """Whether the other foot is in the air when this one leaves; None where its last event is not known."""
    other: Side = SIDES[1 - SIDES.index(off.side)]
    before = [e for e in events if e.side == other and e.time < off.time]
    return not before[-1].strike if before else None


def _height(z: Floats, frame: float) -> float:
    k = round(frame)
    return float(z[k]) if 0 <= k < len(z) else np.nan
