"""Joint angles through time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import column, set_columns


@dataclass(frozen=True, slots=True, eq=False)
class Angles:
    """J joints over F frames.

    Attributes:
        joints: (J) names.
        sequence: (J) order of the three turns, such as "zxy".
        deg: (J, F, 3) deg, NaN where missing.
        cov: (J, F, 3, 3) deg², NaN where unknown.
        rate: Hz.
    """

    joints: tuple[str, ...]
    sequence: tuple[str, ...]
    deg: NDArray[np.float64]
    cov: NDArray[np.float64]
    rate: float

    def __post_init__(self) -> None:
        n, f = len(self.joints), self.deg.shape[1]
        set_columns(
            self,
            joints=tuple(self.joints),
            sequence=tuple(self.sequence),
            deg=column("deg", self.deg, np.float64, n, f, 3),
            cov=column("cov", self.cov, np.float64, n, f, 3, 3),
        )
        if len(self.sequence) != n:
            raise ValueError(f"sequence has {len(self.sequence)} entries, wanted {n}")
