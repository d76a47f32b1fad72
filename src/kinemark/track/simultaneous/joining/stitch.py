"""Stitching: fragments of one marker's trajectory become one track.

A track that ends is predicted forwards, one that begins is predicted backwards, and both are compared halfway through
the gap between them. With δ the difference of positions and velocities there and S the sum of their
covariances,

    score = 2 ln(p / ((1 − p) b)) − ln |2π S| − δᵀ S⁻¹ δ                                  (1)

is twice the log-likelihood ratio of one marker to two, where b tracks per mm³ and (mm/s)³ begin by chance during the
gap. S grows with the gap, and after some tenths of a second (1) decides nothing any more. But most markers sit on
something rigid. The distance to another track k that is there on both sides was r ± σ before the gap and is r' after
it,

    score_k = 2 ln(L / (√(2π) σ)) − (r' − r)² / σ²                                        (2)

against a distance that could be any of a length L, the usual distance between tracks. The three others of least σ
count. Where the standard deviation by S exceeds `Simultaneous.uncertain_sd`, motion alone stitches nothing: (2) is
needed as well. This does not hold from one frame to the next (4), where a track that has images goes on by itself
however uncertain its prediction is, and where all tracks end at once, at the seams of `passes.Run`.

The assignment with the greatest sum of scores gives the stitches to consider. One is only made where its score exceeds
that of any other stitch of either track, and of none, by CLEAR_MARGIN (3); otherwise both tracks stay as they are and
the stitch is an ambiguous decision.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ....data.array_types import Bools, Floats, Ints
from ....geometry.rigid_pairs import distances_from
from ....native.image_index import ranges
from ....numerics.runs import equal_runs
from ..following.kalman_states import KalmanStates, predict, reversed_time
from ..points.neighbouring_points import LOOK, RowsByTrack, TrackPoints, motion_from, rows_near
from ..simultaneous_method import Simultaneous

CLEAR_MARGIN = 2 * np.log(100.0)
"""A hundred times likelier than the next best, in units of (1); chosen."""

NEVER = 1 << 40
"""The first frame of a track without points; by definition."""

LEAST = 1.0
"""mm; no two markers are held at a distance that is steadier, skin and clothes being what they are.
Chosen (see benchmarks/tracking.py)."""

NEIGHBOURS = 3
"""Other tracks of which (2) counts; chosen (see benchmarks/tracking.py)."""

PLACES = 250_000
"""Frames of tracks that are looked at in one go beside another; chosen for memory."""

AT_ONCE = 20_000
"""Pairs that are worked out in one go; more would take memory and no less time; chosen."""

SEEN = 0.8
"""p of (1): how many of the tracks that end before their marker is gone begin again within the gap.
Chosen (see benchmarks/tracking.py)."""


class Ends(NamedTuple):
    """Of each of N tracks: its first and last frame; and its motion there, that at the first against time."""

    first: Ints
    last: Ints
    begin: KalmanStates
    end: KalmanStates


class Stitch(NamedTuple):
    """Track `before` goes on as track `after`; score of (1) and (2), and margin over the next best (3);
    sd of the difference of positions (1), mm; last and first: the frames at both sides of the gap."""

    before: int
    after: int
    score: float
    margin: float
    sd: float
    last: int
    first: int


class Stitched(NamedTuple):
    """(N) the identity of each track after the clear stitches, that of the first of its fragments; and the
    stitches that were considered, clear or not."""

    id: Ints
    stitches: list[Stitch]

    def of(self, tracks: int) -> Stitched:
        """The same of at least so many tracks, of which the others are whole by themselves."""
        return self._replace(id=np.append(self.id, np.arange(len(self.id), tracks)))


def stitched(points: TrackPoints, T: float, method: Simultaneous, *, apart: Bools | None = None) -> Stitched:
    """Tracks that do not overlap stitched to longer ones; T is the time between frames in s.

    Most gaps are short, and motion alone is clear; distances to others are only looked at for what is then left.
    `apart` (N, N): tracks of which the second is known not to go on the first.
    """
    ids, found = np.arange(int(points.id.max(initial=-1)) + 1), []
    for distances in (False, True):
        best = _best_pairs(points._replace(id=ids[points.id]), T, method, distances, _merged(apart, ids))
        found += [stitch for stitch in best if distances or stitch.margin > CLEAR_MARGIN]
        ids = _identities_after(ids, best)
    return Stitched(ids, found)


def _identities_after(ids: Ints, found: list[Stitch]) -> Ints:
    """Identities after the clear stitches."""
    before = {stitch.after: stitch.before for stitch in found if stitch.margin > CLEAR_MARGIN}
    ids = ids.copy()
    for i in range(len(ids)):
        while int(ids[i]) in before:
            ids[i] = before[int(ids[i])]
    return ids


def _merged(apart: Bools | None, ids: Ints) -> Bools | None:
    """`apart` of whole tracks: where it is so of any two of their fragments."""
    if apart is None:
        return None
    out = np.zeros_like(apart)
    np.logical_or.at(out, (ids[:, None], ids), apart)
    return out


def _best_pairs(
    points: TrackPoints, T: float, method: Simultaneous, distances: bool, apart: Bools | None
) -> list[Stitch]:
    """The stitches of the greatest sum of scores."""
    if not len(points.id):
        return []
    ends = ends_of(points, T, method)
    a, b = possible(ends, T, method)
    if apart is not None:
        a, b = a[~apart[a, b]], b[~apart[a, b]]
    score, sd = scores_by_motion(points, ends, a, b, T, method)
    gain = scores_by_distance(points, a, b, score) if distances else np.zeros(len(a))
    certain = (sd < method.uncertain_sd) | (ends.first[b] - ends.last[a] == 1)  # (4)
    return best_stitches(ends, a, b, np.where(certain | (gain > 0), score + gain, 0.0), sd)


def best_stitches(ends: Ends, a: Ints, b: Ints, score: Floats, sd: Floats) -> list[Stitch]:
    """Of n pairs of tracks a and b those of the greatest sum of scores, with their margins (3); sd (n) mm.

    Pairs that have nothing to do with each other are assigned by themselves: one table of all tracks would be large.
    """
    (some,), n = np.nonzero(score > 0), len(ends.first)
    a, b, score, sd = a[some], b[some], score[some], sd[some]
    graph = scipy.sparse.coo_array((np.ones(len(a)), (a, n + b)), shape=(2 * n, 2 * n))
    group = scipy.sparse.csgraph.connected_components(graph, directed=False)[1][a]
    order = np.argsort(group, kind="stable")
    parts = np.split(order, equal_runs(group[order])[1:-1]) if len(order) else []
    found = [one for part in parts for one in _best_of_group(ends, a[part], b[part], score[part], sd[part])]
    return sorted(found, key=lambda stitch: stitch.before)


def _best_of_group(ends: Ends, a: Ints, b: Ints, score: Floats, sd: Floats) -> list[Stitch]:
    """The same of pairs of scores above 0."""
    (one, i), (other, j) = (np.unique(track, return_inverse=True) for track in (a, b))
    table, open_ = np.zeros((2, len(one), len(other)))
    table[i, j], open_[i, j] = score, sd
    before, after = scipy.optimize.linear_sum_assignment(table, maximize=True)
    best, rest, sd = table[before, after], table.copy(), open_[before, after]
    rest[before, after] = 0.0
    margin = best - np.maximum(rest.max(1)[before], rest.max(0)[after])
    before, after = one[before], other[after]
    columns = (before, after, best, margin, sd, ends.last[before], ends.first[after])
    found = (Stitch(*each) for each in zip(*(column.tolist() for column in columns), strict=True))
    return [stitch for stitch in found if stitch.score > 0]


def possible(ends: Ends, T: float, method: Simultaneous) -> tuple[Ints, Ints]:
    """Pairs of tracks of which the second begins within the gap after the first ends, where it can be by then."""
    order = np.argsort(ends.first, kind="stable")
    soonest, latest = ends.last, ends.last + method.max_gap / T + 1
    low, high = (np.searchsorted(ends.first[order], at, "right") for at in (soonest, latest))
    a, b = np.repeat(np.arange(len(order)), high - low), order[ranges(low, high - low)]
    in_order = np.lexsort([b, a])
    a, b = a[in_order], b[in_order]
    soon = (ends.first[b] - ends.last[a]) * T <= method.max_gap
    a, b = a[soon], b[soon]
    near = reachable(ends, a, b, T, method)
    return a[near], b[near]


def reachable(ends: Ends, a: Ints, b: Ints, T: float, method: Simultaneous) -> Bools:
    """Whether a marker can be from the end of each track a at the beginning of b by then, of tracks of any shape."""
    apart = np.linalg.norm(ends.begin.position[:, b] - ends.end.position[:, a], axis=0)
    return np.asarray(apart < 3 * method.velocity_sd * T * (ends.first[b] - ends.last[a]) + method.uncertain_sd)


def ends_of(points: TrackPoints, T: float, method: Simultaneous) -> Ends:
    """First and last frames of the tracks, and their motion there."""
    n = int(points.id.max()) + 1
    first, last = np.full(n, NEVER), np.full(n, -NEVER)
    np.minimum.at(first, points.id, points.frame)
    np.maximum.at(last, points.id, points.frame)
    rows, there = RowsByTrack.of(points.frame, points.id), np.flatnonzero(last >= 0)
    motion = []
    for frame, way in ((first, 1), (last, -1)):
        near = np.full((LOOK, n), -1)
        near[:, there] = rows_near(rows, there, frame[there], way)
        motion.append(motion_from(points, near, points.xyz[near[0]].T, T, method))
    return Ends(first, last, *motion)


def scores_by_motion(
    points: TrackPoints, ends: Ends, a: Ints, b: Ints, T: float, method: Simultaneous
) -> tuple[Floats, Floats]:
    """(1) of pairs, and the standard deviation of the difference of positions, mm."""
    if not len(a):
        return np.zeros(0), np.zeros(0)
    prior, score, sd = prior_of_stitch(points, ends, T, method), np.empty(len(a)), np.empty(len(a))
    for first in range(0, len(a), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        delta, S = differences(ends, a[part], b[part], T, method)
        score[part] = prior + 2 * log_normal(delta, S)
        sd[part] = np.sqrt(np.trace(S[:, :3, :3], axis1=1, axis2=2))
    return score, sd


def prior_of_stitch(points: TrackPoints, ends: Ends, T: float, method: Simultaneous) -> float:
    """2 ln(p / ((1 − p) b)) of (1)."""
    extent = np.ptp(np.percentile(points.xyz, [5, 95], axis=0), axis=0) + 100.0
    begun = max(len(ends.first) * method.max_gap / (T * (points.frame.max() + 1)), 1.0)
    return float(2 * np.log(SEEN / (1 - SEEN) * extent.prod() * (2 * method.velocity_sd) ** 3 / begun))


def differences(ends: Ends, a: Ints, b: Ints, T: float, method: Simultaneous) -> tuple[Floats, Floats]:
    """δ (n, 6) and S (n, 6, 6) of (1), of n pairs."""
    half = (ends.first[b] - ends.last[a]) * T / 2
    one = predict(ends.end.take(a), half, method.process_noise)
    other = reversed_time(predict(ends.begin.take(b), half, method.process_noise))
    return (other.x[:6] - one.x[:6]).T, (one.V[:6, :6] + other.V[:6, :6]).transpose(2, 0, 1)


def log_normal(delta: Floats, S: Floats) -> Floats:
    """ln N(δ; 0, S) of n differences (n, k)."""
    squared = (delta * np.linalg.solve(S, delta[..., None])[..., 0]).sum(1)
    return np.asarray(-(np.linalg.slogdet(2 * np.pi * S)[1] + squared) / 2)


def scores_by_distance(points: TrackPoints, a: Ints, b: Ints, by_motion: Floats) -> Floats:
    """(2) of pairs, 0 where no other track is there on both sides, or where it could not bring (1) above 0."""
    spread = float(np.linalg.norm(points.xyz.std(0)) * np.sqrt(2)) + LEAST
    most = NEIGHBOURS * 2 * np.log(spread / (np.sqrt(2 * np.pi) * LEAST))
    some = np.flatnonzero(by_motion + most > 0)
    there, tracks = _InFrames.of(points), int(points.id.max()) + 1
    known = {i: _distances(points, there, i) for i in np.unique([a[some], b[some]]).tolist()}
    score = np.zeros(len(a))
    for pair in some.tolist():
        (r, sd), (r2, sd2) = (known[int(end[pair])].of_all(tracks) for end in (a, b))
        sigma = np.hypot(sd, sd2)
        mates = np.argsort(sigma)[:NEIGHBOURS]
        mates = mates[np.isfinite(sigma[mates])]
        off = (r2 - r)[mates] / sigma[mates]
        score[pair] = (2 * np.log(spread / (np.sqrt(2 * np.pi) * sigma[mates])) - off**2).sum()  # (2)
    return score


class _Distances(NamedTuple):
    """Of a track from those (n) that are seen beside it in LOOK frames: their numbers, mean and standard deviation, mm.

    All pairs of thousands of tracks would take much memory, and few are ever seen together.
    """

    track: Ints
    mean: Floats
    sd: Floats

    def of_all(self, n: int) -> tuple[Floats, Floats]:
        """Mean and standard deviation from each of n tracks, NaN where not known."""
        mean, sd = np.full((2, n), np.nan)
        mean[self.track], sd[self.track] = self.mean, self.sd
        return mean, sd


class _InFrames(NamedTuple):
    """Points by frame: `row` (P) of them, of which first[f]:first[f + 1] are in frame f; and by track.

    A table of tracks and frames would grow with the square of a recording, as more tracks break in a longer one.
    """

    row: Ints
    first: Ints
    of_tracks: RowsByTrack

    @classmethod
    def of(cls, points: TrackPoints) -> _InFrames:
        """Those of some points."""
        row, rows = np.argsort(points.frame, kind="stable"), RowsByTrack.of(points.frame, points.id)
        return cls(row, np.searchsorted(points.frame[row], np.arange(rows.F + 1)), rows)

    def beside(self, id: Ints, frames: Ints) -> tuple[Ints, Ints]:
        """The rows (n) of those of tracks id (P) that are in LOOK of some frames (k) and more, by track, and which of
        the frames each is in."""
        count = self.first[frames + 1] - self.first[frames]
        which = np.repeat(np.arange(len(frames)), count)
        row = self.row[ranges(self.first[frames], count)]
        often = np.flatnonzero(np.bincount(id[row])[id[row]] >= LOOK)
        often = often[np.argsort(id[row[often]], kind="stable")]
        return row[often], which[often]


def _distances(points: TrackPoints, there: _InFrames, i: int) -> _Distances:
    """Mean distances of track i from others, and their standard deviations, in its own frames."""
    rows = there.of_tracks
    own = slice(*np.searchsorted(rows.place, (i * rows.F, (i + 1) * rows.F)).tolist())
    frames = rows.place[own] - i * rows.F
    row, which = there.beside(points.id, frames)
    row, which = row[other := points.id[row] != i], which[other]
    id = points.id[row]
    track, step = np.unique(id), max(PLACES // max(len(frames), 1), 1)
    found = [np.zeros((2, 0))]
    for first in range(0, len(track), step):
        some = track[first : first + step]
        part = slice(*np.searchsorted(id, (some[0], some[-1] + 1)).tolist())
        table = np.full((len(some) + 1, len(frames)), -1)
        table[np.searchsorted(some, id[part]), which[part]] = row[part]
        table[-1] = rows.row[own]
        found.append(_from_last(points, table))
    mean, sd = np.concatenate(found, axis=1)
    return _Distances(track, mean, np.maximum(sd, LEAST))


def _from_last(points: TrackPoints, table: Ints) -> Floats:
    """(2, n) mean distances of the last track of a table of rows (n + 1, F) from the others, and their spread."""
    found = distances_from(np.where((table >= 0)[..., None], points.xyz[table], np.nan), len(table) - 1)
    return np.stack([found.mean[:-1], found.spread[:-1]])
