"""Walking through a TDF file without ever leaving it.

A TDF file is little endian: a header of 64 bytes (16 of signature, int32 version, int32 entries), then one
entry of 288 bytes a block: int32 type, format, offset and size, and what we do not need. Format 0 is an empty entry.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ...data import KinemarkError
from ..cut_off import AGAIN
from ..files import read_bytes

SIGNATURE = bytes.fromhex("824b6041d31184ca6000b6ac16680c08")
HEADER, ENTRY = 64, 288  # bytes of the header, and of an entry in its table; of the format
SPARE_BYTES, SPARSENESS = 1 << 26, 64
"""A block may unfold to 64 MiB, or to 64 times its file: enough for the sparsest real tracks, too little for harm.
Chosen."""


EARLIEST = 631_152_000  # s after 1970 before which no such file was made: 1990; chosen


class UnreadableBlock(KinemarkError):
    """A block that cannot be read; `why` goes on from "it"."""

    def __init__(self, block: str, why: str) -> None:
        super().__init__(
            f"{block} {why}. Export the recording again, or leave this part out with the parameter `parts`."
        )
        self.why = why


@dataclass(slots=True)
class Cursor:
    """A place in one block; every read is checked against the block's end.

    `notes` has what was odd in it, `cut` whether the file ends before it does.
    """

    name: str
    data: memoryview
    format: int
    file_size: int
    at: int = 0
    notes: list[str] = field(default_factory=list)
    cut: bool = False

    def take(self, dtype: DTypeLike, n: int = 1) -> NDArray[Any]:
        """The next n values.

        Raises:
            KinemarkError: n is negative or the block ends before.
        """
        size = np.dtype(dtype).itemsize * n
        if n < 0 or self.at + size > len(self.data):
            raise self.bad(f"has {len(self.data) - self.at} bytes left where {max(size, n)} are promised")
        self.at += size
        return np.frombuffer(self.data[self.at - size : self.at], dtype)

    def integer(self) -> int:
        """The next int32."""
        return int(self.take("<i4")[0])

    def real(self) -> float:
        """The next float32."""
        return float(self.take("<f4")[0])

    def text(self, n: int = 256) -> str:
        """The next n bytes as a label, up to the first zero byte."""
        return _text(self.take("u1", n).tobytes())

    def room(self, *shape: int) -> None:
        """Check that an array of float64 of this shape may be made.

        Raises:
            KinemarkError: a dimension is negative, or the array is out of all proportion to the file.
        """
        if min(shape) < 0 or float(np.prod(shape, dtype=float)) * 8 > max(SPARE_BYTES, SPARSENESS * self.file_size):
            raise self.bad(f"promises {' × '.join(map(str, shape))} values, out of proportion to its size")

    def rate(self) -> float:
        """The next int32 as samples a second."""
        if (rate := self.integer()) <= 0:
            raise self.bad(f"states a rate of {rate} Hz, wanted a positive one")
        return float(rate)

    def wanted(self, *formats: int) -> None:
        """Check the block's format."""
        if self.format not in formats:
            raise self.bad(f"has format {self.format}; the formats read are {', '.join(map(str, formats))}")

    def bad(self, why: str) -> UnreadableBlock:
        """The error that says what is wrong with this block."""
        return UnreadableBlock(self.name, why)


def _text(raw: bytes) -> str:
    """Text up to the first zero byte."""
    return raw.split(b"\0")[0].decode("cp1252", "replace").strip()


class TdfFile(NamedTuple):
    """The first block of every type, and what the file says of itself: its date, comments on its blocks."""

    blocks: dict[int, Cursor]
    about: dict[str, str]


def open_tdf(path: Path | str, *, partial: bool = False) -> TdfFile:
    """A TDF file, whose blocks are not yet read; where `partial`, also one that ends within a block or before it.

    Raises:
        KinemarkError: the file is absent, empty, truncated, or no TDF of version 1.
    """
    data = memoryview(read_bytes(path))
    if bytes(data[:16]) != SIGNATURE or len(data) < HEADER:
        raise KinemarkError(f"{path} is not a TDF file: it does not begin with the signature of BTS. Check the path.")
    version, n = np.frombuffer(data[16:24], "<i4")
    if version != 1 or not 0 <= n <= (len(data) - HEADER) // ENTRY:
        raise KinemarkError(
            f"{path} has version {version} with {n} blocks in {len(data)} bytes, wanted version 1 with all its blocks. "
            "Copy or export it again."
        )
    entries = np.frombuffer(data[HEADER : HEADER + n * ENTRY], "<i4").reshape(n, ENTRY // 4)[:, :4]
    found: dict[int, Cursor] = {}
    made = int(np.frombuffer(data[32:36], "<i4")[0])
    about = {"date": datetime.fromtimestamp(made, UTC).isoformat()[:19]} if made > EARLIEST else {}
    for i, (kind, form, offset, size) in enumerate(entries.tolist()):
        if form != 0 and kind not in found:
            if offset < HEADER or size < 0 or (offset + size > len(data) and not partial):
                raise KinemarkError(
                    f"{path} is truncated: its block of type {kind} lies at bytes {offset} … {offset + size}, "
                    f"the file has {len(data)}. {AGAIN}"
                )
            name = f"{path}: the block of type {kind}"
            found[kind] = Cursor(name, data[offset : offset + size], form, len(data), cut=offset + size > len(data))
            at = HEADER + i * ENTRY + 32
            if comment := _text(bytes(data[at : at + 256])):
                about[f"comment on block {kind}"] = comment
    return TdfFile(found, about)
