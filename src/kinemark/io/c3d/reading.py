"""A C3D file from disk, as it stands.

Two statements of a file may contradict each other: whether it holds floats or integers, and of which scale. The scale
stands in the header and in POINT:SCALE; below zero it says that points and channels are floats. Some writers
leave one of the two positive, zero or without sense. What fills the file up to its last block is then right.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data import KinemarkError
from ..files import read_bytes
from ..notes import UNREADABLE
from .analog_rates import SAME_RATE
from .document import C3D, has_unsigned_analog
from .header import C3DHeader, byte_order, decode_header, parameter_offset
from .layout import Layout, layout_of
from .numbers import ByteOrder, decode_floats, decode_words
from .parameters import BLOCK, Group, decode_parameters
from .rotations import WIDTH, RotationTable, rotation_table, rotations_in
from .sample_table import section_in, section_start
from .writing import with_counts

LEAST, MOST = 1e-12, 1e4
"""Units a count that a writer may mean; chosen, metres in 32 768 counts to thousands of mm a count and far beyond."""


def number_format(doc: C3D, header: C3DHeader, space: int) -> tuple[C3D, tuple[str, ...]] | None:
    """The document with `floats` and `scale`, and what was odd; None where the file does not tell.

    Args:
        doc: the document with its parameters, without data. header: the first block.
        space: bytes from the start of the data to where they may end.
    """
    both = (doc.number("POINT", "SCALE", 0.0), header.scale)
    stated = [scale for scale in both if math.isfinite(scale) and scale != 0]
    ways = list(dict.fromkeys(scale < 0 for scale in stated)) or [True, False]
    fitting = [floats for floats in ways if _fits(replace(doc, floats=floats), header, space)]
    if not stated and len(fitting) != 1:
        return None
    floats = (fitting or ways)[0]
    scales = sorted((abs(s) for s in stated), key=lambda s: not LEAST <= s <= MOST)  # stable: POINT:SCALE comes first
    scale = scales[0] if scales and (not floats or scales[0] <= MOST) else 1.0
    kind = "floats" if floats else "integers"
    odd = any(abs(s) != scale or (s < 0) != floats for s in both if s is not both[0] or doc.get("POINT", "SCALE"))
    note = f"scale: the header says {both[1]:g}, POINT:SCALE {both[0]:g}; taken as {kind} of scale {scale:g}"
    return replace(doc, floats=floats, scale=scale), (note,) if odd and doc.groups else ()


def _fits(doc: C3D, header: C3DHeader, space: int) -> bool:
    """Whether numbers of this size fill the space up to its last block."""
    layout = layout_of(header, doc, space)
    return 0 <= space - layout.frames * layout.width * (4 if doc.floats else 2) < BLOCK


MOST_BLOCKS = 65535  # of a parameter section; chosen, the most that a word of 16 bits counts


def read_document(path: Path | str, *, partial: bool = False) -> C3D:
    """All that a C3D file holds, in the file's own units and conventions.

    Args:
        path: the file.
        partial: read what there is of a file that was cut off or damaged, and say in `notes` what is not.
            Otherwise such a file is refused.

    Raises:
        KinemarkError: the file is none, not C3D, contradicts itself, or has lost something and `partial` is false.
    """
    return decode_document(read_bytes(path), name=str(path), partial=partial)


def decode_document(raw: bytes, *, name: str, partial: bool = False) -> C3D:
    """As `read_document`, with its errors, from the bytes of the file; `name` is for messages."""
    start = parameter_offset(raw, name=name)
    order = byte_order(raw, start, name=name)
    header = decode_header(raw, order)
    stated = (header.data_block - 1) * BLOCK
    sound = start < stated <= len(raw)
    groups, lost, odd = decode_parameters(raw[start + 4 : stated if sound else start + MOST_BLOCKS * BLOCK], order)
    doc = _without_data(header, order, groups)
    end = stated if sound else _data_start(doc, header, start, raw, name)
    table = rotation_table(doc)
    starts = (table.start if table else 0, section_start(doc))
    space = min((at for at in starts if end < at <= len(raw)), default=len(raw)) - end
    if (found := number_format(doc, header, space)) is None:
        raise KinemarkError(f"{name} states the scale {header.scale}: whether it holds floats or integers is unknown.")
    doc, scaling = found
    layout = layout_of(header, doc, space)
    size = (4 if doc.floats else 2) * layout.width
    held = min(layout.frames, space // size) if size else layout.frames
    if held < layout.frames:
        lost = (*lost, f"frames {held + 1} to {layout.frames} of {layout.frames}, for the file ends")
    doc, absent = _with_rest(doc, table, raw, layout.frames, end + size * layout.frames)
    lost = (*lost, *absent)
    if lost and not partial:
        raise KinemarkError(
            f"{name} ({len(raw)} bytes) is cut off or damaged. Unreadable: {'; '.join(lost)}. "
            "Copy or export it again, or write what is left to another file: kinemark convert FROM TO --partial."
        )
    unread = len(doc.tail) if doc.tail.strip(b"\0") else 0  # some programs fill up with a block of zeros
    oddities = _oddities(doc, header, layout, end, unread)
    notes = (*(UNREADABLE + what for what in lost), *odd, *oddities, *scaling)
    doc = replace(doc, first_frame=layout.first_frame, data_block=end // BLOCK + 1, notes=notes)
    doc = _with_data(doc, replace(layout, frames=held), np.frombuffer(raw, np.uint8, size * held, end))
    return with_counts(doc) if held < layout.frames else doc


def _without_data(header: C3DHeader, order: ByteOrder, groups: tuple[Group, ...]) -> C3D:
    """The document with all but its points and analog, and their number format."""
    none = np.zeros((0, 0))
    bare = C3D(order, True, 0.0, np.zeros((0, 0, 3)), none, none, 0, groups)
    rates = (bare.number("POINT", "RATE", 0.0), header.rate)
    return replace(
        bare,
        rate=next((rate for rate in rates if math.isfinite(rate) and rate > 0), 0.0),
        max_gap=header.max_gap,
        header_events=header.events,
        reserved=header.reserved,
    )


def _with_rest(
    doc: C3D, table: RotationTable | None, raw: bytes, frames: int, stop: int
) -> tuple[C3D, tuple[str, ...]]:
    """The document with what follows the last frame, which ends before byte `stop`, and what of it the file lacks."""
    absent: tuple[str, ...] = ()
    between, end = b"", stop
    if table is not None:
        samples, first, end = rotations_in(doc, table, raw, frames, stop)
        between = raw[stop + -stop % BLOCK : first]
        if end - first < frames * table.ratio * table.used * 4 * WIDTH:
            absent = (f"rotations of {table.used} segments, for the file ends",)
        doc = replace(doc, rotations=samples)
    section, end = section_in(doc, raw, end)
    if table is not None or section:
        kept = (between if any(between) else b"") + raw[end + -end % BLOCK :]
        return replace(doc, sample_table=section, tail=kept), absent
    if section_start(doc):
        absent = (*absent, "the covariances of the markers, for the file ends")
    return replace(doc, tail=raw[stop:] if len(raw) - stop >= BLOCK else b""), absent


def _data_start(doc: C3D, header: C3DHeader, start: int, raw: bytes, name: str) -> int:
    """First byte of the data where the header's pointer is useless."""
    block = int(np.nan_to_num(_unsigned(doc, "POINT", "DATA_START") or 0))
    if not start < (block - 1) * BLOCK <= len(raw):
        raise KinemarkError(
            f"{name} has {len(raw)} bytes, but its data begin in block {header.data_block} by the header and in block "
            f"{block} by POINT:DATA_START (of 512 bytes, from 1). Copy or export it again."
        )
    return (block - 1) * BLOCK


