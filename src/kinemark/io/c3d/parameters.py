"""The parameter section: groups of named values, in blocks of 512 bytes.

After four bytes (two spare, the number of blocks, the processor) follow entries, each

    int8 length of the name, negative when locked | int8 id: −g for the group g, g for a parameter of it |
    name | uint16 distance from here to the next entry, 0 in the last |
    of a parameter: int8 type (−1 char, 1 byte, 2 int16, 4 float) | uint8 number of dimensions | uint8 each | values |
    uint8 length of the description | description

and a name of length 0 ends the section. The first dimension varies fastest, so `values` has the dimensions in
reverse: LABELS (16, 40) is an array of 40 rows of 16 characters.

Values are kept as they are stored. Text is kept as bytes, because files come in ASCII, Latin-1 and UTF-8 and padded
with blanks or zeros: `texts` decodes, and writing gives the very bytes back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data.array_types import Floats
from ...data.arrays import set_columns
from .numbers import ByteOrder, decode_floats, decode_words, encode_floats, encode_words

BLOCK = 512  # bytes of a block of the file; of the format
MOST_ENTRIES = 65_536  # parameters and groups at most; chosen, lest a broken file take memory
SHOWN = 40  # letters of a name in a message at most; chosen: those of a broken file are 127 bytes of anything
MOST_DIMENSIONS = 7  # of a parameter; of the format
ValueArray = NDArray[np.uint8] | NDArray[np.int8] | NDArray[np.int16] | NDArray[np.float32]
_TYPE_OF = {"uint8": -1, "int8": 1, "int16": 2, "float32": 4}


@dataclass(frozen=True, slots=True, eq=False)
class Parameter:
    """One parameter.

    Attributes:
        name: as it stands in the file.
        values: uint8 for characters, int8 for bytes, int16 or float32; the file's dimensions in reverse.
        description: what it is.
        locked: whether the file asks that it be left alone.
    """

    name: str
    values: ValueArray
    description: str = ""
    locked: bool = False

    def __post_init__(self) -> None:
        values = np.asarray(self.values).view()
        if values.dtype.name not in _TYPE_OF:
            raise ValueError(f"{self.name} has values of {values.dtype}, wanted one of {', '.join(_TYPE_OF)}")
        values.flags.writeable = False
        set_columns(self, values=values)

    @classmethod
    def text(cls, name: str, rows: Sequence[str] | str) -> Parameter:
        """Characters: one string, or rows padded with blanks to the longest, cut at 127 bytes."""
        lines = [row.encode("utf-8")[:127] for row in ([rows] if isinstance(rows, str) else rows)]
        width = max(map(len, lines), default=0)
        table = np.frombuffer(b"".join(line.ljust(width) for line in lines), np.uint8).reshape(len(lines), width)
        return cls(name, table[0] if isinstance(rows, str) else table)

    @classmethod
    def whole(cls, name: str, values: ArrayLike) -> Parameter:
        """16-bit integers; those from 32 768 to 65 535 are stored by their bits, as C3D does."""
        bits = np.asarray(values, np.int64)
        if bits.size and not (bits.min() >= -32768 and bits.max() <= 65535):
            raise ValueError(f"{name} must lie within −32768 … 65535, found {bits.min()} … {bits.max()}")
        return cls(name, (bits & 0xFFFF).astype(np.uint16).view(np.int16))

    @classmethod
    def real(cls, name: str, values: ArrayLike) -> Parameter:
        """Floats."""
        return cls(name, np.asarray(values, np.float32))

    @property
    def is_text(self) -> bool:
        """Whether the values are characters."""
        return self.values.dtype == np.uint8

    @property
    def texts(self) -> tuple[str, ...]:
        """Text of each row, without padding; () when the values are numbers."""
        if not self.is_text:
            return ()
        rows = self.values.reshape(1) if self.values.ndim == 0 else self.values
        count = math.prod(rows.shape[:-1])
        return tuple(decode_text(row.tobytes()) for row in rows.reshape(count, rows.shape[-1]))

    @property
    def numbers(self) -> Floats:
        """All values in the file's order as floats; empty when they are characters."""
        return np.zeros(0) if self.is_text else self.values.reshape(-1).astype(np.float64)

    @property
    def unsigned(self) -> Floats:
        """As `numbers`, with integers taken as unsigned."""
        kind = {"int8": np.uint8, "int16": np.uint16}.get(self.values.dtype.name)
        return self.numbers if kind is None else self.values.reshape(-1).view(kind).astype(np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """A group of parameters.

    Attributes:
        id: 1 … 127.
        name: as it stands in the file; empty when parameters name a group that the file does not define.
        parameters: in the file's order.
        description: what it is.
        locked: whether the file asks that it be left alone.
    """

    id: int
    name: str
    parameters: tuple[Parameter, ...] = ()
    description: str = ""
    locked: bool = False

    def get(self, name: str) -> Parameter | None:
        """The first parameter of this name, however it is capitalised."""
        return next((p for p in self.parameters if p.name.casefold() == name.casefold()), None)


@dataclass(slots=True)
class _Sheet:
    """A group while its parameters are being gathered."""

    name: str = ""
    description: str = ""
    locked: bool = False
    parameters: list[Parameter] = field(default_factory=list)


def decode_text(raw: bytes) -> str:
    """Text up to the first zero byte without blanks around it: UTF-8 where it is valid, else Latin-1."""
    raw = raw.split(b"\0", 1)[0].strip()
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1").strip()


def decode_parameters(raw: bytes, order: ByteOrder) -> tuple[tuple[Group, ...], tuple[str, ...], tuple[str, ...]]:
    """Groups in a parameter section (without its first four bytes), what could not be read, and what is odd."""
    sheets: dict[int, _Sheet] = {}
    lost: list[str] = []
    odd: list[str] = []
    for start, stop in _entries(raw, order, lost, odd):
        length, number = (int(i) for i in np.frombuffer(raw, np.int8, 2, start))
        name = raw[start + 2 : start + 2 + abs(length)].decode("latin-1")
        body = raw[start + 4 + abs(length) : stop]
        if number in (0, -128):
            lost.append(f"{name[:SHOWN]!r}, which is of no group")
            continue
        sheet = sheets.setdefault(abs(number), _Sheet())
        if number > 0:
            try:
                sheet.parameters.append(_decode_parameter(name, body, order, locked=length < 0))
            except ValueError as error:
                of = sheet.name[:SHOWN] or f"group {number}"
                lost.append(f"parameter {name[:SHOWN]!r} of {of} {error}")
        elif not sheet.name:
            sheet.name, sheet.description, sheet.locked = name, _description(body), length < 0
        else:
            lost.append(f"group {name[:SHOWN]!r} has the number {abs(number)} of {sheet.name[:SHOWN]!r}")
    groups = [Group(i, s.name, tuple(s.parameters), s.description, s.locked) for i, s in sheets.items()]
    return tuple(sorted(groups, key=lambda group: not group.name)), tuple(lost), tuple(odd)


def _entries(raw: bytes, order: ByteOrder, lost: list[str], odd: list[str]) -> Iterator[tuple[int, int]]:
    """First and last-plus-one byte of each entry; what ends the chain too early goes into `lost`."""
    at = count = 0
    while at + 2 <= len(raw) and raw[at] != 0:
        pointer = at + 2 + (raw[at] if raw[at] < 128 else 256 - raw[at])
        step = int.from_bytes(raw[pointer : pointer + 2], "big" if order.char == ">" else "little")
        stop, count = pointer + step if step else len(raw), count + 1
        name = raw[at + 2 : pointer].decode("latin-1")[:SHOWN]
        if pointer + 2 <= len(raw) and (stop > len(raw) or step == 1):
            stop = _own_end(raw, pointer + 2, raw[at + 1])
            if stop <= len(raw):
                odd.append(f"{name!r} points beyond its section for what follows; taken to end at byte {stop}")
        if pointer + 2 > len(raw) or stop > len(raw) or count > MOST_ENTRIES:
            why = f"more than {MOST_ENTRIES} entries" if count > MOST_ENTRIES else "it runs past the end"
            lost.append(f"the parameters from byte {at} of their section on, {name!r}: {why}")
            return
        yield at, stop
        if not step:
            return
        at = stop


def _own_end(raw: bytes, at: int, number: int) -> int:
    """Where an entry ends by its own sizes; beyond the section when it does not."""
    beyond = len(raw) + 1
    if number < 128:
        if at + 2 > len(raw) or at + 2 + raw[at + 1] > len(raw):
            return beyond
        size = math.prod(raw[at + 2 : at + 2 + raw[at + 1]]) * (raw[at] if raw[at] < 128 else 256 - raw[at])
        at += 2 + raw[at + 1] + size
    return at + 1 + raw[at] if at < len(raw) else beyond


def _decode_parameter(name: str, body: bytes, order: ByteOrder, *, locked: bool) -> Parameter:
    if len(body) < 2:
        raise ValueError(f"has {len(body)} bytes")
    kind = int.from_bytes(body[:1], "little", signed=True)
    dims = body[2 : 2 + body[1]]
    if kind not in _TYPE_OF.values() or len(dims) != body[1] or len(dims) > MOST_DIMENSIONS:
        raise ValueError(f"has type {kind} and {body[1]} dimensions, wanted −1, 1, 2 or 4 and at most 7")
    size, first = math.prod(dims) * abs(kind), 2 + len(dims)
    if first + size > len(body):
        raise ValueError(f"holds {tuple(dims)} values of {abs(kind)} bytes in {len(body) - first} bytes")
    raw = np.frombuffer(body, np.uint8, size, first)
    values = _decode_values(raw, kind, order).reshape(dims[::-1])
    return Parameter(name, values, _description(body[first + size :]), locked)


def _decode_values(raw: NDArray[np.uint8], kind: int, order: ByteOrder) -> ValueArray:
    if kind == 4:
        return decode_floats(raw, order)
    return decode_words(raw, order) if kind == 2 else raw.view(np.int8) if kind == 1 else raw


def _description(body: bytes) -> str:
    """A description; some writers leave out even its length."""
    return body[1 : 1 + body[0]].decode("latin-1") if body else ""


def encode_parameters(groups: Sequence[Group], order: ByteOrder) -> bytes:
    """A parameter section without its first four bytes; the inverse of `decode_parameters`.

    Raises:
        ValueError: a name, description, dimension or parameter is longer than the format holds.
    """
    parts = [_encode_entry(g.name, -g.id, b"", g.description, g.locked, order) for g in groups if g.name]
    for group in groups:
        if not 1 <= group.id <= 127:
            raise ValueError(f"group {group.name} has the number {group.id}, wanted 1 … 127")
        for p in group.parameters:
            parts.append(_encode_entry(p.name, group.id, _encode_values(p, order), p.description, p.locked, order))
    return b"".join(parts) + b"\0\0"


def _encode_values(p: Parameter, order: ByteOrder) -> bytes:
    if p.values.ndim > MOST_DIMENSIONS or max(p.values.shape, default=0) > 255:
        raise ValueError(f"{p.name} has dimensions {p.values.shape[::-1]}; C3D holds 7 of at most 255: split it")
    flat = np.ascontiguousarray(p.values).reshape(-1)
    kind = _TYPE_OF[p.values.dtype.name]
    raw = encode_floats(flat, order) if kind == 4 else encode_words(flat, order) if kind == 2 else flat
    return bytes([kind & 0xFF, p.values.ndim, *p.values.shape[::-1]]) + raw.tobytes()


def _encode_entry(name: str, number: int, body: bytes, description: str, locked: bool, order: ByteOrder) -> bytes:
    try:
        raw, words = name.encode("latin-1"), description.encode("latin-1")
    except UnicodeEncodeError as error:
        raise ValueError(f"the name or description of {name!r} has letters that C3D does not") from error
    step = 2 + len(body) + 1 + len(words)
    if not 1 <= len(raw) <= 127 + locked or len(words) > 255 or step > 65535:
        raise ValueError(f"{name!r}: C3D holds names to 127, descriptions to 255 and values to 65 000 bytes")
    length = -len(raw) if locked else len(raw)
    head = bytes([length & 0xFF, number & 0xFF]) + raw
    return head + step.to_bytes(2, "big" if order.char == ">" else "little") + body + bytes([len(words)]) + words
