"""Which markers a subject wears and how they are linked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from .arrays import column, set_columns


@dataclass(frozen=True, slots=True, eq=False)
class MarkerSet:
    """M markers, their segments and links.

    Attributes:
        names: (M).
        segments: name → names of the markers on that segment.
        links: (L, 2) indices of markers at a nearly constant distance.
        length: (L) mm; spread: (L) standard deviation, mm; NaN where unknown.
        pairs: left and right names of the same landmark.
    """

    names: tuple[str, ...]
    segments: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    links: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    length: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    spread: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    pairs: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        n = len(self.links)
        set_columns(
            self,
            names=tuple(self.names),
            links=column("links", self.links, np.int64, n, 2),
            length=column("length", self.length, np.float64, n),
            spread=column("spread", self.spread, np.float64, n),
            pairs=tuple(self.pairs),
        )
        object.__setattr__(self, "segments", MappingProxyType({k: tuple(v) for k, v in self.segments.items()}))
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"marker names must differ, found {self.names}")
        used = {m for markers in self.segments.values() for m in markers} | {m for pair in self.pairs for m in pair}
        if unknown := sorted(used - set(self.names)):
            raise ValueError(f"segments or pairs name unknown markers {unknown}")
        if n and not (self.links.min() >= 0 and self.links.max() < len(self.names)):
            raise ValueError(f"links must be indices below {len(self.names)}")
