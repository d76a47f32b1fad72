"""How many numbers there are: header, parameters and the size of the file often disagree.

A frame holds 4 numbers a point and one a sample of each channel. The counts stand in the header and again in the
parameters; both are words of 16 bits, so more than 65 535 frames wrap, or stop there, or are stated as a float. Of all
consistent readings the first is taken that fills the file up to its last block; where none does, the first that
stands in the file, so that a truncated file is seen as such.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from .document import C3D
from .header import C3DHeader
from .parameters import BLOCK

MOST_FRAMES = 2**31  # above which a count is nonsense; of the format: signed words of 32 bits


@dataclass(frozen=True, slots=True)
class Layout:
    """Shape of the data section: frames of `points` points and `channels` channels with `samples` samples each."""

    points: int
    channels: int
    samples: int
    frames: int
    first_frame: int

    @property
    def width(self) -> int:
        """Numbers a frame."""
        return 4 * self.points + self.channels * self.samples


def layout_of(header: C3DHeader, doc: C3D, space: int) -> Layout:
    """The shape of `space` bytes of data; it may need more than there are.

    Args:
        header: the first block.
        doc: a document with the parameters and the number format, without data.
        space: bytes from the start of the data to the end of the file.
    """
    size = 4 if doc.floats else 2
    shapes = [
        (points, channels, samples)
        for points, (channels, samples) in product(_points(header, doc), _analog(header, doc))
    ]
    readings = [
        Layout(*shape, frames, _first(header, doc))
        for shape in shapes
        for frames in _frames(header, doc, space // max(1, size * Layout(*shape, 0, 0).width))
    ]
    return next((r for r in readings if 0 <= space - r.frames * r.width * size < BLOCK), readings[0])


def _count(doc: C3D, group: str, name: str) -> int | None:
    """First value of a parameter as a count: 16-bit integers unsigned; None where it cannot be one."""
    parameter = doc.get(group, name)
    value = float(parameter.unsigned[0]) if parameter is not None and parameter.unsigned.size else -1.0
    return int(value) if 0 <= value < MOST_FRAMES else None


def _distinct(values: Sequence[int | None]) -> list[int]:
    return list(dict.fromkeys(value for value in values if value is not None))


def _points(header: C3DHeader, doc: C3D) -> list[int]:
    return _distinct([_count(doc, "POINT", "USED"), header.n_points])


def _analog(header: C3DHeader, doc: C3D) -> list[tuple[int, int]]:
    """Channels and samples a frame."""
    used, numbers = _count(doc, "ANALOG", "USED"), header.n_analog
    ratio = doc.number("ANALOG", "RATE", 0) / doc.rate if doc.rate > 0 else 0
    per_frame = round(ratio) if 0 <= ratio < 65536 else 0
    found = []
    if used and numbers % used == 0:
        found.append((used, numbers // used))
    if used:
        found += [(used, s) for s in (header.samples, per_frame) if s]
    if not used or not found or numbers == 0:
        samples = header.samples if numbers % max(header.samples, 1) == 0 and (header.samples or not numbers) else 1
        found.append((numbers // max(samples, 1), samples))
    if used == 0:
        found.append((0, header.samples))
    return list(dict.fromkeys(found))


def _first(header: C3DHeader, doc: C3D) -> int:
    """Number of the first frame; TRIAL adds the high bits that the header lacks."""
    start = _field(doc, "ACTUAL_START_FIELD")
    same = start is not None and header.first in (start & 0xFFFF, min(start, 65535))
    return start if start is not None and same else header.first


def _field(doc: C3D, name: str) -> int | None:
    """A frame of the TRIAL group: two words, low and high, or one number."""
    parameter = doc.get("TRIAL", name)
    words = [] if parameter is None else parameter.unsigned.tolist()
    value = words[0] + 65536 * words[1] if len(words) == 2 else words[0] if words else -1
    return int(value) if 0 <= value < MOST_FRAMES else None


def _frames(header: C3DHeader, doc: C3D, room: int) -> list[int]:
    """Numbers of frames that the file may mean, the most trustworthy first; at most `room` fit."""
    start, end = _field(doc, "ACTUAL_START_FIELD"), _field(doc, "ACTUAL_END_FIELD")
    trial = None if start is None or end is None or not 0 < start <= end else end - start + 1
    stated = _count(doc, "POINT", "FRAMES")
    ranged = header.last - header.first + 1 if header.first <= header.last + 1 and header.last < 65535 else None
    words = [n for n in (ranged, stated) if n is not None]
    wrapped = [n + 65536 * ((room - n) // 65536) for n in words if n < 65536 < room]
    stopped = room if header.last == 65535 or stated == 65535 else None
    return _distinct([trial, _count(doc, "POINT", "LONG_FRAMES") or None, *words, *wrapped, stopped]) or [0]
