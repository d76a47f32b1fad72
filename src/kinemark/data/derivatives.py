"""Velocities and accelerations of markers."""

from __future__ import annotations

from dataclasses import dataclass

from .array_types import Floats
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class MarkerDerivatives(ShortRepr):
    """Of M markers in F frames; NaN where a marker has no position, or too few.

    Attributes:
        names: (M) of the markers.
        rate: frames a second, Hz.
        velocity: (M, F, 3) mm/s; velocity_sd: (M, F) mm/s of each component.
        acceleration: (M, F, 3) mm/s²; acceleration_sd: (M, F) mm/s² of each component.
        noise_sd: (M) σ mm, the noise of a position along an axis that the paths themselves show.
    """

    names: tuple[str, ...]
    rate: float
    velocity: Floats
    velocity_sd: Floats
    acceleration: Floats
    acceleration_sd: Floats
    noise_sd: Floats
