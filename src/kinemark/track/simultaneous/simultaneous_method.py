"""Parameters of tracking and matching at once."""

from __future__ import annotations

from dataclasses import dataclass

from ...data.method import Method, parameter


@dataclass(frozen=True, slots=True)
class Simultaneous(Method):
    """Matching and tracking at once: tracks predicted in space are associated with the detections of all cameras.

    Distances in space follow from the cameras and the rate.
    """

    gate: float = parameter(
        5.0, unit="standard deviations", above=0,
        meaning="largest distance of an image from where a track is predicted, at which it may be associated",
    )  # fmt: skip
    process_noise: float = parameter(
        40_000.0, former="wander", unit="mm/s² per √s", above=0,
        meaning="process noise: how fast the acceleration of a marker changes; q of the motion model",
    )  # fmt: skip
    velocity_sd: float = parameter(
        1500.0,
        former="speed",
        unit="mm/s",
        above=0,
        meaning="standard deviation of each component of the velocity of a new track",
    )
    acceleration_sd: float = parameter(
        15_000.0,
        former="acceleration",
        unit="mm/s²",
        above=0,
        meaning="standard deviation of each component of its acceleration",
    )
    max_coasting: float = parameter(
        0.12,
        former="patience",
        unit="s",
        above=0,
        meaning="coasting: how long a track goes on that fewer than two cameras see",
    )
    initiation_interval: float = parameter(
        0.05, former="every", unit="s", above=0, meaning="how often new tracks are initiated"
    )
    min_duration: float = parameter(
        0.06,
        former="shortest",
        unit="s",
        above=0,
        meaning="least duration of a track, and at least four points, or that of a shorter recording",
    )
    max_gap: float = parameter(
        1.0, former="gap", unit="s", above=0, meaning="longest gap over which fragments are stitched"
    )
    uncertain_sd: float = parameter(
        10.0, unit="mm", above=0,
        meaning="standard deviation beyond which a position is uncertain: such points are counted in the findings, "
        "and a track whose position is more uncertain goes on only with evidence; a fifth of it is the most for a "
        "point that no two cameras have an image of alone",
    )  # fmt: skip
    max_sd: float = parameter(
        100.0, former="worst", unit="mm", above=0, meaning="standard deviation beyond which a point is not given"
    )
    learn_motion: bool = parameter(
        True,
        meaning="raise process_noise, velocity_sd and acceleration_sd to what the recording has, where that is more, "
        "and lower them where tracks break that then do not, or below 33 Hz have more images; of markers nearer than "
        "3 m to the cameras, parameters in mm that are not stated count in proportion to that distance",
    )
    learn_delays: bool = parameter(
        True, meaning="track again with the delays of cameras that the tracks show not to be synchronous"
    )


DEFAULT = Simultaneous()
