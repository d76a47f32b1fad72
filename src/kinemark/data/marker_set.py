"""Which markers a subject wears: names and their meaning, segments, joints, links, sides, places in a figure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, TypeVar

import numpy as np

from .array_types import Floats, Ints
from .arrays import column, set_columns
from .nearest_word import guess
from .short_repr import ShortRepr

Place = tuple[float, float, float]
"""Forward, to the subject's left and up from the floor of one who stands, as shares of the body's height."""
Face = Literal["front", "back", "both"]
"""The view of the figure in which a marker is seen."""
FACES: tuple[Face, ...] = ("front", "back", "both")
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class MarkerSet(ShortRepr):
    """M markers, their segments and links.

    Attributes:
        names: (M).
        segments: name → names of the markers on that segment.
        links: (L, 2) indices of markers at a nearly constant distance.
        length: (L) mm; spread: (L) standard deviation, mm; NaN where unknown.
        pairs: left and right names of the same landmark.
        name: of the set; empty for one that has none.
        description, source: in a sentence; author and year.
        meaning: marker → where it sits, in words.
        rigidity: segment → standard deviation of its distances over a motion, as a share of each.
        joints: name → the two segments that meet there.
        places: marker or joint → its place on one who stands; of an object, in shares of its length.
        faces: marker → the view of the figure in which it is seen.
        optional: markers that may be absent. static_only: those that are taken off before the subject moves.
    """

    names: tuple[str, ...]
    segments: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    links: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    length: Floats = field(default_factory=lambda: np.zeros(0))
    spread: Floats = field(default_factory=lambda: np.zeros(0))
    pairs: tuple[tuple[str, str], ...] = ()
    name: str = ""
    description: str = ""
    source: str = ""
    meaning: Mapping[str, str] = field(default_factory=dict)
    rigidity: Mapping[str, float] = field(default_factory=dict)
    joints: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    places: Mapping[str, Place] = field(default_factory=dict)
    faces: Mapping[str, Face] = field(default_factory=dict)
    optional: tuple[str, ...] = ()
    static_only: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.links)
        set_columns(
            self,
            names=tuple(self.names),
            links=column("links", self.links, np.int64, n, 2),
            length=column("length", self.length, np.float64, n),
            spread=column("spread", self.spread, np.float64, n),
            pairs=tuple(self.pairs),
            optional=tuple(self.optional),
            static_only=tuple(self.static_only),
        )
        _freeze(self, "segments", {k: tuple(v) for k, v in self.segments.items()})
        _freeze(self, "joints", {k: tuple(v) for k, v in self.joints.items()})
        for key in ("meaning", "rigidity", "places", "faces"):
            _freeze(self, key, dict(getattr(self, key)))
        _check_names(self)
        _check_numbers(self)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def moving(self) -> tuple[str, ...]:
        """The markers that are there while the subject moves."""
        return tuple(name for name in self.names if name not in self.static_only)


def _freeze(record: MarkerSet, key: str, value: dict[str, T]) -> None:
    object.__setattr__(record, key, MappingProxyType(value))


def _check_names(of: MarkerSet) -> None:
    """All names are there once, and what is said of markers, segments and sides is of those that there are."""
    if twice := sorted({name for name in of.names if of.names.count(name) > 1}):
        raise ValueError(f"marker names must differ, found {', '.join(twice)} more than once")
    for segment, markers in of.segments.items():
        known("marker", f"segment {segment}", markers, of.names)
        if len(set(markers)) < len(markers):
            raise ValueError(f"segment {segment} names a marker twice: {', '.join(markers)}")
    for joint, ends in of.joints.items():
        known("segment", f"joint {joint}", ends, of.segments)
        if len(ends) != 2 or ends[0] == ends[1]:
            raise ValueError(f"joint {joint} joins {', '.join(ends)}, wanted two different segments")
    known("segment", "rigidity", of.rigidity, of.segments)
    known("marker or joint", "places", of.places, (*of.names, *of.joints))
    for what in ("meaning", "faces", "optional", "static_only"):
        known("marker", what, getattr(of, what), of.names)
    sides = [name for pair in of.pairs for name in pair]
    known("marker", "pairs", sides, of.names)
    if twice := sorted({name for name in sides if sides.count(name) > 1}):
        raise ValueError(f"{', '.join(twice)} stands in more than one left and right pair")
    if both := sorted(set(of.optional) & set(of.static_only)):
        raise ValueError(f"{', '.join(both)} cannot be optional and of the static trial only; say one of them")


def known(kind: str, where: str, words: Iterable[str], there: Iterable[str]) -> None:
    """All words are among those that there are.

    Raises:
        ValueError: one is not; the message has the nearest that there is.
    """
    every = tuple(there)
    if strange := [word for word in words if word not in every]:
        raise ValueError(f"{where} has the unknown {kind} {strange[0]!r}{guess(strange[0], every)}")


def _check_numbers(of: MarkerSet) -> None:
    """Links are of two markers, lengths and shares are none below 0, places are finite."""
    if len(of.links) and not (of.links.min() >= 0 and of.links.max() < len(of.names)):
        raise ValueError(f"links must be indices below {len(of.names)}")
    if (of.links[:, 0] == of.links[:, 1]).any():
        marker = of.names[int(of.links[of.links[:, 0] == of.links[:, 1]][0, 0])]
        raise ValueError(f"a link goes from {marker} to itself")
    if (of.length <= 0).any() or (of.spread < 0).any() or np.isinf([*of.length, *of.spread]).any():
        raise ValueError("lengths of links must be above 0 mm and finite, spreads 0 or more")
    for segment, share in of.rigidity.items():
        if not 0 <= share < 1:
            raise ValueError(f"the spread of segment {segment} is {share}, wanted a share of its distances below 1")
    for name, place in of.places.items():
        if len(place) != 3 or not np.isfinite(place).all():
            raise ValueError(f"the place of {name} is {place}, wanted three numbers: forward, left, up")
    if strange := sorted(set(of.faces.values()) - set(FACES)):
        raise ValueError(f"a marker's view is {strange[0]!r}, wanted front, back or both")
