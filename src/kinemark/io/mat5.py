"""MATLAB's MAT files of version 5 to 7, read defensively: numbers, texts, structures and cells.

A file is a header of 128 bytes, the last four of which give version and byte order, and then elements: type, number of
bytes, data, filled up to eight bytes. Four bytes of data or fewer lie in the tag itself. An element may be deflated; a
matrix is an element of elements: flags, dimensions, name, and what its class wants. Sizes and depths are checked before
anything is made from them (other readers recurse into nested cells until the process dies).
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError
from .files import read_bytes

HEADER = 128  # bytes before the first element; of the format
MOST_BYTES = 64 << 20  # of a file, and unpacked; chosen for memory
DEEPEST = 16  # levels of nesting; chosen, lest a broken file go on for ever
MATRIX, DEFLATED = 14, 15  # codes of elements; of the format
STORED = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
    16: "u1",
    17: "u2",
}
CELL, STRUCT, CHAR = 1, 2, 4  # codes of classes; of the format
NUMBERS = range(6, 16)  # codes of classes; of the format
COMPLEX = 0x08  # flag of an array with imaginary parts; of the format


class Element(NamedTuple):
    """kind as in `STORED`, `MATRIX` or `DEFLATED`; its data; where the next one begins."""

    kind: int
    data: memoryview
    after: int


class MalformedFile(Exception):
    """What the file says cannot be."""


def read_mat5(path: Path | str) -> dict[str, Any]:
    """The variables of a MAT file by name.

    Numbers are arrays (float64, dimensions as in MATLAB), texts str, structures dict (arrays of them: a list),
    cells list; None stands for kinds that are not read, such as sparse matrices and objects.

    Raises:
        KinemarkError: the file is absent, too large, of another version, cut off, or contradicts itself.
    """
    data = memoryview(read_bytes(path, most=MOST_BYTES))
    order = {b"IM": "<", b"MI": ">"}.get(bytes(data[126:128]))
    if order is None or struct.unpack(order + "H", data[124:126])[0] != 0x0100:
        raise KinemarkError(f"{path} is no MAT file of version 5 to 7. Save it with MATLAB's save(…, '-v7').")
    try:
        return _variables(data[HEADER:], order)
    except (MalformedFile, struct.error, zlib.error, ValueError, OverflowError) as error:
        raise KinemarkError(f"{path} is damaged: {error}. Copy it again, or save it anew.") from error


def _variables(data: memoryview, order: str) -> dict[str, Any]:
    variables: dict[str, Any] = {}
    at, left = 0, MOST_BYTES
    while at + 8 <= len(data):
        element = _element(data, at, order)
        at = element.after
        if element.kind == DEFLATED:
            inflater = zlib.decompressobj()
            inflated = inflater.decompress(element.data, left)
            if inflater.unconsumed_tail:
                raise MalformedFile(f"it unpacks to more than {MOST_BYTES} bytes")
            left -= len(inflated)
            element = _element(memoryview(inflated), 0, order)
        if element.kind == MATRIX:
            name, value = _matrix(element.data, order, 0)
            variables[name] = value
    return variables


def _element(data: memoryview, at: int, order: str) -> Element:
    first, size = struct.unpack(order + "II", data[at : at + 8])
    small = first >> 16
    if small:
        kind, size, begin, after = first & 0xFFFF, small, at + 4, at + 8
    else:
        kind, begin = first, at + 8
        after = begin + size + (0 if first == DEFLATED else -size % 8)
    if small > 4 or begin + size > len(data):
        raise MalformedFile(f"an element of {size} bytes reaches beyond the end")
    return Element(kind, data[begin : begin + size], after)


def _parts(data: memoryview, order: str) -> list[Element]:
    """All elements of a matrix."""
    parts, at = [], 0
    while at + 8 <= len(data):
        parts.append(_element(data, at, order))
        at = parts[-1].after
    return parts


def _matrix(data: memoryview, order: str, depth: int) -> tuple[str, Any]:
    if depth > DEEPEST:
        raise MalformedFile(f"it is nested more than {DEEPEST} deep")
    parts = _parts(data, order)
    if len(parts) < 3:
        return "", np.zeros((0, 0))  # how MATLAB writes what was never set
    flags = _first(parts[0], order)
    shape = tuple(int(n) for n in _stored(parts[1], order))
    name = bytes(parts[2].data).decode("ascii")
    if len(shape) < 2 or min(shape) < 0:
        raise MalformedFile(f"the dimensions of {name!r} are {shape}")
    return name, _value(flags, shape, parts[3:], order, depth)


def _value(flags: int, shape: tuple[int, ...], parts: list[Element], order: str, depth: int) -> Any:
    kind = flags & 0xFF
    if kind in NUMBERS and parts and not (flags >> 8) & COMPLEX:
        return _shaped(_stored(parts[0], order).astype(np.float64), shape)
    if kind == CHAR and parts:
        return _text(parts[0], shape, order)
    if kind == CELL:
        return [_matrix(part.data, order, depth + 1)[1] for part in parts if part.kind == MATRIX]
    if kind == STRUCT and len(parts) >= 2:
        names = _field_names(parts[0], parts[1], order)
        values = [_matrix(part.data, order, depth + 1)[1] for part in parts[2:] if part.kind == MATRIX]
        if not names:
            return {}
        rows = [dict(zip(names, values[i : i + len(names)], strict=True)) for i in range(0, len(values), len(names))]
        return rows[0] if len(rows) == 1 else rows
    return None


def _field_names(length: Element, names: Element, order: str) -> list[str]:
    size = _first(length, order)
    if not 0 < size <= 256 or len(names.data) % size:
        raise MalformedFile(f"its field names have {size} letters")
    raw = bytes(names.data)
    return [raw[i : i + size].split(b"\0")[0].decode("ascii") for i in range(0, len(raw), size)]


def _text(part: Element, shape: tuple[int, ...], order: str) -> str:
    """Rows of letters, joined by line ends."""
    letters = _shaped(_stored(part, order).astype(np.uint32), shape)
    rows = letters.reshape(letters.shape[0], -1) if letters.size else np.zeros((0, 0), np.uint32)
    return "\n".join("".join(chr(int(c)) for c in row) for row in rows)


def _stored(part: Element, order: str) -> NDArray[Any]:
    if part.kind not in STORED:
        raise MalformedFile(f"numbers are of an unknown type, {part.kind}")
    dtype = np.dtype(order + STORED[part.kind])
    if len(part.data) % dtype.itemsize:
        raise MalformedFile(f"{len(part.data)} bytes are no whole number of {dtype}")
    return np.frombuffer(part.data, dtype)


def _first(part: Element, order: str) -> int:
    """The first of the numbers."""
    values = _stored(part, order)
    if not values.size or not np.isfinite(values[0]):
        raise MalformedFile("a number that the rest depends on is missing")
    return int(values[0])


def _shaped(values: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    if values.size != np.prod(shape, dtype=np.float64):
        raise MalformedFile(f"{values.size} numbers do not fill dimensions {shape}")
    return values.reshape(shape, order="F")
