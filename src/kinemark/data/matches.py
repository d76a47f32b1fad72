"""Which 2D points are one marker."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import column, set_columns


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """G groups of detections, each the images of one marker in one frame, sorted by frame.

    Attributes:
        frame: (G) frame of the group.
        view: (G, C) detection index: the row in `Detections`, −1 where the camera does not see it.
        cost: (G) RMS distance of its images from its reprojection, px.
        n_frames: F of the recording.
    """

    frame: NDArray[np.int64]
    view: NDArray[np.int64]
    cost: NDArray[np.float64]
    n_frames: int

    def __post_init__(self) -> None:
        n = len(self.frame)
        set_columns(
            self,
            frame=column("frame", self.frame, np.int64, n),
            view=column("view", self.view, np.int64, n, None),
            cost=column("cost", self.cost, np.float64, n),
        )
        if (np.diff(self.frame) < 0).any() or (n and not 0 <= self.frame[0] <= self.frame[-1] < self.n_frames):
            raise ValueError(f"frame must be sorted and within 0 … {self.n_frames - 1}")

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def n_views(self) -> NDArray[np.int64]:
        """(G) how many cameras see each group."""
        return (self.view >= 0).sum(1)
