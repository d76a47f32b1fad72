"""Two tracks that go on as each other: what comes after is changed back.

At few frames a second a marker moves as far from frame to frame as its neighbours are away, and a track may go on with
another marker's images. Where it does so it did not yet know what comes after, which tells. A *link* leads from one
point of a track to the next. Of the links from a to b of one track, and from c to d of another, that have a time in
common, with the score s of a stitch by motion ((1) of `stitch`), that of what is before and of what is after,

    M = s(a, b) + s(c, d) − s(a, d) − s(c, b)                                             (1)

says how much likelier they are than exchanged. Either of c and d may lack: a track that begins or ends there has been
left by its marker, or taken from it. So says what a marker keeps, the distances r_k to companions k. From one frame to
another so many frames later they usually change by σ_k, of the NEAR_S before and after, by the median, and

    s'(a, b) = 3 · mean of 2 ln(L (1 − ε) / √(2π σ_k²) exp(−(r_k(b) − r_k(a))² / 2 σ_k²) + ε),     D as (1)     (2)

as (1) of `companions`, of the MATES steadiest. Tracks are exchanged from these links on where M < 0, D < 0 and
M + D < −SURE (3): motion, what is kept, and both together say so.

Only links are looked at that leave their course: with velocities v of the points before a and after b,

    e(a, b) = x_b − x_a − (t_b − t_a) (v_a + v_b) / 2                                     (4)

is what a change of acceleration leaves. It is more than ROUGH, and squared and summed more than exchanged.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Cloud
from ....data.array_types import Bools, Floats, Ints
from ....numerics.row_quantiles import row_medians
from ..following.passes import Associations
from ..points.neighbouring_points import RowsByTrack, TrackPoints, motion_from, rows_near
from ..simultaneous_method import Simultaneous
from .companions import FEWEST, MATES, STRAY
from .stitch import CLEAR_MARGIN, LEAST, Ends, Stitched, differences, log_normal

SURE = CLEAR_MARGIN
"""Least of −(M + D), in units of (1); chosen: a hundred times likelier exchanged, as of stitches."""

ROUGH = 20.0
"""mm of (4) from which a link is looked at; chosen: markers are hardly nearer, and 5 mm gives the same."""

LONGEST_S = 0.5
"""s of a link, at most; chosen: of longer ones motion tells little."""

NEAR_S = 1.0
"""s before and after, of which (2) takes what is usual; chosen: a step."""

MEDIAN_CHI2 = 0.455
"""Median of χ² with one degree of freedom; by definition."""

ROUNDS = 4
"""Times at most that all tracks are looked at; chosen: the third finds hardly anything new."""

NEVER = 1 << 40
"""The frame from which on a track without a later point goes on; by definition."""

HALVES = ((0, 1, 1), (2, 3, 1), (0, 3, -1), (2, 1, -1))
"""Of a, b, c and d of (1) what is before and after, and the sign there; by definition."""


class _Pairs(NamedTuple):
    """N pairs of links: rows (N) of the points a, b, c and d of (1), −1 for none."""

    a: Ints
    b: Ints
    c: Ints
    d: Ints

    def take(self, which: Bools | Ints) -> _Pairs:
        """Only these."""
        return _Pairs(*(column[which] for column in self))

    def halves(self) -> tuple[tuple[Ints, Ints, int], ...]:
        """By HALVES."""
        return tuple((self[i], self[j], sign) for i, j, sign in HALVES)


class _Spans(NamedTuple):
    """Tracks (N), from their first frame (N) to their last one (N).

    Of a long recording only few are there at a time, and all others would be asked at each link.
    """

    track: Ints
    first: Ints
    last: Ints

    @classmethod
    def of(cls, points: TrackPoints) -> _Spans:
        """Those of points by track and frame."""
        track, row, n = np.unique(points.id, return_index=True, return_counts=True)
        return cls(track, points.frame[row], points.frame[row + n - 1])

    def about(self, first: int, last: int) -> Ints:
        """The tracks that have begun by the last frame, and have not ended before the first."""
        return self.track[(self.first <= last) & (self.last >= first)]


class Exchanges(NamedTuple):
    """(N, 4): two tracks, and the frames from which on what each has is the other's; one after the other."""

    cuts: Ints

    def of(self, id: Ints, frame: Ints) -> Ints:
        """The track that each of id (N) in frame (N) is after them."""
        id = id.copy()
        for one, other, first, after in self.cuts.tolist():
            here, there = (id == one) & (frame >= first), (id == other) & (frame >= after)
            id[here], id[there] = other, one
        return id


