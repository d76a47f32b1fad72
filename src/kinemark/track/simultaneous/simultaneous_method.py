"""Parameters of tracking and matching at once."""

from __future__ import annotations

from dataclasses import dataclass

from ...data.method import Method, parameter


@dataclass(frozen=True, slots=True)
class Simultaneous(Method):
    """Matching and tracking at once: tracks predicted in space are associated with the detections of all cameras.

    No parameter is a distance in space: those follow from the cameras and the rate.
    """

    gate: float = parameter(
        5.0, unit="standard deviations", above=0,
        meaning="gate: farthest that an image may lie from where a track is expected",
    )  # fmt: skip
    wander: float = parameter(
        40_000.0, unit="mm/s² per √s", above=0,
        meaning="process noise: how fast the acceleration of a marker changes; q of the motion model",
    )  # fmt: skip
    speed: float = parameter(
        1500.0, unit="mm/s", above=0, meaning="usual speed of a marker of which no motion is known"
    )
    acceleration: float = parameter(15_000.0, unit="mm/s²", above=0, meaning="usual acceleration of such a marker")
    patience: float = parameter(
        0.12, unit="s", above=0, meaning="coasting: how long a track goes on that fewer than two cameras see"
    )
    every: float = parameter(0.05, unit="s", above=0, meaning="how often new tracks are initiated")
    shortest: float = parameter(0.06, unit="s", above=0, meaning="least duration of a track, and at least four points")
    gap: float = parameter(1.0, unit="s", above=0, meaning="longest gap over which fragments are stitched")
    worst: float = parameter(
        10.0, unit="mm", above=0,
        meaning="standard deviation beyond which a point is not given; a fifth of it where no two cameras have an "
        "image of it alone",
    )  # fmt: skip


DEFAULT = Simultaneous()
