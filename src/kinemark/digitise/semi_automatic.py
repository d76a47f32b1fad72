"""The parameters of semi-automatic digitising."""

from __future__ import annotations

from dataclasses import dataclass

from ..data.arrays import check_positive

FIRST = 2
"""Frames that are digitised by hand, since two places are what extrapolation needs."""


@dataclass(frozen=True, slots=True)
class SemiAutomatic:
    """Linear extrapolation, a search that expands, and questions to the operator (UM²AS 3.5).

    Attributes:
        markers: their names, in the order in which they are asked for; UM²AS allows 30, the reference marker included.
        reference: the name of the marker that does not move; None where there is none.
        grid: the first search is this many pixels wide and high about where a marker is expected, UM²AS: 5.
        expansions: the search goes on up to this many times as wide, UM²AS: 10.
        memory: a marker is extrapolated from the two latest of so many frames before in which it was seen; 2, as in
            UM²AS: it must be seen in both.
        confirm_reference: ask in every frame whether what was found is the reference marker, as UM²AS does.
        take_proposals: where other cameras propose the missing answer, take it and do not ask.
        tolerance: how far an image may be from where other cameras expect it, px.
        clear: an image is taken without a question if every other that the marker could have had is this many times as
            far from where it is expected; 1 never asks, as UM²AS.
    """

    markers: tuple[str, ...]
    reference: str | None = None
    grid: int = 5
    expansions: int = 10
    memory: int = 2
    confirm_reference: bool = False
    take_proposals: bool = False
    tolerance: float = 3.0
    clear: float = 1.5

    def __post_init__(self) -> None:
        object.__setattr__(self, "markers", tuple(self.markers))
        if not self.markers or len(set(self.markers)) != len(self.markers):
            raise ValueError(f"markers are {list(self.markers)}, wanted at least one, each name once")
        if self.reference is not None and self.reference not in self.markers:
            raise ValueError(f"reference is {self.reference!r}, wanted one of {', '.join(self.markers)}, or None")
        if self.grid < 1 or self.expansions < 1:
            raise ValueError(f"grid and expansions are {self.grid} and {self.expansions}, wanted 1 or more")
        if self.memory < FIRST:
            raise ValueError(f"memory is {self.memory}, wanted {FIRST} frames or more")
        check_positive(tolerance=self.tolerance)
        if not self.clear >= 1:
            raise ValueError(f"clear is {self.clear}, wanted 1 or more")

    @property
    def fixed(self) -> int:
        """Index of the reference marker; −1 where there is none."""
        return -1 if self.reference is None else self.markers.index(self.reference)
