"""Covariances and origins of markers in a section of our own, which other readers pass over.

C3D has no place for either. The section stands behind points, channels and rotations; KINEMARK:SAMPLES_START says at
which block, as ROTATION:DATA_START does. It holds

    MARK (16 bytes) | uint32 checksum | uint32 length | table, compressed

little endian in files of every processor. The table has, for M markers of F frames in the order of the file,

    origin (M, F) uint8 | covariance (M, F, 6) float32: xx, xy, xz, yy, yz, zz in mm², NaN where unknown

The checksum is that of the positions. Where another program has changed the positions and kept the section, the table
counts no more, and a note says so.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import replace

import numpy as np

from ...data import Origin, Trajectories
from ...data.array_types import Bools, Floats
from .document import C3D, with_parameters
from .parameters import Parameter
from .points import LENGTH, Samples, kinds_of, point_names, samples_of
from .provenance import GROUP
from .rotations import MOST_BLOCK

START = "SAMPLES_START"
MARK = b"KINEMARK SAMPLES"
HEAD = struct.Struct("<16sII")
UPPER = np.triu_indices(3)
"""Rows and columns, without unit, of the six numbers of a covariance, in the order of the table; by definition."""


def section_in(doc: C3D, raw: bytes, stop: int) -> tuple[bytes, int]:
    """The section of a file, empty where there is none, and the byte after it; `stop`: before which none begins."""
    at = section_start(doc)
    if not stop <= at <= len(raw) - HEAD.size:
        return b"", stop
    mark, _, length = HEAD.unpack_from(raw, at)
    end = at + HEAD.size + length
    return (raw[at:end], end) if mark == MARK and end <= len(raw) else (b"", stop)


def section_start(doc: C3D) -> int:
    """The byte at which the parameters say that the section begins; 0 where they do not."""
    parameter = doc.get(GROUP, START)
    block = float(parameter.unsigned[0]) if parameter is not None and parameter.unsigned.size else 0.0
    return 512 * (int(block) - 1) if 1 < block < 2**31 else 0


def with_section_start(doc: C3D, block: int) -> C3D:
    """The document that says at which block its section begins."""
    make = Parameter.whole if block <= MOST_BLOCK else Parameter.real
    return with_parameters(doc, GROUP, [make(START, block)])


def with_table(doc: C3D, trajectories: Trajectories) -> C3D:
    """The document with the section, where its markers have covariances or samples that were edited.

    Args:
        doc: the document with the points of the trajectories. trajectories: what it holds.
    """
    shape = (len(trajectories), trajectories.n_frames)
    cov = np.array([path.cov for path in trajectories]).reshape(*shape, 3, 3)
    origin = np.array([path.origin for path in trajectories], np.uint8).reshape(shape)
    if not np.isfinite(cov).any() and not (origin == Origin.EDITED).any():
        return doc if not doc.sample_table else replace(doc, sample_table=b"")
    numbers = cov[:, :, UPPER[0], UPPER[1]].astype("<f4")
    body = zlib.compress(origin.tobytes() + numbers.tobytes(), 1)
    head = HEAD.pack(MARK, _checksum(samples_of(doc), _markers(doc)), len(body))
    return replace(doc, sample_table=head + body)


def with_covariance(doc: C3D, samples: Samples) -> tuple[Samples, Floats, tuple[str, ...]]:
    """The samples with the origins of the section, the covariances (M, F, 3, 3) of all points, mm², and what is odd."""
    m, f = samples.origin.shape
    unknown = np.broadcast_to(np.nan, (m, f, 3, 3))
    if not doc.sample_table:
        return samples, unknown, ()
    own = _markers(doc)
    table = _table(doc, int(own.sum()) * f, _checksum(samples, own))
    if table is None:
        return samples, unknown, ("the covariances in the file are of other positions; they are not used",)
    origin, cov = samples.origin.copy(), unknown.copy()
    origin[own] = np.frombuffer(table, np.uint8, own.sum() * f).reshape(-1, f)
    numbers = np.frombuffer(table, "<f4", own.sum() * f * 6, own.sum() * f).reshape(-1, f, 6).astype(np.float64)
    block = np.empty((*numbers.shape[:2], 3, 3))
    block[:, :, UPPER[0], UPPER[1]] = block[:, :, UPPER[1], UPPER[0]] = numbers
    cov[own] = block
    if ((origin == Origin.MISSING) != (samples.origin == Origin.MISSING)).any() or (origin > max(Origin)).any():
        return samples, unknown, ("the origins in the file are of other positions; they are not used",)
    return replace(samples, origin=origin), cov, ()


def _table(doc: C3D, n: int, checksum: int) -> bytes | None:
    """The table of n samples; None where it is of another size or of other positions, or damaged."""
    stated = HEAD.unpack_from(doc.sample_table)[1]
    reader, size = zlib.decompressobj(), n * 25
    try:
        table = reader.decompress(doc.sample_table[HEAD.size :], size + 1)
    except zlib.error:
        return None
    return table if stated == checksum and len(table) == size and reader.eof else None


def _markers(doc: C3D) -> Bools:
    """(M) which points are markers."""
    return np.array([kind == LENGTH for kind in kinds_of(doc, point_names(doc))], np.bool_)


def _checksum(samples: Samples, own: Bools) -> int:
    """Of the positions, in single precision; all missing ones alike, and zeros, whose sign integers do not keep."""
    positions = samples.xyz[own].astype("<f4") + np.float32(0.0)
    positions[np.isnan(positions)] = np.float32(1e30)
    return zlib.crc32(positions.tobytes())