def _oddities(doc: C3D, header: C3DHeader, layout: Layout, end: int, rest: int) -> tuple[str, ...]:
    """Where the file contradicts itself, in words."""
    said = {
        "block of the data": (end // BLOCK + 1, header.data_block, _unsigned(doc, "POINT", "DATA_START")),
        "points": (layout.points, header.n_points, _unsigned(doc, "POINT", "USED")),
        "frames": (layout.frames, header.last - header.first + 1, _unsigned(doc, "POINT", "FRAMES")),
        "analog channels": (layout.channels, layout.channels, _unsigned(doc, "ANALOG", "USED")),
    }
    notes = [
        f"{what}: the header says {ours}, the parameters {theirs}; taken as {taken}"
        for what, (taken, ours, theirs) in said.items()
        if ours != taken or theirs not in (None, taken)
    ]
    rates = (header.rate, doc.number("POINT", "RATE", header.rate))
    if abs(rates[0] - rates[1]) > SAME_RATE * max(rates) and min(rates) > 0:
        notes.append(f"frame rate: the header says {rates[0]:g} Hz, POINT:RATE {rates[1]:g}; taken as {doc.rate:g}")
    if not doc.groups:
        notes.append("no parameters; all is taken from the header")
    if rest:
        notes.append(f"{rest} bytes after the last frame are not understood; they are kept as they are")
    return tuple(notes)


def _unsigned(doc: C3D, group: str, name: str) -> float | None:
    parameter = doc.get(group, name)
    return float(parameter.unsigned[0]) if parameter is not None and parameter.unsigned.size else None


def _with_data(doc: C3D, layout: Layout, raw: NDArray[np.uint8]) -> C3D:
    """The document with its points and analog taken from the bytes of whole frames."""
    f, m, a, s = layout.frames, layout.points, layout.channels, layout.samples
    numbers: NDArray[Any] = decode_floats(raw, doc.order) if doc.floats else decode_words(raw, doc.order)
    frames = numbers.reshape(f, layout.width)
    points = frames[:, : 4 * m].reshape(f, m, 4)
    xyz = points[..., :3].astype(np.float64)
    analog = frames[:, 4 * m :].reshape(f, s, a)
    if not doc.floats:
        xyz *= doc.scale
        analog = analog.view(np.uint16) if has_unsigned_analog(doc) else analog
    channels = analog.transpose(2, 0, 1).astype(np.float64, order="C").reshape(a, f * s)
    return replace(doc, points=xyz, word=points[..., 3], analog=channels, samples=s)
