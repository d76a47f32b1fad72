"""Positions and orientations of body segments through time, as systems without markers give them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .array_types import Floats
from .arrays import check_positive, column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Poses(ShortRepr):
    """S segments at N times.

    Attributes:
        names: (S).
        rate: samples a second, Hz.
        T_world_segment: (S, N, 4, 4) homogeneous matrices, translations in mm; NaN where missing.
        reliability: (S, N) as the source states it; NaN where unknown.
        start: time of the first sample after the first frame of the trial, s.
    """

    names: tuple[str, ...]
    rate: float
    T_world_segment: Floats
    reliability: Floats
    start: float = 0.0

    def __post_init__(self) -> None:
        s = len(self.names)
        set_columns(
            self,
            names=tuple(self.names),
            T_world_segment=column("T_world_segment", self.T_world_segment, np.float64, s, None, 4, 4),
        )
        n = self.T_world_segment.shape[1]
        set_columns(self, reliability=column("reliability", self.reliability, np.float64, s, n))
        check_positive(rate=self.rate)

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, name: str) -> Floats:
        """(N, 4, 4) the poses of one segment."""
        if name not in self.names:
            raise KeyError(f"no segment {name!r}; there are {', '.join(self.names)}")
        return self.T_world_segment[self.names.index(name)]
