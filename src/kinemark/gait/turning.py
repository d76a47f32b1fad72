"""Strides in which the subject turns, and which way it walks in the others.

From one foot strike to the next of the same foot the pelvis comes back to the same place of its swing, so that a
stride has turned by what it faces otherwise at its end (1). Lengths and widths of strides that turn, and angles to the
way in them, are not those of straight walking: they are left out of means and curves where there are others (2).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ..data.array_types import Floats, Ints
from ..data.strides import Stride
from ..data.subject_measures import Side

TURNS_DEG = 15.0
"""Of (1) from which on a stride turns, deg; chosen: 26 strides of straight walks of nine subjects turned by up to 7,
those in the middle of five walks round a corner by 32 to 84."""
WAY_DEG = 60.0
"""Between strides from which on they go another way, deg; chosen: between the ways of a room, and more than any curve
that is no turn."""


def with_facing(strides: Sequence[Stride], x: Floats, *, rate: float, back: Ints | None = None) -> tuple[Stride, ...]:
    """The strides with where the pelvis faces in them, and how far it turns, or the way does.

    Args:
        strides: of a trial. x: (F, 3) forward axis of the pelvis, z up; NaN where it is not known.
        rate: frames a second. back: in which the way turns from forwards to backwards or the reverse: by half a turn.
    """
    known = np.flatnonzero(np.isfinite(x).all(-1))
    if len(known) < 2:
        return tuple(strides)
    angle = np.unwrap(np.arctan2(x[known, 1], x[known, 0]))
    out = []
    for one in strides:
        time = np.linspace(one.first, one.last, 21)
        deg = np.degrees(np.interp(time * rate, known, angle))
        turns = back is not None and bool(np.any((back > time[0] * rate) & (back < time[-1] * rate)))
        out.append(
            one._replace(turned_deg=180.0 if turns else float(deg[-1] - deg[0]), facing_deg=_wrapped(float(deg.mean())))
        )
    return tuple(out)


def with_counts(trials: Sequence[Sequence[Stride]]) -> list[tuple[Stride, ...]]:
    """The strides of all trials, told by (2) whether they count: of a side without straight ones all do in which the
    subject does not stand."""
    walked = [one for strides in trials for one in strides if not one.stands]
    straight = {one.side for one in walked if abs(one.turned_deg) <= TURNS_DEG}
    return [tuple(one._replace(counts=_counts(one, straight)) for one in strides) for strides in trials]


def _counts(one: Stride, straight: Collection[Side]) -> bool:
    """By (2), with the sides that have straight strides."""
    return not one.stands and (one.side not in straight or abs(one.turned_deg) <= TURNS_DEG)


def ways(strides: Sequence[Stride]) -> list[list[Stride]]:
    """Strides by the way they go, in the order of the first of each; those of unknown facing stand at the end of
    the first way."""
    found: list[list[Stride]] = []
    for one in sorted(strides, key=lambda one: bool(np.isnan(one.facing_deg))):
        difference = [abs(_wrapped(one.facing_deg - other[0].facing_deg)) for other in found]
        near = [k for k, deg in enumerate(difference) if not deg > WAY_DEG]
        if near:
            found[min(near, key=lambda k: difference[k])].append(one)
        else:
            found.append([one])
    return found


def _wrapped(deg: float) -> float:
    """Within half a turn."""
    return (deg + 180.0) % 360.0 - 180.0
