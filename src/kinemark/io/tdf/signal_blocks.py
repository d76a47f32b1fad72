"""What a TDF file holds besides its cameras: 3D tracks, force plates, EMG and events.

**Force plates.** Block 9 gives, a plate and sample, the point of application (px, py) in m from the plate's centre,
the force (fx, fy, fz) in N and the free torque tz in N·m; block 7 gives the corners c0 … c3 in m. In the plate's
right-handed frame x points from c0 to c1, y from c1 to c2, hence z down, and the force is that of the foot *on the
plate* (found from a recorded gait trial: fz > 0 in stance, the point of application moves under the foot, the shear
points forward first and backward later).
C3D counts the corners (+x, +y), (−x, +y), (−x, −y), (+x, −y) and stores the reaction. So that a plate of type 1
means one thing whatever file it comes from,

    corners = (c2, c3, c0, c1)                                           (1)
    (Fx, Fy, Fz, Px, Py, Mz) = (−fx, −fy, −fz, 1000 px, 1000 py, −tz)    (2)   N, mm, N·m
"""

from __future__ import annotations

import numpy as np

from ...data import Analog, Events, ForcePlate, MarkerTrajectory, Trajectories
from ...data.array_types import Floats, Ints
from ..notes import UNREADABLE
from .cursor import Cursor, UnreadableBlock

WRENCH = ("Fx", "Fy", "Fz", "Px", "Py", "Mz")
UNITS = ("N", "N", "N", "mm", "mm", "N·m")
FROM_FILE = ((2, -1.0), (3, -1.0), (4, -1.0), (0, 1000.0), (1, 1000.0), (5, -1.0))
"""(2): column and factor; of the format."""
PLATE_TYPE = 1  # C3D's type with force and centre of pressure; of that format


def by_track(cursor: Cursor, n: int, width: int) -> Floats:
    """(n, width) a signal stored as segments: their number, a pad, (first, length) of each, then all samples."""
    segments = _segments(cursor)
    if (segments.sum(1) > n).any():
        raise cursor.bad(f"has a segment outside its {n} samples")
    return _samples(cursor, segments, n, width)


def _segments(cursor: Cursor) -> Ints:
    """(S, 2) first sample and length of each segment."""
    n_segments = cursor.integer()
    cursor.take("<i4")
    segments = cursor.take("<i4", 2 * n_segments).reshape(-1, 2).astype(np.int64)
    if (segments < 0).any():
        raise cursor.bad("has a segment before its first sample")
    return segments


def _samples(cursor: Cursor, segments: Ints, n: int, width: int) -> Floats:
    """(n, width) the samples of segments; NaN between them."""
    values = np.full((n, width), np.nan)
    for a, m in segments.tolist():
        values[a : a + m] = cursor.take("<f4", m * width).reshape(m, width)
    return values


def trajectories(cursor: Cursor) -> Trajectories:
    """Block type 5: formats 1 and 2 by track, 3 and 4 by frame; 1 and 3 with links between markers."""
    cursor.wanted(1, 2, 3, 4)
    n_frames, rate, start, n = cursor.integer(), cursor.rate(), cursor.real(), cursor.integer()
    cursor.take("<f4", 15)  # volume, its rotation and corner, as in block 2
    cursor.take("<u4")
    if cursor.format in (1, 3):
        n_links = cursor.integer()
        cursor.take("<i4", 1 + 2 * n_links)
    cursor.room(n, n_frames, 16)
    names, xyz = tracks(cursor, n, n_frames) if cursor.format < 3 else frames(cursor, n, n_frames)
    if not np.isfinite(start):
        raise cursor.bad(f"starts at {start} s")
    paths = (
        MarkerTrajectory.measured(name or f"*{m + 1}", 1000 * track)
        for m, (name, track) in enumerate(zip(names, xyz, strict=True))
    )
    return Trajectories(tuple(paths), rate, first_frame=round(start * rate) + 1)


def tracks(cursor: Cursor, n: int, n_frames: int) -> tuple[list[str], list[Floats]]:
    """Labels and (F, 3) m of n tracks, one after the other; of a block that is cut off those that are whole."""
    pairs: list[tuple[str, Floats]] = []
    try:
        for _ in range(n):
            pairs.append((cursor.text(), by_track(cursor, n_frames, 3)))
    except UnreadableBlock:
        if not cursor.cut or not pairs:
            raise
        cursor.notes.append(f"{UNREADABLE}tracks {len(pairs) + 1} to {n} of {n} (block 5), for the file ends")
    return [name for name, _ in pairs], [xyz for _, xyz in pairs]


def frames(cursor: Cursor, n: int, n_frames: int) -> tuple[list[str], list[Floats]]:
    """The same of tracks stored frame by frame, where all zeros mean missing."""
    names = [cursor.text() for _ in range(n)]
    xyz = cursor.take("<f4", n_frames * n * 3).reshape(n_frames, n, 3).transpose(1, 0, 2).astype(np.float64)
    xyz[(xyz == 0).all(-1)] = np.nan
    return names, list(xyz)


