"""Straight parts of a subject's way: there, back, and before and after a corner.

At a moment the subject turns where the chords from where it was `WALKED_MM` away before, and to where it will be so far
away after, point apart (1), however long it stands or turns on the spot there. Between turns a part is
straight if it leaves the line between its ends by no more than a pelvis sways (2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats
from ..numerics.runs import true_runs
from .segments import unit

WALKED_MM = 800.0
"""Path of the pelvis below which its own x is the direction of progression, mm; conventional (Plug-in Gait)."""
BEND_MM = 100.0
"""By which a way leaves the line between its ends, from which on it bends, mm; chosen: a pelvis sways by up to 50."""
TURN_DEG = 20.0
"""Between the chords of (1) from which on the subject turns; chosen: sway of 50 mm turns them by 7, a circle of 2 m
radius by 23."""
STEP_S = 0.05
"""Between the moments at which (1) is asked, s; chosen: in it nobody walks farther than a tenth of `WALKED_MM`."""

AT_ONCE = 64
"""Moments of a stretch; chosen for speed: three seconds."""


class Pass(NamedTuple):
    """Frames first to stop − 1 of a straight part, and its direction (3)."""

    first: int
    stop: int
    direction: Floats


def straight_passes(at: Floats, *, rate: float) -> tuple[Pass, ...]:
    """The straight parts of a way, in the order of time, each `WALKED_MM` long at least.

    Args:
        at: (F, 3) mm on the floor, of the pelvis; NaN where it is not seen. rate: frames a second.
    """
    seen = np.flatnonzero(np.isfinite(at).all(-1))
    if not len(seen):
        return ()
    frames = np.arange(seen[0], seen[-1] + 1, max(round(STEP_S * rate), 1))
    way = np.stack([np.interp(frames, seen, x) for x in at[seen].T], -1)
    parts = [(way[a:b], frames[a], frames[b - 1]) for a, b in true_runs(~_turns(way))]
    return tuple(Pass(int(first), int(last) + 1, unit(x[-1] - x[0])) for x, first, last in parts if _straight(x))


def _turns(way: Floats) -> Bools:
    """(N) of moments (1); none where either chord is not in the recording."""
    before, after = _first_away(way[::-1])[::-1], _first_away(way)
    out = np.zeros(len(way), bool)
    for k in np.flatnonzero(np.isfinite(before).all(1) & np.isfinite(after).all(1)):
        out[k] = unit(way[k] - before[k]) @ unit(after[k] - way[k]) < np.cos(np.radians(TURN_DEG))
    return out


def _first_away(way: Floats) -> Floats:
    """(N, 3) from each of places (N, 3) the first one after it that is `WALKED_MM` away; NaN where there is none.

    Places are looked at in stretches, of which those are left out whose box is nowhere so far away: somebody who stands
    for minutes is near each of them.
    """
    starts = np.arange(0, len(way), AT_ONCE)
    low, high = np.minimum.reduceat(way, starts), np.maximum.reduceat(way, starts)
    out = np.full(way.shape, np.nan)
    for k, here in enumerate(way):
        own = k // AT_ONCE
        reach = np.linalg.norm(np.maximum(here - low[own:], high[own:] - here), axis=1)
        for start in starts[own + np.flatnonzero(reach >= WALKED_MM)]:
            some = way[max(start, k + 1) : start + AT_ONCE]
            far = np.linalg.norm(some - here, axis=1) >= WALKED_MM
            if far.any():
                out[k] = some[far.argmax()]
                break
    return out


def _straight(x: Floats) -> bool:
    """(2) of places (n, 3)."""
    offset, line = x - x[0], x[-1] - x[0]
    if np.linalg.norm(line) < WALKED_MM:
        return False
    d = unit(line)
    return bool(np.linalg.norm(offset - np.outer(offset @ d, d), axis=1).max() <= BEND_MM)
