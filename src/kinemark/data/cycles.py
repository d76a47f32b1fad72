"""Cycles of a motion on one scale of 0 to 100 %."""

from __future__ import annotations

from typing import NamedTuple

from .array_types import Floats


class Cycles(NamedTuple):
    """The angles of J joints over N cycles.

    Attributes:
        deg: (N, J, 101, 3) deg; sd: (N, J, 101, 3) deg, propagated from the markers.
        mean: (J, 101, 3) deg over the cycles; spread: (J, 101, 3) deg, standard deviation of a cycle, NaN with one
            alone; noise: (J, 101, 3) deg, standard deviation of the mean by the measurement.
        spans: (N, 2) s where each begins and ends.
    """

    deg: Floats
    sd: Floats
    mean: Floats
    spread: Floats
    noise: Floats
    spans: Floats