def plates(cursor: Cursor, wrenches: Analog | None) -> tuple[ForcePlate, ...]:
    """Block type 7; format 2 has a second label. A plate without samples in block 9 has no channels."""
    cursor.wanted(1, 2)
    n = cursor.integer()
    cursor.take("<i4")
    channels = cursor.take("<i2", n).tolist()
    found = []
    for channel in channels:
        cursor.text()
        cursor.take("<f4", 2)  # width and length, which the corners give better
        corners = cursor.take("<f4", 12).reshape(4, 3).astype(np.float64) * 1000
        if cursor.format == 2:
            cursor.text()
        names = wrench_names(channel)
        known = wrenches is not None and names[0] in wrenches.names
        if not np.isfinite(corners).all():
            raise cursor.bad("has corners that are not finite")
        found.append(ForcePlate(PLATE_TYPE, corners[[2, 3, 0, 1]], np.zeros(3), names if known else ()))  # (1)
    return tuple(found)


def plate_labels(cursor: Cursor) -> list[str]:
    """The labels of the plates of block type 7."""
    n = cursor.integer()
    cursor.take("u1", 4 + 2 * n)
    labels = []
    for _ in range(n):
        labels.append(cursor.text())
        cursor.take("<f4", 14)
        cursor.take("u1", 256 if cursor.format == 2 else 0)
    return labels


def wrench_names(channel: int) -> tuple[str, ...]:
    """Names of the six channels of the plate at this physical channel."""
    return tuple(f"{name}{channel + 1}" for name in WRENCH)


def wrenches(cursor: Cursor, origin: float) -> Analog:
    """Block type 9: formats 1 and 3 by plate, 2 and 4 by sample (column, then plate); 3 and 4 with labels."""
    cursor.wanted(1, 2, 3, 4)
    n, rate, start, n_samples = cursor.integer(), cursor.rate(), _start(cursor), cursor.integer()
    channels = cursor.take("<i2", n).tolist()
    cursor.room(n, n_samples, 6)
    if cursor.format in (1, 3):
        rows = np.zeros((n, n_samples, 6))
        for row in rows:
            cursor.take("u1", 256 if cursor.format == 3 else 0)
            row[:] = by_track(cursor, n_samples, 6)
    else:
        cursor.take("u1", 256 * n if cursor.format == 4 else 0)
        rows = cursor.take("<f4", n_samples * 6 * n).reshape(n_samples, 6, n).transpose(2, 0, 1).astype(np.float64)
    values = np.stack([factor * rows[:, :, k] for k, factor in FROM_FILE], 1)  # (2)
    names = tuple(name for channel in channels for name in wrench_names(channel))
    return Analog(names, UNITS * n, rate, values.reshape(6 * n, n_samples), start - origin)


def emg(cursor: Cursor, origin: float) -> Analog:
    """Block type 11: format 1 by channel, 2 by sample; V."""
    cursor.wanted(1, 2)
    n, rate, start, n_samples = cursor.integer(), cursor.rate(), _start(cursor), cursor.integer()
    cursor.take("<i2", n)
    cursor.room(n, n_samples)
    if cursor.format == 1:
        names, values = _channels(cursor, n, n_samples)
    else:
        names = [cursor.text() for _ in range(n)]
        values = cursor.take("<f4", n * n_samples).reshape(n_samples, n).T.astype(np.float64)
    return Analog(tuple(names), ("V",) * n, rate, values, start - origin)


def _channels(cursor: Cursor, n: int, stated: int) -> tuple[list[str], Floats]:
    """Labels and (n, N) samples of channels one after the other.

    As a rule such blocks state fewer samples than they hold (49 less), so that their segments say how many there are.
    """
    pairs = []
    for _ in range(n):
        name, segments = cursor.text(), _segments(cursor)
        length = max(stated, int(segments.sum(1).max(initial=0)))
        cursor.room(n, length)
        pairs.append((name, _samples(cursor, segments, length, 1)[:, 0]))
    most = max((len(values) for _, values in pairs), default=stated)
    if most > stated:
        cursor.notes.append(f"EMG: {stated} samples are stated and {most} are there; all are read")
    values = np.full((n, most), np.nan)
    for row, (_, own) in zip(values, pairs, strict=True):
        row[: len(own)] = own
    return [name for name, _ in pairs], values


def _start(cursor: Cursor) -> float:
    """The next float32 as a time, s."""
    if not np.isfinite(start := cursor.real()):
        raise cursor.bad(f"starts at {start} s")
    return start


def events(cursor: Cursor) -> Events:
    """Block type 16: a label with one time or a sequence of them, s."""
    cursor.wanted(1)
    if (n := cursor.integer()) < 0:
        raise cursor.bad(f"states {n} events")
    cursor.real()
    label: list[str] = []
    time: list[float] = []
    for _ in range(n):
        name = cursor.text()
        cursor.integer()  # 0 one event, 1 a sequence; the count says it as well
        times = cursor.take("<f4", cursor.integer()).tolist()
        label += [name] * len(times)
        time += times
    if not np.isfinite(time).all():
        raise cursor.bad("has times that are not finite")
    return Events(tuple(label), ("",) * len(label), np.array(time, np.float64))
