"""What is done to tracks after they were linked: blending, cleaning, cutting to the volume (KISS 4.3).

Each is a function of tracks alone, so that it can also be called by hand, again, and in another order.

Two tracks are blended where the second starts within a short time after the first ends, and each one, continued by the
ladder of `signal.extrapolation`, comes to the other:

    |a(t_b) − b₁| ≤ r,   |b(t_a) − aₙ| ≤ r                               (1)

where aₙ, seen at t_a, is the last point of the first track, b₁ at t_b the first point of the second, and a(t), b(t) are
the polynomials through the last points of the one and the first of the other. A track of a single point has no motion;
it may be `max_distance` a frame away, others r = `search_radius`. Where there is a choice, the two that agree best go
first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..data import Tracks
from ..data.array_types import Floats, Ints
from ..geometry.weighted_points import inside_volume
from ..numerics.runs import equal_runs
from ..signal import LADDER, PAST, cheapest_first


class End(NamedTuple):
    """One end of a track: frame and xyz (n ≤ 5, 3) mm of its points, the outermost first."""

    frame: Ints
    xyz: Floats


def blend(tracks: Tracks, *, max_gap: float = 0.04, search_radius: float = 40.0, max_distance: float = 100.0) -> Tracks:
    """The tracks, with those stitched that continue each other; they are numbered in the order in which they begin.

    Args:
        tracks: to be stitched.
        max_gap: longest time from the end of one to the start of the next, s.
        search_radius: farthest that they may be off, mm; of (1).
        max_distance: farthest that a track of one point may be from the other one, mm a frame.
    """
    rows = _rows(tracks)
    ends = [_end(tracks, own[::-1]) for own in rows]
    starts = [_end(tracks, own) for own in rows]
    longest = int(max_gap * tracks.cloud.rate + 1e-6)
    begin, stop = (np.array([side.frame[0] for side in sides], np.int64) for sides in (starts, ends))
    gap = begin - stop[:, None]
    first, second = np.nonzero((gap > 0) & (gap <= longest))
    pairs = zip(first.tolist(), second.tolist(), strict=True)
    off = np.array(
        [_disagreement(ends[a], starts[b], search_radius, max_distance) for a, b in pairs], np.float64
    )  # (1)
    first, second = cheapest_first(first[off <= 1], second[off <= 1], off[off <= 1])
    identity = np.arange(len(rows))
    for k in np.argsort(begin[second], kind="stable"):
        identity[second[k]] = identity[first[k]]  # a track that continues in another was itself stitched before
    joined = np.full(len(tracks.id), -1)
    for k, own in enumerate(rows):
        joined[own] = identity[k]
    return Tracks(tracks.cloud, _in_order(joined))


def without_short(tracks: Tracks, *, min_points: int) -> Tracks:
    """The tracks; those of fewer than `min_points` points lose their identity."""
    long = tracks.lengths >= min_points
    number = np.where(long, np.cumsum(long) - 1, -1)
    return Tracks(tracks.cloud, np.where(tracks.id >= 0, number[tracks.id], -1) if len(long) else tracks.id)


def within_volume(tracks: Tracks, volume: ArrayLike, *, margin: float = 0.0) -> Tracks:
    """The tracks; their points outside the volume lose their identity.

    Args:
        tracks: to be cut.
        volume: (2, 3) least and greatest corner, mm.
        margin: how far outside a point may lie, mm.
    """
    inside = inside_volume(tracks.cloud.xyz, volume, margin=margin)
    return Tracks(tracks.cloud, _in_order(np.where(inside, tracks.id, -1)))


def _rows(tracks: Tracks) -> list[Ints]:
    """The points of each track that has any, in the order of their frames."""
    order = np.argsort(tracks.id, kind="stable")
    order = order[tracks.id[order] >= 0]
    return np.split(order, equal_runs(tracks.id[order])[1:-1]) if len(order) else []


def _end(tracks: Tracks, rows: Ints) -> End:
    """The first of these points."""
    rows = rows[:PAST]
    frame = np.searchsorted(tracks.cloud.start, rows, side="right") - 1
    return End(frame, tracks.cloud.xyz[rows])


def _disagreement(end: End, start: End, search_radius: float, max_distance: float) -> float:
    """The larger of both distances of (1) by its limit: 1 where they just agree."""
    gap = float(start.frame[0] - end.frame[0])
    off = []
    for one, other in ((end, start), (start, end)):
        miss = float(np.linalg.norm(_continued(one, int(other.frame[0])) - other.xyz[0]))
        off.append(miss / (search_radius if len(one.frame) > 1 else max_distance * gap))
    return max(off)


def _continued(end: End, frame: int) -> Floats:
    """Where the ladder's polynomial through these points is at another frame, (3) mm."""
    if len(end.frame) == 1:
        return end.xyz[0]
    samples, degree = LADDER[len(end.frame) - 1]
    t = (end.frame[:samples] - frame).astype(np.float64)
    return np.linalg.pinv(np.vander(t, degree + 1, increasing=True))[0] @ end.xyz[:samples]


def _in_order(identity: Ints) -> Ints:
    """Identities (P) of points in the order of frames, numbered by where they first appear; −1 stays."""
    known, first = np.unique(identity[identity >= 0], return_index=True)
    number = np.empty(len(known), np.int64)
    number[np.argsort(first)] = np.arange(len(known))
    renumbered = np.full(len(identity), -1)
    renumbered[identity >= 0] = number[np.searchsorted(known, identity[identity >= 0])]
    return renumbered
