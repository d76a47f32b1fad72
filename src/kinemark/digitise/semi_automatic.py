"""Semi-automatic digitising: the method and its parameters; it is called as `drive` says."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..data.method import ONE, Method, Stage, check_parameters, parameter

DIGITISE = Stage("digitise", "kinemark.digitise", default="semi_automatic", meaning="markers named by an operator")


FIRST = 2
"""Frames that are digitised by hand, since two places are what extrapolation needs; by definition."""


@dataclass(frozen=True, slots=True)
class SemiAutomatic(Method):
    """Linear extrapolation, a search that expands, and questions to the operator."""

    markers: tuple[str, ...] = parameter(
        meaning="their names, in the order in which they are asked for; UM²AS allows 30, the reference marker included"
    )
    reference: str | None = parameter(
        None, meaning="the name of the marker that does not move; None where there is none"
    )
    grid: int = parameter(
        5, unit="px", low=1, meaning="width and height of the first search about where a marker is expected; UM²AS: 5"
    )
    expansions: int = parameter(
        10, unit=ONE, low=1, meaning="the search goes on up to this many times as wide; UM²AS: 10"
    )
    history: int = parameter(
        2, unit="frames", low=FIRST,
        meaning="a marker is extrapolated from the two latest of so many frames before in which it was seen; 2, as "
        "in UM²AS: it must be seen in both",
    )  # fmt: skip
    confirm_reference: bool = parameter(
        False,
        meaning="ask in every frame whether what was found is the reference marker, and again of what is then pointed "
        "at, as UM²AS does",
    )
    take_proposals: bool = parameter(
        False, meaning="where other cameras propose the missing answer, take it and do not ask"
    )
    tolerance: float = parameter(
        3.0, unit="px", above=0, meaning="how far an image may be from where other cameras expect it"
    )
    ambiguity_ratio: float = parameter(
        1.5, unit=ONE, low=1, high=math.inf,
        meaning="an image is taken without a question if every other that the marker could have had is this many "
        "times as far from where it is expected; 1 never asks, as UM²AS",
    )  # fmt: skip

    def __post_init__(self) -> None:
        if isinstance(self.markers, list):
            object.__setattr__(self, "markers", tuple(self.markers))
        check_parameters(self)
        self.check_together()

    def check_together(self) -> None:
        """Refuse names that come twice, and a reference that is none of them."""
        if not self.markers or len(set(self.markers)) != len(self.markers):
            raise ValueError(f"markers are {list(self.markers)}, wanted at least one, each name once")
        if self.reference is not None and self.reference not in self.markers:
            raise ValueError(f"reference is {self.reference!r}, wanted one of {', '.join(self.markers)}, or None")

    @property
    def fixed(self) -> int:
        """Index of the reference marker; −1 where there is none."""
        return -1 if self.reference is None else self.markers.index(self.reference)
