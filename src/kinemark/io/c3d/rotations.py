"""Rotations, as systems without markers store them: a section of its own behind points and channels.

ROTATION:USED says how many segments there are, DATA_START the block at which the section begins, RATIO (or RATE) how
many samples there are to a frame, LABELS their names. A sample is 17 floats, in files of integers too: a homogeneous
matrix 4 × 4, column by column, and its reliability, below 0 where the sample is missing. Translations have the unit of
the points.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...data import Poses, same
from ...data.array_types import Floats
from ..notes import FileNote
from .analog_rates import SAME_RATE, SAME_TIME, seconds_beyond
from .document import C3D, with_parameters
from .numbers import decode_floats, encode_floats
from .parameter_tables import matched, with_descriptions, with_text
from .parameters import BLOCK, Parameter
from .points import distinct, mm_per_unit

GROUP = "ROTATION"
WIDTH = 17  # numbers of a sample; of the format
MOST_BLOCK = 65535  # that a word of 16 bits points to; of the format


class RotationTable(NamedTuple):
    """What the parameters say: segments, samples a frame, and the first byte of the section; 0 where none is stated."""

    used: int
    ratio: int
    start: int


def rotation_table(doc: C3D) -> RotationTable | None:
    """Where a file's rotations stand; None where it has none."""
    used, block = (_count(doc, name) for name in ("USED", "DATA_START"))
    rate = doc.number(GROUP, "RATE", 0.0)
    ratio = _count(doc, "RATIO") or (round(rate / doc.rate) if 0 < rate < np.inf and doc.rate > 0 else 1)
    return RotationTable(used, max(ratio, 1), (block - 1) * BLOCK if block else 0) if used else None


def _count(doc: C3D, name: str) -> int:
    parameter = doc.get(GROUP, name)
    value = float(parameter.unsigned[0]) if parameter is not None and parameter.unsigned.size else 0.0
    return int(value) if 0 < value < 2**31 else 0


def rotations_in(doc: C3D, table: RotationTable, raw: bytes, frames: int, stop: int) -> tuple[Floats, int, int]:
    """Samples (frames × ratio, segments, 17), NaN where the file ends before; first and last-plus-one byte.

    Args:
        doc: the document without data. table: what it says of rotations.
        raw: the file. frames: their number; stop: byte after the last.
    """
    wide, n = 4 * WIDTH * table.used, frames * table.ratio
    behind = stop + -stop % BLOCK
    places = [at for at in (table.start, behind) if stop <= at and at + n * wide <= len(raw)]
    at = places[0] if places else max(table.start, behind)
    held = min(n, max(0, len(raw) - at) // wide)
    numbers = decode_floats(np.frombuffer(raw, np.uint8, held * wide, at) if held else np.zeros(0, np.uint8), doc.order)
    out = np.full((n if places else held, table.used, WIDTH), np.nan)
    out[:held] = numbers.reshape(held, table.used, WIDTH)
    return out, at, at + held * wide


def encode_rotations(doc: C3D) -> bytes:
    """The section."""
    return encode_floats(doc.rotations.reshape(-1), doc.order).tobytes()


def with_rotation_start(doc: C3D, block: int) -> C3D:
    """The document that says at which block its rotations begin."""
    make = Parameter.whole if block <= MOST_BLOCK else Parameter.real
    return with_parameters(doc, GROUP, [make("DATA_START", block)])


# As poses


def poses_of(doc: C3D) -> tuple[Poses, ...]:
    """The rotations of a document, in mm; none where it has none."""
    n, s = doc.rotations.shape[:2]
    if not n or not s or doc.rate <= 0:
        return ()
    T = doc.rotations[..., :16].reshape(n, s, 4, 4).swapaxes(2, 3).transpose(1, 0, 2, 3).copy()
    reliability = doc.rotations[..., 16].T
    T[..., :3, 3] *= mm_per_unit(doc)
    T[~(np.isfinite(T).all((2, 3)) & (reliability >= 0))] = np.nan
    names = distinct(doc.texts(GROUP, "LABELS"), s, "segment ")
    return (Poses(names, doc.rate * (n // max(len(doc.points), 1) or 1), T, reliability),)


def with_rotations(doc: C3D, source: C3D, poses: tuple[Poses, ...], *, shift: int) -> tuple[C3D, tuple[FileNote, ...]]:
    """The document with these poses, and what that changed.

    Args:
        doc: the document, with its points. source: where unchanged samples come from.
        poses: of the trial; C3D holds one record of them.
        shift: the document's first frame, counted from the source's.
    """
    if same(poses_of(source), poses) and shift == 0 and len(doc.points) == len(source.points):
        return doc, ()
    notes = tuple(FileNote("not_written", "poses", p.names) for p in poses[1:])
    if not poses:
        return _without(doc), notes
    own, ratio = poses[0], max(1, round(poses[0].rate / doc.rate))
    rate, first = ratio * doc.rate, own.start * ratio * doc.rate
    if abs(own.rate - rate) > SAME_RATE * rate or abs(first - round(first)) > SAME_TIME:
        return _without(doc), (*notes, FileNote("not_written", "poses", own.names))
    n, held = len(doc.points) * ratio, own.reliability.shape[1]
    if (beyond := seconds_beyond(own.start, held / own.rate, n / rate)) * own.rate > 1 - SAME_TIME:
        notes = (*notes, FileNote("cut", "poses", own.names, {"seconds": beyond}))
    doc = replace(doc, rotations=_on_frames(own, round(first), n, mm_per_unit(doc)))
    return _with_labels(doc, source, own, ratio, rate), notes


def _without(doc: C3D) -> C3D:
    """The document without rotations."""
    if not doc.rotations.size:
        return doc
    return with_parameters(replace(doc, rotations=np.zeros((0, 0, WIDTH))), GROUP, [Parameter.whole("USED", 0)])


def _on_frames(poses: Poses, first: int, n: int, factor: float) -> Floats:
    """(n, S, 17) as they are stored; −1 as reliability where a sample is missing."""
    out = np.full((n, len(poses), WIDTH), np.nan)
    low, high = (min(max(at, 0), n) for at in (first, first + poses.reliability.shape[1]))
    T = poses.T_world_segment[:, low - first : high - first].copy()
    T[..., :3, 3] /= factor
    out[low:high, :, :16] = T.swapaxes(2, 3).reshape(*T.shape[:2], 16).swapaxes(0, 1)
    known = np.isfinite(T).all((2, 3)).T
    reliability = np.nan_to_num(poses.reliability[:, low - first : high - first].T)
    out[..., 16] = -1.0
    out[low:high, :, 16] = np.where(known, np.maximum(reliability, 0), np.minimum(reliability, -1.0))
    return out


def _with_labels(doc: C3D, source: C3D, poses: Poses, ratio: int, rate: float) -> C3D:
    """The document with the parameters of its rotations."""
    had = distinct(source.texts(GROUP, "LABELS"), source.rotations.shape[1], "segment ")
    numbers = [Parameter.whole("USED", len(poses)), Parameter.whole("DATA_START", 1)]
    numbers += [Parameter.whole("RATIO", ratio), Parameter.real("RATE", rate)]
    doc = with_parameters(doc, GROUP, numbers)
    rows = matched(poses.names, had)
    doc = with_descriptions(doc, GROUP, rows, len(had))
    return with_text(doc, GROUP, "LABELS", poses.names, rows, had)
