"""The control frame: straight rods that hang about the volume, each with markers in its own spacing (KISS 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import column, set_columns


@dataclass(frozen=True, slots=True, eq=False)
class Rods:
    """R rods of K markers each, as surveyed.

    Attributes:
        names: (R) such as "A".
        xyz: (R, K, 3) the markers' centres in the laboratory, in order along each rod, mm.
        marker_diameter: of the markers, mm; NaN where not given.
    """

    names: tuple[str, ...]
    xyz: NDArray[np.float64]
    marker_diameter: float = float("nan")

    def __post_init__(self) -> None:
        set_columns(self, names=tuple(self.names), xyz=column("xyz", self.xyz, np.float64, len(self.names), None, 3))
        if self.xyz.shape[1] < 4 or not np.isfinite(self.xyz).all():
            raise ValueError(f"xyz has shape {self.xyz.shape}, wanted at least 4 markers a rod, all finite")

    @property
    def along(self) -> NDArray[np.float64]:
        """(R, K) place of each marker along its rod, from its first marker, mm."""
        axis = self.xyz[:, -1] - self.xyz[:, 0]
        axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        return np.einsum("rki,ri->rk", self.xyz - self.xyz[:, :1], axis)

    @property
    def marker_names(self) -> tuple[str, ...]:
        """(R·K) "A1" is the first marker of rod A."""
        return tuple(f"{name}{k + 1}" for name in self.names for k in range(self.xyz.shape[1]))
