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
"""Moments that are looked at first, and twice as many each time after; chosen for speed: three seconds."""


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
    out = np.zeros(len(way), bool)
    for k, here in enumerate(way):
        before, after = _first_away(way[:k][::-1], here), _first_away(way[k + 1 :], here)
        if before is not None and after is not None:
            out[k] = unit(here - before) @ unit(after - here) < np.cos(np.radians(TURN_DEG))
    return out


def _first_away(way: Floats, here: Floats) -> Floats | None:
    """(3) the first of places (n, 3) that is `WALKED_MM` away; soon, mostly, so that few are looked at at once."""
    first, many = 0, AT_ONCE
    while first < len(way):
        far = np.linalg.norm(way[first : first + many] - here, axis=1) >= WALKED_MM
        if far.any():
            return np.asarray(way[first + int(far.argmax())])
        first, many = first + many, 2 * many
    return None


def _straight(x: Floats) -> bool:
    """(2) of places (n, 3)."""
    off, line = x - x[0], x[-1] - x[0]
    if np.linalg.norm(line) < WALKED_MM:
        return False
    d = unit(line)
    return bool(np.linalg.norm(off - np.outer(off @ d, d), axis=1).max() <= BEND_MM)
