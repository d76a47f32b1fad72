"""A C3D file to disk, as the document says."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from ...data.array_types import Floats
from ..files import replacing
from .document import C3D, has_unsigned_analog, with_parameters
from .header import C3DHeader, encode_header
from .layout import Layout, layout_of
from .numbers import encode_floats, encode_words
from .parameters import BLOCK, Parameter, encode_parameters
from .provenance import GROUP
from .rotations import encode_rotations, with_rotation_start
from .sample_table import START, with_section_start

AT_ONCE = 4096
"""Frames encoded in one go; chosen for memory."""


def write_document(path: Path | str, doc: C3D) -> None:
    """Write the document; parameters that count points, channels or frames are put right where they are not.

    Raises:
        ValueError: the document holds what C3D cannot.
        KinemarkError: the file cannot be written.
    """
    pieces = _pieces(doc)
    with replacing(path) as beside, beside.open("wb") as file:
        file.writelines(pieces)


def encode_document(doc: C3D) -> bytes:
    """The bytes of the file; the inverse of `decode_document`.

    Raises:
        ValueError: there are more points, channels, samples or frames than the format counts.
    """
    return b"".join(_pieces(doc))


def _pieces(doc: C3D) -> Iterable[bytes]:
    """The bytes of the file, some frames after the others."""
    layout = _layout(doc)
    m = layout.points
    if not (
        0 <= m <= 65535 and len(doc.analog) <= 65535 and 0 <= doc.samples <= 65535 and 0 <= doc.first_frame < 2**31
    ):
        raise ValueError(f"C3D holds 65 535 points, channels and samples a frame, found {layout}")
    data, behind = _encode_data(doc), [_in_blocks(encode_rotations(doc)), _in_blocks(doc.sample_table)]
    size, rest = layout.frames * layout.width * (4 if doc.floats else 2), b""
    # Where there are many frames, some readers count them by the size of the file.
    if any(behind) or (layout.first_frame + layout.frames <= 65535 and not doc.tail):
        rest = bytes(-size % BLOCK)
        size += len(rest)
    if not _counts_agree(doc, layout, size + (0 if any(behind) else len(doc.tail))):
        doc = with_counts(doc)
    blocks = size // BLOCK
    doc, section = _placed(doc, (blocks, blocks + len(behind[0]) // BLOCK))
    spare = bytes((doc.data_block - 1) * BLOCK - BLOCK - len(section))
    return chain([encode_header(_header(doc, layout), doc.order), section, spare], data, [rest, *behind, doc.tail])


def _header(doc: C3D, layout: Layout) -> C3DHeader:
    numbers, last = layout.channels * layout.samples, layout.first_frame + layout.frames - 1
    counts = (layout.points, numbers & 0xFFFF, min(layout.first_frame, 65535), max(0, min(last, 65535)), doc.max_gap)
    scale = -doc.scale if doc.floats else doc.scale
    return C3DHeader(*counts, scale, doc.data_block, doc.samples, doc.rate, doc.header_events, doc.reserved)


def _counts_agree(doc: C3D, layout: Layout, size: int) -> bool:
    """Whether a reader will find the shape, the format, the scale and the rate that the document has."""
    signed = doc.number("POINT", "SCALE", -doc.scale if doc.floats else doc.scale)
    scale_agrees = np.float32(signed) == np.float32(-doc.scale if doc.floats else doc.scale)
    rate_agrees = np.float32(doc.number("POINT", "RATE", doc.rate)) == np.float32(doc.rate)
    return scale_agrees and rate_agrees and layout_of(_header(doc, layout), doc, size) == layout


def _layout(doc: C3D) -> Layout:
    return Layout(doc.points.shape[1], len(doc.analog), doc.samples, len(doc.points), doc.first_frame)


def with_counts(doc: C3D) -> C3D:
    """The document with the parameters that say how many, from when, how often and in which format."""
    layout = _layout(doc)
    first, frames = layout.first_frame, layout.frames
    ends = [[n & 0xFFFF, n >> 16] for n in (first, max(first + frames - 1, 0))]
    point = [
        Parameter.whole("USED", layout.points),
        Parameter.whole("FRAMES", min(frames, 65535)),
        Parameter.real("SCALE", -doc.scale if doc.floats else doc.scale),
        Parameter.real("RATE", doc.rate),
        Parameter.whole("DATA_START", doc.data_block),
    ]
    if frames > 65535 or doc.get("POINT", "LONG_FRAMES") is not None:
        point.append(Parameter.real("LONG_FRAMES", frames))
    doc = with_parameters(doc, "POINT", point)
    analog = [Parameter.whole("USED", layout.channels), Parameter.real("RATE", _analog_rate(doc.rate, layout.samples))]
    doc = with_parameters(doc, "ANALOG", analog)
    trial = [Parameter.whole(f"ACTUAL_{which}_FIELD", n) for which, n in zip(("START", "END"), ends, strict=True)]
    return with_parameters(doc, "TRIAL", trial)


def _analog_rate(rate: float, samples: int) -> np.float32:
    """Of channels with so many samples a frame, Hz: not below so many times the frames' rate as it is stored.

    Some readers round the ratio of the two down and would leave out a sample of every frame.
    """
    least = float(np.float32(rate)) * samples
    near = np.float32(least)
    return near if float(near) >= least else np.nextafter(near, np.float32(np.inf))


def _in_blocks(raw: bytes) -> bytes:
    """Bytes filled up to whole blocks."""
    return raw + bytes(-len(raw) % BLOCK)


def _with_starts(doc: C3D, blocks: tuple[int, int]) -> C3D:
    """The document that says where its rotations and its own section begin, so many blocks behind its data block."""
    if doc.rotations.size:
        doc = with_rotation_start(doc, doc.data_block + blocks[0])
    if doc.sample_table or doc.get(GROUP, START) is not None:
        doc = with_section_start(doc, doc.data_block + blocks[1] if doc.sample_table else 0)
    return doc


def _placed(doc: C3D, blocks: tuple[int, int]) -> tuple[C3D, bytes]:
    """The document with a data block behind its parameters, and these encoded with their head.

    Args:
        doc: the document. blocks: from the data block to its rotations and to its own section.
    """
    doc = _with_starts(doc, blocks)
    body = encode_parameters(doc.groups, doc.order)
    needed = 2 + -(-(len(body) + 4) // BLOCK)
    if needed > 65535:
        raise ValueError(f"the parameters take {len(body)} bytes; C3D has room for 33 million")
    moved = replace(doc, data_block=max(needed, doc.data_block))
    pointer = doc.get("POINT", "DATA_START")
    if moved.data_block != doc.data_block:
        if pointer is not None:
            start = Parameter.whole("DATA_START", np.full(pointer.values.shape, moved.data_block))
            moved = with_parameters(moved, "POINT", [start])
        moved = _with_starts(moved, blocks)
        body = encode_parameters(moved.groups, doc.order)
    return moved, bytes([1, 0x50, min(moved.data_block - 2, 255), doc.order]) + body


def _encode_data(doc: C3D) -> Iterator[bytes]:
    """The frames, some at a time: all at once take the file's memory twice."""
    return (_encode_frames(doc, slice(k, k + AT_ONCE)) for k in range(0, len(doc.points), AT_ONCE))


