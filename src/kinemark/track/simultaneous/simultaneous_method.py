"""Parameters of tracking and matching at once."""

from __future__ import annotations

from dataclasses import dataclass

from ...data.arrays import check_positive


@dataclass(frozen=True, slots=True)
class Simultaneous:
    """Parameters of the method. None is a distance in space: those follow from the cameras and the rate.

    Attributes:
        gate: farthest that an image may lie from where a track is expected, standard deviations.
        wander: how fast the acceleration of a marker changes, mm/s² in √s; q of `motion`.
        speed: usual speed of a marker of which no motion is known, mm/s.
        acceleration: usual acceleration of such a one, mm/s².
        patience: how long a track goes on that fewer than two cameras see, s.
        every: how often new tracks are looked for, s.
        shortest: least duration of a track, s, and at least four points.
        gap: longest gap over which tracks are joined, s.
        worst: standard deviation beyond which a point is not given, mm; a fifth of it where no two cameras have an
            image of it alone.
    """

    gate: float = 5.0
    wander: float = 40_000.0
    speed: float = 1500.0
    acceleration: float = 15_000.0
    patience: float = 0.12
    every: float = 0.05
    shortest: float = 0.06
    gap: float = 1.0
    worst: float = 10.0

    def __post_init__(self) -> None:
        check_positive(
            gate=self.gate,
            wander=self.wander,
            speed=self.speed,
            acceleration=self.acceleration,
            patience=self.patience,
            every=self.every,
            shortest=self.shortest,
            gap=self.gap,
            worst=self.worst,
        )


DEFAULT = Simultaneous()
