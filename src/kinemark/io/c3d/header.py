"""The first block of the file: 256 words of 16 bits, numbered from 1 as the format's manual does.

| word | what |
| --- | --- |
| 1 | low byte: block of the parameter section; high byte: 0x50 |
| 2, 3 | points; analog numbers a frame, that is channels × samples a frame |
| 4, 5, 6 | first and last frame; longest gap to interpolate |
| 7–8 | scale, float; negative when the data are floats |
| 9, 10 | block of the data; analog samples a frame |
| 11–12 | frames a second, float |
| 150, 151 | 12 345 where events have names of four characters; number of events |
| 153–188, 189–197, 199–234 | their times (s), flags (a byte each) and names |

All else is kept as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data import KinemarkError
from .numbers import ByteOrder, decode_floats, decode_words, encode_floats, encode_words
from .parameters import BLOCK

MOST_EVENTS = 18  # events in a header; of the format
NAMED_EVENTS = 12345  # word that says that events have names of four letters; of the format
_TIMES, _FLAGS, _LABELS = 304, 376, 396  # bytes at which times, flags and names of events begin; of the format


@dataclass(frozen=True, slots=True)
class HeaderEvent:
    """An event in the header.

    Attributes:
        label: at most four characters.
        time: s, as single precision holds it.
        flag: 0 shown, 1 hidden.
    """

    label: str
    time: float
    flag: int = 0


@dataclass(frozen=True, slots=True)
class C3DHeader:
    """What the first block says; counts as unsigned words, frames as they stand.

    Attributes:
        n_points: points a frame; n_analog: analog numbers a frame.
        first, last: frames; max_gap: frames.
        scale: negative for floats.
        data_block: block of the data, from 1; samples: analog samples a frame.
        rate: Hz.
        events: at most 18.
        reserved: the block with all these facts set to zero.
    """

    n_points: int
    n_analog: int
    first: int
    last: int
    max_gap: int
    scale: float
    data_block: int
    samples: int
    rate: float
    events: tuple[HeaderEvent, ...]
    reserved: bytes


def parameter_offset(raw: bytes, *, name: str) -> int:
    """Byte at which the parameter section begins.

    Raises:
        KinemarkError: the file is shorter than its header or is not a C3D file.
    """
    if len(raw) < BLOCK:
        raise KinemarkError(f"{name} has {len(raw)} bytes, fewer than a C3D header of 512. Copy or export it again.")
    start = (raw[0] - 1) * BLOCK
    if raw[1] != 0x50 or start < BLOCK:
        raise KinemarkError(f"{name} begins with bytes {raw[0]}, {raw[1]}; a C3D file has 2, 80. Is it another format?")
    if start + 4 > len(raw):
        raise KinemarkError(
            f"{name} ends at byte {len(raw)}, before its parameters at {start}. Copy or export it again."
        )
    return start


def byte_order(raw: bytes, start: int, *, name: str) -> ByteOrder:
    """The processor of the file.

    Raises:
        KinemarkError: its number is none that the format knows.
    """
    if raw[start + 3] not in ByteOrder.__members__.values():
        known = "84 (Intel), 85 (DEC) or 86 (SGI)"
        raise KinemarkError(f"{name} names the processor {raw[start + 3]}, wanted {known}. Export it again.")
    return ByteOrder(raw[start + 3])


def decode_header(raw: bytes, order: ByteOrder) -> C3DHeader:
    """The facts in the first 512 bytes."""
    block = np.frombuffer(raw[:BLOCK], np.uint8)
    word = [int(w) for w in decode_words(block, order, signed=False)]
    n_events = min(word[150], MOST_EVENTS) if word[149] == NAMED_EVENTS else 0
    times = decode_floats(block[_TIMES : _TIMES + 4 * n_events], order)
    labels = [raw[_LABELS + 4 * i : _LABELS + 4 * i + 4].decode("latin-1") for i in range(n_events)]
    events = tuple(HeaderEvent(labels[i], float(times[i]), raw[_FLAGS + i]) for i in range(n_events))
    scale, rate = (float(decode_floats(block[i : i + 4], order)[0]) for i in (12, 20))
    facts = (word[1], word[2], word[3], word[4], word[5], scale, word[8], word[9], rate)
    return C3DHeader(*facts, events, _reserved(block.copy(), n_events).tobytes())


def _reserved(block: NDArray[np.uint8], n: int) -> NDArray[np.uint8]:
    block[:24] = 0
    block[298 : 298 + 4 * (n > 0)] = 0
    for at, size in ((_TIMES, 4), (_FLAGS, 1), (_LABELS, 4)):
        block[at : at + size * n] = 0
    return block


def encode_header(header: C3DHeader, order: ByteOrder) -> bytes:
    """The first 512 bytes, with the parameter section in the second block; the inverse of `decode_header`.

    Raises:
        ValueError: more than 18 events, or a label that is longer than four characters of Latin-1.
    """
    block = np.frombuffer(header.reserved, np.uint8).copy()
    n = len(header.events)
    labels = b"".join(event.label.encode("latin-1").ljust(4) for event in header.events)
    if n > MOST_EVENTS or len(labels) > 4 * n:
        raise ValueError(f"a C3D header holds {MOST_EVENTS} events of four characters; found {header.events}")
    words = [header.n_points, header.n_analog, header.first, header.last, header.max_gap]
    block[:2] = 2, 0x50
    block[2:12] = encode_words(np.array(words), order)
    block[12:16] = encode_floats(np.array([header.scale]), order)
    block[16:20] = encode_words(np.array([header.data_block, header.samples]), order)
    block[20:24] = encode_floats(np.array([header.rate]), order)
    if n:
        block[298:302] = encode_words(np.array([NAMED_EVENTS, n]), order)
    block[_TIMES : _TIMES + 4 * n] = encode_floats(np.array([event.time for event in header.events]), order)
    block[_FLAGS : _FLAGS + n] = [event.flag for event in header.events]
    block[_LABELS : _LABELS + 4 * n] = np.frombuffer(labels, np.uint8)
    return block.tobytes()