def with_exchanged_tails(
    cloud: Cloud, ids: Ints, seen: Associations, whole: Stitched, T: float, method: Simultaneous
) -> tuple[Ints, Associations, Stitched]:
    """The tracks (P) of points after exchanges, and what became of the associations and of the stitches.

    Of a track of these whose later part has become another's, that part is a track of its own.
    """
    found = exchanged_tails(TrackPoints.of(cloud, ids), T, method)
    if not len(found.cuts):
        return ids, seen, whole
    was = whole.id[seen.id]
    now = found.of(was, seen.frame)
    (of, became), number = np.unique([seen.id[now != was], now[now != was]], axis=1, return_inverse=True)
    id = seen.id.copy()
    id[now != was] = len(whole.id) + number.ravel()
    parts = {pair: len(whole.id) + k for k, pair in enumerate(zip(of.tolist(), became.tolist(), strict=True))}

    def part(track: int, frame: int) -> int:
        return parts.get((track, int(found.of(whole.id[[track]], np.array([frame]))[0])), track)

    stitches = [
        one._replace(before=part(one.before, one.last), after=part(one.after, one.first)) for one in whole.stitches
    ]
    whole = Stitched(np.append(whole.id, became), stitches)
    return found.of(ids, cloud.frame), seen._replace(id=id), whole


def exchanged_tails(points: TrackPoints, T: float, method: Simultaneous) -> Exchanges:
    """Tracks of points, one in a frame, that go on as each other by (3); T is the time between frames in s.

    What is left of a track that begins or ends there has the number of the other one.
    """
    found = [np.zeros((0, 4), np.int64)]
    for _ in range(ROUNDS):
        points = points.take(np.lexsort([points.frame, points.id]))
        if not len(some := _each_once(points, _surely(points, T, method))):
            break
        found.append(some)
        points = points._replace(id=Exchanges(some).of(points.id, points.frame))
    return Exchanges(np.concatenate(found))


def _each_once(points: TrackPoints, pairs: _Pairs) -> Ints:
    """The cuts of the first pair, and of each other that has no track of those before."""
    cuts, used = [], set[int]()
    for a, b, c, d in np.stack(pairs, 1).tolist():
        both = int(points.id[a]), int(points.id[max(c, d)])
        if used.isdisjoint(both):
            used |= set(both)
            cuts.append((*both, int(points.frame[b]), int(points.frame[d]) if d >= 0 else NEVER))
    return np.array(cuts, np.int64).reshape(-1, 4)


def _surely(points: TrackPoints, T: float, method: Simultaneous) -> _Pairs:
    """Pairs of links of points by track and frame that are exchanged by (3), the likeliest first."""
    pairs = _possible(points, T)
    motion = _by_motion(points, pairs, T, method)
    pairs, motion = pairs.take(motion < 0), motion[motion < 0]
    kept = _by_companions(points, pairs, T)
    sure = np.flatnonzero((kept < 0) & (motion + kept < -SURE))
    return pairs.take(sure[np.argsort((motion + kept)[sure], kind="stable")])


def _possible(points: TrackPoints, T: float) -> _Pairs:
    """Pairs of links by (4)."""
    id, frame = points.id, points.frame
    link = np.flatnonzero((np.diff(id) == 0) & (np.diff(frame) * T <= LONGEST_S))
    velocity = _velocities(points)
    rough = link[_off_course(points, velocity, link, link + 1, 1) > ROUGH]
    if not len(rough):
        return _Pairs(rough, rough, rough, rough)
    rows, spans = RowsByTrack.of(frame, id), _Spans.of(points)
    found = [_beside(points, rows, spans, a, T) for a in rough.tolist()]
    pairs = _Pairs(*(np.concatenate(column) for column in zip(*found, strict=True)))
    pairs = _nearer_exchanged(points, velocity, pairs)
    return _Pairs(*np.unique(np.stack(pairs), axis=1))


