"""A C3D file as it stands: its number format, its parameters, its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Bools, Floats, Ints
from ...data.arrays import column, set_columns
from .header import HeaderEvent
from .numbers import ByteOrder
from .parameters import BLOCK, Group, Parameter

HALF = -32768  # 0x8000 as a signed word; of the format
_NUMBERS = ("", *(str(i) for i in range(2, 258)))


@dataclass(frozen=True, slots=True, eq=False)
class C3D:
    """Everything in the file: F frames of M points and of A analog channels with S samples a frame, N = F S.

    Attributes:
        order: processor whose numbers the file has.
        floats: whether points and analog are floats, else 16-bit integers.
        rate: frames a second, Hz.
        points: (F, M, 3) in the file's units, integers already multiplied by `scale`.
        word: (F, M) fourth number of each point as stored: see `residual` and `cameras`; negative says missing.
        analog: (A, N) raw, as stored.
        samples: S.
        groups: parameters, in the file's order.
        scale: file units per count of integer points, and of the residual in either format.
        first_frame: number of the first frame; max_gap: longest gap to be interpolated, frames.
        header_events: events in the header.
        reserved: (512 bytes) the header without what stands in the fields above.
        data_block: block of the data, from 1; more room is made when the parameters need it.
        rotations: (F r, R, 17) r samples a frame of R segments as stored, see `rotations`; (0, 0, 17) where there
            are none.
        sample_table: the section of our own with covariances, see `sample_table`; empty where there is none.
        tail: bytes behind all that is known; kept as they are.
        notes: what was odd in the file and how it was read; not written.
    """

    order: ByteOrder
    floats: bool
    rate: float
    points: Floats
    word: Floats
    analog: Floats
    samples: int
    groups: tuple[Group, ...]
    scale: float = 1.0
    first_frame: int = 1
    max_gap: int = 0
    header_events: tuple[HeaderEvent, ...] = ()
    reserved: bytes = bytes(BLOCK)
    data_block: int = 3
    rotations: Floats = field(default_factory=lambda: np.zeros((0, 0, 17)))
    sample_table: bytes = b""
    tail: bytes = b""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        f, m = self.points.shape[:2]
        n = f * self.samples if len(self.analog) else None
        set_columns(
            self,
            points=column("points", self.points, np.float64, f, m, 3),
            word=column("word", self.word, np.float64, f, m),
            analog=column("analog", self.analog, np.float64, None, n),
            groups=tuple(self.groups),
            rotations=column("rotations", self.rotations, np.float64, None, None, 17),
        )

    @property
    def residual(self) -> Floats:
        """(F, M) mean distance of the rays from the point, file units; −1 where the point is missing."""
        bits, missing = _bits(self.word)
        return np.where(missing, -1.0, (bits & 0xFF) * self.scale)

    @property
    def cameras(self) -> NDArray[np.uint8]:
        """(F, M) bit c is set when camera c + 1 of at most 7 saw the point; 0 where missing."""
        bits, missing = _bits(self.word)
        return np.where(missing, 0, (bits >> 8) & 0x7F).astype(np.uint8)

    def get(self, group: str, name: str) -> Parameter | None:
        """The first parameter of this group and name, however they are capitalised."""
        found = (g.get(name) for g in self.groups if g.name.casefold() == group.casefold())
        return next((parameter for parameter in found if parameter is not None), None)

    def number(self, group: str, name: str, default: float) -> float:
        """First value of a parameter; `default` where it is absent, empty or text."""
        parameter = self.get(group, name)
        return float(parameter.numbers[0]) if parameter is not None and parameter.numbers.size else default

    def series(self, group: str, name: str) -> tuple[Parameter, ...]:
        """A parameter and its continuations beyond 255 entries: LABELS, LABELS2, LABELS3, …"""
        groups = [g for g in self.groups if g.name.casefold() == group.casefold()]
        named = {p.name.casefold(): p for g in reversed(groups) for p in reversed(g.parameters)}
        keys = takewhile(named.__contains__, (name.casefold() + number for number in _NUMBERS))
        return tuple(named[key] for key in keys)

    def texts(self, group: str, name: str) -> tuple[str, ...]:
        """Text in all rows of a parameter and its continuations."""
        return tuple(text for parameter in self.series(group, name) for text in parameter.texts)

    def numbers(self, group: str, name: str) -> Floats:
        """Numbers in a parameter and its continuations, flat."""
        return np.concatenate([np.zeros(0), *(parameter.numbers for parameter in self.series(group, name))])


def has_unsigned_analog(doc: C3D) -> bool:
    """Whether analog integers, and their offsets, run from 0 to 65 535.

    ANALOG:FORMAT says it. Where it is absent an offset of 0x8000 does, which is the middle of unsigned numbers; as a
    signed one it would lie at the end of the range. So does an offset stored as a float beyond the signed numbers.
    """
    if stated := doc.texts("ANALOG", "FORMAT")[:1]:
        return stated[0].upper() == "UNSIGNED"
    offsets = [p.values for p in doc.series("ANALOG", "OFFSET")]
    return any((v == HALF if v.dtype == np.int16 else (v > -HALF - 1) & (v < -2 * HALF)).any() for v in offsets)


def _bits(word: Floats) -> tuple[Ints, Bools]:
    """The fourth number as 16 bits, and where it says that the point is missing."""
    return np.where((word >= 0) & (word < 65536), word, 0).astype(np.int64), ~(word >= 0)


def with_parameters(doc: C3D, group: str, parameters: Sequence[Parameter]) -> C3D:
    """The document with these parameters put in the place of those of the same name, or added.

    Raises:
        ValueError: the group is new and the document has 127 already.
    """
    groups = list(doc.groups)
    if not any(g.name.casefold() == group.casefold() for g in groups):
        free = [i for i in range(1, 128) if i not in {g.id for g in groups}]
        if not free:
            raise ValueError(f"group {group} is the 128th; C3D holds 127")
        groups.append(Group(free[0], group))
    for new in parameters:
        fits = [i for i, g in enumerate(groups) if g.name.casefold() == group.casefold()]
        at = next((i for i in fits if groups[i].get(new.name) is not None), fits[0])
        groups[at] = replace(groups[at], parameters=_put(groups[at], new))
    return replace(doc, groups=tuple(groups))


def _put(group: Group, new: Parameter) -> tuple[Parameter, ...]:
    old = group.get(new.name)
    if old is None:
        return (*group.parameters, new)
    kept = replace(new, name=old.name, description=new.description or old.description, locked=old.locked)
    return tuple(kept if p is old else p for p in group.parameters)
