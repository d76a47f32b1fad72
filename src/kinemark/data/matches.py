"""Which 2D points are one marker."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .array_types import Floats, Ints
from .arrays import column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Matches(ShortRepr):
    """G groups of detections, each the images of one marker in one frame, sorted by frame.

    Attributes:
        frame: (G) frame of the group.
        detection: (G, C) index in `Detections` of the image in each camera; −1 where it does not see the marker.
        cost: (G) RMS distance of its images from its reprojection, px.
        n_frames: F of the recording.
    """

    frame: Ints
    detection: Ints
    cost: Floats
    n_frames: int

    def __post_init__(self) -> None:
        n = len(self.frame)
        set_columns(
            self,
            frame=column("frame", self.frame, np.int64, n),
            detection=column("detection", self.detection, np.int64, n, None),
            cost=column("cost", self.cost, np.float64, n),
        )
        if (np.diff(self.frame) < 0).any() or (n and not 0 <= self.frame[0] <= self.frame[-1] < self.n_frames):
            raise ValueError(f"frame must be sorted and within 0 … {self.n_frames - 1}")

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def n_cameras(self) -> Ints:
        """(G) how many cameras see the marker of each group."""
        return (self.detection >= 0).sum(1)
