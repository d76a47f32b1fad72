"""The parameters of Swamidas' tracking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...data.arrays import check_positive

SENSORS = 2.54
"""The error of the document's sensors, 0.1 inch, mm."""


@dataclass(frozen=True, slots=True)
class Swamidas:
    """Kalman prediction, regions of acceptance and three further constraints (Swamidas 1997, 3.3 and 3.4).

    The document says how these enter, but not their values, save for the error of its sensors, 0.1 inch.

    Attributes:
        error: of a measured position, standard deviation, mm; None: estimated from the first frames.
        jerk: by which the acceleration changes, mm/s³; U of the predictor is jerk · T.
        velocity_share: of the way that the last velocity makes in a frame, by which a region grows a frame.
        begin: which points begin tracks: "first", those of the first three frames that have any, or "any", those that
            no track takes.
        patience: how long a track without points goes on, s; None: for ever.
        segment_tolerance: share of a segment's length by which two markers' distance may differ from it; 0: lengths are
            not used, as in the document's tracking (they belong to its model of gait).
        links: pairs of tracks, counted from 0 in the order of their beginning, that are ends of one segment; empty:
            learned from the first frames.
        lengths: of these segments, mm; empty: learned from the first frames.
        learning: what the first frames are, s; for `error`, `links` and `lengths`.
    """

    error: float | None = SENSORS
    jerk: float = 10_000.0
    velocity_share: float = 0.2
    begin: Literal["first", "any"] = "first"
    patience: float | None = None
    segment_tolerance: float = 0.0
    links: tuple[tuple[int, int], ...] = ()
    lengths: tuple[float, ...] = ()
    learning: float = 0.3

    def __post_init__(self) -> None:
        check_positive(error=self.error, jerk=self.jerk, patience=self.patience, learning=self.learning)
        for name in ("velocity_share", "segment_tolerance"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} is {getattr(self, name)}, wanted 0 or more")
        check_positive(**{f"lengths[{i}]": length for i, length in enumerate(self.lengths)})
        if self.lengths and len(self.lengths) != len(self.links):
            raise ValueError(f"there are {len(self.lengths)} lengths and {len(self.links)} links, wanted one each")
        if any(a == b or min(a, b) < 0 for a, b in self.links):
            raise ValueError(f"links are {self.links}, wanted pairs of different tracks, counted from 0")


DEFAULT = Swamidas()
"""With the parameters' defaults."""
