"""The method of each gap, chosen by hidden tests.

Every candidate is tried in the same tests (`hiding`); the one that does best in them fills the gap, and what it was
measured at is the error expected of it (`calibration`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..methods.table import NAMES, TRIED, name_of


@dataclass(frozen=True, slots=True)
class Auto:
    """Choose for every gap.

    Attributes:
        candidates: methods that are tried, by their names or with parameters of their own.
    """

    candidates: tuple[Any, ...] = TRIED

    def __post_init__(self) -> None:
        if unknown := [name for name in self.candidates if isinstance(name, str) and name not in NAMES]:
            raise ValueError(f"candidates {unknown} are not known; there are {', '.join(NAMES)}")
        names = [name_of(method) for method in self.methods]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"candidates are {names}, wanted at least one and each once")

    @property
    def methods(self) -> tuple[Any, ...]:
        """The candidates as methods."""
        return tuple(NAMES[one]() if isinstance(one, str) else one for one in self.candidates)
