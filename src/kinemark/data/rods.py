"""The control frame: straight rods that hang about the volume, each with markers in its own spacing (KISS 3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .array_types import Bools, Floats
from .arrays import column, set_columns
from .short_repr import ShortRepr


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Rods(ShortRepr):
    """R rods of up to K markers each, as surveyed.

    Attributes:
        names: (R) such as "A".
        xyz: (R, K, 3) the markers' centres in the laboratory, in order along each rod, mm; NaN behind the last one of a
            rod that has fewer than K.
        marker_diameter: of the markers, mm; NaN where not given.
    """

    names: tuple[str, ...]
    xyz: Floats
    marker_diameter: float = float("nan")

    def __post_init__(self) -> None:
        set_columns(self, names=tuple(self.names), xyz=column("xyz", self.xyz, np.float64, len(self.names), None, 3))
        fewest = int(self.present.sum(1).min(initial=self.xyz.shape[1]))
        ends_with_nan = (np.diff(self.present.astype(int), axis=1) <= 0).all() and not np.isinf(self.xyz).any()
        if fewest < 4 or not ends_with_nan:
            raise ValueError(
                f"xyz has shape {self.xyz.shape} and rods of {fewest} markers or more, wanted at least 4 a rod, all "
                "finite, and NaN only behind the last"
            )

    @property
    def present(self) -> Bools:
        """(R, K) whether the rod has that many markers."""
        return np.asarray(np.isfinite(self.xyz).all(-1))

    @property
    def axes(self) -> Floats:
        """(R, 3) direction of each rod, from its first marker to its last."""
        last = self.present.sum(1) - 1
        axis = self.xyz[np.arange(len(last)), last] - self.xyz[:, 0]
        return np.asarray(axis / np.linalg.norm(axis, axis=1, keepdims=True))

    @property
    def along(self) -> Floats:
        """(R, K) place of each marker along its rod, from its first marker, mm."""
        return np.asarray(np.einsum("rki,ri->rk", self.xyz - self.xyz[:, :1], self.axes))

    @property
    def marker_names(self) -> tuple[str, ...]:
        """(R·K) "A1" is the first marker of rod A."""
        return tuple(f"{name}{k + 1}" for name in self.names for k in range(self.xyz.shape[1]))
