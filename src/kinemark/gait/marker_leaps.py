"""Markers that leap: what no body does, for a track went over to another marker, or was patched.

The acceleration of a marker by three frames is a = |x₊ − 2x + x₋| f². In walks it stayed below 65 m/s²;
where a track leaps it is thousands, and moments follow it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..data.array_types import Floats

LEAST_M_S2 = 200.0
"""Acceleration of a leap, m/s²; chosen: in 15 public walks and turns none exceeded 65."""
LEAST_MM = 10.0
"""Second difference of a leap, mm; chosen: noise of a millimetre at 1000 frames a second is none."""


class MarkerLeaps(NamedTuple):
    """Leaps of a trial.

    Attributes:
        markers: that leap, the widest first. frames: in which one does. most_mm: the greatest second difference.
    """

    markers: tuple[str, ...] = ()
    frames: int = 0
    most_mm: float = 0.0


def leap_mm(rate: float) -> float:
    """Second difference of a leap, mm, at so many frames a second."""
    return max(LEAST_MM, LEAST_M_S2 * 1000.0 / rate**2)


def marker_leaps(points: Mapping[str, Floats], names: tuple[str, ...], *, rate: float) -> MarkerLeaps:
    """Leaps of the markers of these names that are there.

    Args:
        points: (F, 3) mm by name, not smoothed. names: that count. rate: frames a second.
    """
    limit = leap_mm(rate)
    leap = {n: np.linalg.norm(np.diff(points[n], 2, axis=0), axis=1) for n in names if n in points}
    most = {n: float(y.max(initial=0.0, where=y > limit)) for n, y in leap.items()}
    leaping = sorted((n for n in most if most[n] > 0), key=lambda n: -most[n])
    if not leaping:
        return MarkerLeaps()
    frames = np.any([leap[n] > limit for n in leaping], axis=0)
    return MarkerLeaps(tuple(leaping), int(frames.sum()), most[leaping[0]])
