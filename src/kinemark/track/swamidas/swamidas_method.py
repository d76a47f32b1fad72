"""The parameters of Swamidas' tracking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...data import AngleModel
from ...data.method import ONE, Method, parameter

SENSORS = 2.54
"""The error of the document's sensors, 0.1 inch, mm."""


@dataclass(frozen=True, slots=True)
class Swamidas(Method):
    """Kalman prediction, regions of acceptance and three further constraints.

    Source: Swamidas 1997, 3.3 and 3.4. The document says how these enter, but not their values, save for the error of
    its sensors, 0.1 inch.
    """

    measurement_sd: float | None = parameter(
        SENSORS, former="error", unit="mm", above=0,
        meaning="standard deviation of a measured position; None: estimated from the first frames",
    )  # fmt: skip
    jerk: float = parameter(
        10_000.0, unit="mm/s³", above=0,
        meaning="process noise: by which the acceleration changes; U of the predictor is jerk · T",
    )  # fmt: skip
    velocity_share: float = parameter(
        0.2, unit=ONE, low=0,
        meaning="share of the way that the last velocity makes in a frame, by which a region of acceptance (gate) "
        "grows a frame",
    )  # fmt: skip
    direction: Literal["forward", "backward", "meeting"] = parameter(
        "forward",
        meaning="in which the recording is run through; meeting: both, and what a gap parts is joined where the "
        "predictions from both ends meet in its middle",
    )
    initiate_from: Literal["first", "any"] = parameter(
        "first",
        former="begin",
        meaning="which points begin tracks: first, those of the first three frames that have any (backward: the last), "
        "or any, those that no track takes",
    )
    max_coasting: float | None = parameter(
        None,
        former="patience",
        unit="s",
        above=0,
        meaning="coasting: how long a track without points goes on; None: for ever",
    )
    segment_tolerance: float = parameter(
        0.0, unit=ONE, low=0,
        meaning="share of a segment's length by which two markers' distance may differ from it; 0: lengths are not "
        "used, as in the document's tracking (they belong to its model of gait)",
    )  # fmt: skip
    links: tuple[tuple[int, int], ...] = parameter(
        (), unit="tracks", low=0,
        meaning="pairs of tracks, counted from 0 in the order of their beginning, that are ends of one segment; "
        "empty: learned from the first frames",
    )  # fmt: skip
    lengths: tuple[float, ...] = parameter(
        (), unit="mm", above=0, meaning="lengths of these segments; empty: learned from the first frames"
    )
    learning_time: float = parameter(
        0.3, former="learning", unit="s", above=0, meaning="what the first frames are, for error, links and lengths"
    )
    angle_model: str | None = parameter(
        None, meaning='component angle model that corrects predictions: "own", made of the trial itself, or a file of '
        "a model or of another trial of the same motion; None: the predictor alone",
    )  # fmt: skip
    model: AngleModel | None = parameter(None, meaning="what `angle_model` names, as read")
    feedback: Literal["measured", "position"] = parameter(
        "measured",
        meaning="how a correction enters the predictor: measured, in every frame as a position with the model's "
        "variance; position, as in the thesis, where an angle fails, with the differences that follow from it",
    )
    phase_tolerance: float = parameter(
        0.05, unit="cycles", low=0, below=0.5,
        meaning="an angle passes that the model has within this of the present phase",
    )  # fmt: skip
    model_spread: float = parameter(
        0.03, unit=ONE, above=0,
        meaning="spread of the model's directions, unit vectors, at least, by which the phase is found",
    )  # fmt: skip

    def check_together(self) -> None:
        """Refuse links of a track with itself, lengths that are not one a link, and a model beside its own."""
        if self.angle_model == "own" and self.model is not None:
            raise ValueError('angle_model is "own" and there is a model, wanted one of them')
        if self.lengths and len(self.lengths) != len(self.links):
            raise ValueError(f"there are {len(self.lengths)} lengths and {len(self.links)} links, wanted one each")
        if any(a == b for a, b in self.links):
            raise ValueError(f"links are {self.links}, wanted pairs of different tracks, counted from 0")


DEFAULT = Swamidas()
"""With the parameters' defaults."""
