"""The method of each gap, chosen by hold-out gaps.

Every candidate is tried in the same tests (`hold_out`); the one that does best in them fills the gap, and what it was
measured at is the error expected of it (`expected_error`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...data.method import Declaration, Method, parameter
from ..methods.stage import FILL, FillMethod, automatic


@dataclass(frozen=True, slots=True)
class Auto(Method):
    """For every gap the method that does best in hold-out gaps, or the mean of those that do nearly as well."""

    candidates: tuple[Any, ...] = parameter(
        factory=automatic, meaning="methods that are tried, by their names or, in Python, with parameters of their own"
    )

    def check_together(self) -> None:
        """Refuse what is no method of filling, and methods that come twice."""
        if unknown := [name for name in self.candidates if isinstance(name, str) and name not in FILL]:
            raise ValueError(f"candidates {unknown} are not known; there are {', '.join(automatic())}")
        names = [FILL.of(method).name for method in self.methods]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"candidates are {names}, wanted at least one and each once")

    @property
    def methods(self) -> tuple[FillMethod, ...]:
        """The candidates as methods."""
        return tuple(FILL.make(one) if isinstance(one, str) else one for one in self.candidates)


FILL.declare(Declaration("fill", "auto", Auto))
