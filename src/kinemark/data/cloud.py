"""3D points of every frame, first without and then with an identity."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .array_types import Bools, Floats, Ints
from .arrays import check_offsets, column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Cloud(ShortRepr):
    """P reconstructed points over F frames, sorted by frame.

    Attributes:
        rate: frames a second, Hz.
        start: (F+1) rows start[f]:start[f+1] are frame f.
        xyz: (P, 3) mm.
        cov: (P, 3, 3) mm².
        residual: (P) RMS reprojection error, px.
        detection: (P, C) index in `Detections` of the image in each camera; −1 where it does not see the point.
    """

    rate: float
    start: Ints
    xyz: Floats
    cov: Floats
    residual: Floats
    detection: Ints

    def __post_init__(self) -> None:
        n = len(self.xyz)
        set_columns(
            self,
            start=column("start", self.start, np.int64, None),
            xyz=column("xyz", self.xyz, np.float64, n, 3),
            cov=column("cov", self.cov, np.float64, n, 3, 3),
            residual=column("residual", self.residual, np.float64, n),
            detection=column("detection", self.detection, np.int64, n, None),
        )
        check_offsets(self.start, n)

    def __len__(self) -> int:
        return len(self.xyz)

    def __getitem__(self, f: int) -> Floats:
        """A view of xyz: the points of frame f, (n, 3) mm."""
        return self.xyz[self.rows(f)]

    def rows(self, f: int) -> slice:
        """The rows of frame f."""
        return slice(int(self.start[f]), int(self.start[f + 1]))

    @property
    def n_frames(self) -> int:
        """F."""
        return len(self.start) - 1

    @property
    def frame(self) -> Ints:
        """(P) the frame of each row."""
        return np.repeat(np.arange(self.n_frames), np.diff(self.start))

    def keep(self, mask: Bools) -> Cloud:
        """Only the rows where `mask` (P) is true; the same record where all are."""
        if mask.all():
            return self
        before = np.concatenate([[0], np.cumsum(mask)])
        return replace(
            self,
            start=before[self.start],
            xyz=self.xyz[mask],
            cov=self.cov[mask],
            residual=self.residual[mask],
            detection=self.detection[mask],
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Tracks(ShortRepr):
    """A cloud whose points have an identity.

    Attributes:
        cloud: the points.
        id: (P) track of each point, counted from 0; −1 for none. A track has at most one point a frame.
    """

    cloud: Cloud
    id: Ints

    def __post_init__(self) -> None:
        set_columns(self, id=column("id", self.id, np.int64, len(self.cloud)))
        named = self.id >= 0
        pairs = np.sort((self.cloud.frame * max(len(self), 1) + self.id)[named])
        if (pairs[1:] == pairs[:-1]).any():
            raise ValueError("a track has two points in one frame")

    def __len__(self) -> int:
        """How many tracks there are."""
        return int(self.id.max(initial=-1)) + 1

    @property
    def lengths(self) -> Ints:
        """(T) points of each track."""
        return np.bincount(self.id[self.id >= 0], minlength=len(self))