def _beside(points: TrackPoints, rows: RowsByTrack, spans: _Spans, a: int, T: float) -> _Pairs:
    """The link from row a with those of tracks over its first, middle and last frame, some of them twice."""
    first, last = points.frame[[a, a + 1]].tolist()
    longest = int(np.ceil(LONGEST_S / T))
    tracks = spans.about(first - longest, last + longest)
    frames = np.unique([first, (first + last) // 2, last - 1])
    own = np.repeat(tracks, len(frames))
    c = np.searchsorted(rows.place, (tracks[:, None] * rows.F + frames).ravel(), "right") - 1
    d = np.minimum(c + 1, len(points.id) - 1)
    c = np.where((c >= 0) & (points.id[c] == own), c, -1)
    d = np.where((points.id[d] == own) & (d != c), d, -1)
    a_each = np.full(len(c), a)
    pairs = _Pairs(a_each, a_each + 1, c, d)
    return pairs.take(_at_once(points, pairs, T))


def _at_once(points: TrackPoints, pairs: _Pairs, T: float) -> Bools:
    """(N) whether the links of pairs could be exchanged: of two tracks that are there at the same time, in which those
    that go on are after those that came before, and no more than LONGEST_S."""
    id, frame = points.id, points.frame
    a, b, c, d = pairs
    has, goes = c >= 0, d >= 0
    other = id[np.maximum(c, d)]
    good = (has | goes) & (other != id[a])
    good &= ~goes | ((frame[d] > frame[a]) & ((frame[d] - frame[a]) * T <= LONGEST_S))
    good &= ~has | ((frame[b] > frame[c]) & ((frame[b] - frame[c]) * T <= LONGEST_S))
    begins = np.searchsorted(id, other)
    ends = np.searchsorted(id, other, "right") - 1
    return np.asarray(good & (goes | (frame[begins] <= frame[a])) & (has | (frame[ends] >= frame[b])))


def _velocities(points: TrackPoints) -> Floats:
    """(2, P, 3) mm a frame to each point from the one before, and from it to the next one; NaN where there is none."""
    step = np.diff(points.frame).astype(float)
    step[np.diff(points.id) != 0] = np.nan
    v = np.full((2, len(points.id), 3), np.nan)
    v[0, 1:] = v[1, :-1] = np.diff(points.xyz, axis=0) / step[:, None]
    return v


def _off_course(points: TrackPoints, velocity: Floats, a: Ints, b: Ints, least: int) -> Floats:
    """(N) mm by (4), by the velocities that are known; 0 of fewer than `least`, and where a point lacks."""
    v = np.stack([velocity[0, a], velocity[1, b]])
    known = np.isfinite(v[..., 0]).sum(0)
    mean = np.nansum(v, 0) / np.maximum(known, 1)[:, None]
    off = np.linalg.norm(points.xyz[b] - points.xyz[a] - (points.frame[b] - points.frame[a])[:, None] * mean, axis=1)
    return np.where((a >= 0) & (b >= 0) & (known >= least), off, 0.0)


def _nearer_exchanged(points: TrackPoints, velocity: Floats, pairs: _Pairs) -> _Pairs:
    """Pairs of which the sum of squares of (4) is less exchanged, as far as it is known then."""
    off = [sign * _off_course(points, velocity, a, b, 1 + (sign < 0)) ** 2 for a, b, sign in pairs.halves()]
    return pairs.take(np.sum(off, axis=0) > 0)


def _by_motion(points: TrackPoints, pairs: _Pairs, T: float, method: Simultaneous) -> Floats:
    """(N) by (1)."""
    total = np.zeros(len(pairs.a))
    if not len(total):
        return total
    rows, which = np.unique(np.stack(pairs), return_inverse=True)
    which = which.reshape(4, -1)
    by_track, motion = RowsByTrack.of(points.frame, points.id), []
    for way in (1, -1):
        near = rows_near(by_track, points.id[rows], points.frame[rows], way)
        motion.append(motion_from(points, near, points.xyz[rows].T, T, method))
    ends = Ends(points.frame[rows], points.frame[rows], *motion)
    for a, b, sign in _Pairs(*which).halves():
        some = np.flatnonzero((rows[a] >= 0) & (rows[b] >= 0))
        delta, S = differences(ends, a[some], b[some], T, method)
        total[some] += 2 * sign * log_normal(delta, S)
    return total


class _Companions(NamedTuple):
    """What keeps its distance (2): the points, their rows by track, the tracks, L in mm, and frames of NEAR_S."""

    points: TrackPoints
    rows: RowsByTrack
    spans: _Spans
    spread: float
    near: int

    @classmethod
    def of(cls, points: TrackPoints, T: float) -> _Companions:
        """Those of points by track and frame."""
        spread = float(np.linalg.norm(points.xyz.std(0)) * np.sqrt(2)) + LEAST
        return cls(points, RowsByTrack.of(points.frame, points.id), _Spans.of(points), spread, round(NEAR_S / T))

    def score(self, a: int, b: int, apart: Ints) -> float:
        """s'(a, b) of (2), by tracks that are not among `apart`; NaN of fewer than three."""
        first, last = self.points.frame[[a, b]]
        others = self.spans.about(first - self.near, last + self.near)
        others = others[~np.isin(others, apart)]
        before = self._distances(others, int(self.points.id[a]), np.arange(first - self.near, first + 1))
        after = self._distances(others, int(self.points.id[b]), np.arange(last, last + self.near + 1))
        lag, cov = last - first, np.trace(self.points.cov[[a, b]], axis1=1, axis2=2).sum() / 3
        squared = np.stack([_row_medians((r[:, lag:] - r[:, :-lag]) ** 2) for r in (before, after)])
        known = np.isfinite(squared)
        with np.errstate(invalid="ignore"):
            variance = np.nansum(squared, 0) / known.sum(0) / MEDIAN_CHI2 + cov + LEAST**2
        off = (after[:, 0] - before[:, -1]) ** 2
        some = np.flatnonzero(np.isfinite(off) & np.isfinite(variance))
        best = some[np.argsort(variance[some], kind="stable")[:MATES]]
        v = 2 * np.pi * variance[best]
        said = 2 * np.log((1 - STRAY) * self.spread / np.sqrt(v) * np.exp(-np.pi * off[best] / v) + STRAY)
        return float(3 * said.mean()) if len(best) >= FEWEST else np.nan

    def _distances(self, others: Ints, own: int, frames: Ints) -> Floats:
        """(n, f) mm of tracks from one of them in frames, NaN where either is not there."""
        row, at = self.rows.at(others[:, None], frames[None]), self.rows.at(np.full(len(frames), own), frames)
        off = np.linalg.norm(self.points.xyz[row] - self.points.xyz[at], axis=-1)
        return np.where((row >= 0) & (at >= 0), off, np.nan)


def _row_medians(values: Floats) -> Floats:
    """Of each row, NaN where it has none."""
    return row_medians(values) if values.shape[1] else np.full(len(values), np.nan)


def _by_companions(points: TrackPoints, pairs: _Pairs, T: float) -> Floats:
    """(N) D of (2), 0 where it is not known of all halves."""
    total = np.zeros(len(pairs.a))
    if not len(total):
        return total
    companions = _Companions.of(points, T)
    for k, one in enumerate(np.stack(pairs, 1).tolist()):
        apart = points.id[[one[0], max(one[2:])]]
        halves = [(one[i], one[j], sign) for i, j, sign in HALVES if one[i] >= 0 and one[j] >= 0]
        total[k] = sum(sign * companions.score(a, b, apart) for a, b, sign in halves)
    return np.nan_to_num(total)