def _encode_frames(doc: C3D, at: slice) -> bytes:
    """The bytes of some frames."""
    xyz, word = doc.points[at], doc.word[at]
    f, m, _ = xyz.shape
    a, s = len(doc.analog), doc.samples
    frames = np.empty((f, 4 * m + a * s), np.float32 if doc.floats else np.int64)
    points = frames[:, : 4 * m].reshape(f, m, 4)
    samples = doc.analog.reshape(a, len(doc.points), s)[:, at].transpose(1, 2, 0).reshape(f, s * a)
    if doc.floats:
        points[..., :3], points[..., 3], frames[:, 4 * m :] = xyz, word, samples
        return encode_floats(frames.reshape(-1), doc.order).tobytes()
    points[..., :3] = _whole("points", xyz / doc.scale)
    points[..., 3] = _whole("word", word)
    frames[:, 4 * m :] = _whole("analog", samples, 0 if has_unsigned_analog(doc) else -32768)
    return encode_words(frames.reshape(-1), doc.order).tobytes()


def _whole(name: str, values: Floats, least: int = -32768) -> Floats:
    """The nearest integers of 16 bits from `least` on."""
    whole = np.rint(values)
    if not ((whole >= least) & (whole <= least + 65535)).all():
        raise ValueError(f"{name} holds numbers beyond {least} … {least + 65535}; enlarge the scale or write floats")
    return whole
