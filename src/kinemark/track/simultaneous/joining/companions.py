"""Joining by companions: pieces that have the same place among others before a gap and after it are one track.

A stitch (`stitch`) needs motion, which says nothing after some tenths of a second, and three steady distances within a
second. Where a plate or a whole body moves fast, or leaves the view for seconds, many pieces end and begin at once.
What they keep are the distances to all that is seen beside them on both sides. Of the end of one piece and the
beginning of another, with the median distance to track k in the frames next to the gap r ± σ before it and r' ± σ'
after it, each with what the covariances of both points say of it,

    score_k = 2 ln(L (1 − ε) / √(2π (σ² + σ'²)) exp(−(r' − r)² / 2 (σ² + σ'²)) + ε)        (1)

is twice the log-likelihood ratio of one marker to two, of which the distances could be any of a length L, as (2) of
`stitch`, but for the share ε of companions that do not keep their distance. The mean of (1) counts three times, as a
place has three coordinates, whatever the number of companions; of the MATES nearest companions and of the MATES
steadiest ones the lower mean counts, as what is far away says little of where on the body a marker is (2).

A hand that swings has another distance from the trunk after two seconds, though it held it for the moment before. So
beside gaps of more than FAR_S σ and σ' are at least what the distance is usually off r in AWAY_S (5).

The pair of the highest score is joined first, where no piece that is there at the time of either has a score within
`stitch.CLEAR_MARGIN` of it, and the pieces joined so far are not there at the same time (3), but for OVERLAP frames in
which one of them may drift: of two points that a track then has in a frame, the one that fits the motion of its others
better is left (4). What is joined is then one companion of the others, so this is done ROUNDS times, with
long pieces first. What a marker cannot reach in the gap is not compared, nor what is there for a few frames.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data import Cloud
from ....data.array_types import Bools, Floats, Ints
from ....numerics.evenly import evenly
from ....numerics.robust import SD_PER_MEDIAN
from ....numerics.row_quantiles import row_medians
from ....numerics.runs import begins
from ..points.neighbouring_points import TrackPoints, off_the_motion, rows_of
from ..simultaneous_method import Simultaneous
from .impacts import with_impacts
from .stitch import CLEAR_MARGIN, LEAST, Stitch, Stitched

NEXT = 24
"""Frames at either side of a gap from which distances are known; chosen (see studies/infrared_footage.py)."""

FAR_S, AWAY_S = 0.25, 2.0
"""Of (5), s; chosen: a limb moves on in a quarter of a cycle of walking, and two cycles show all of it (see
studies/occlusions.py)."""

LOOKED_AT = 200
"""Frames of (5) that are looked at, spread evenly; chosen for time."""

FEWEST = 3
"""Frames with both from which a distance is known, as the shortest tracks have four, and companions of a join, as a
place has three coordinates; chosen."""

MATES = 4
"""Companions of (2); chosen (see studies/infrared_footage.py and benchmarks/tracking_scenes.py)."""

STRAY = 0.02
"""ε of (1); chosen: one companion in fifty was exchanged itself."""

LONG, SHORTEST = 48, 16
"""Points of the pieces that are joined before shorter ones are looked at, and the fewest of a piece; chosen (see
benchmarks/tracking_scenes.py, seeds 50000 to 50049 and 70000 to 70059, studies/infrared_footage.py). Of 4222 tracks
with 99 changes of marker, joins leave 4047 with 104; with all pieces 3836 with 124, and 49 tracks for 69 of the
footage: a piece of few points is often of two markers by itself."""

SURE = 12.0
"""Least score of a join of which a piece is not long, in units of (1), where CLEAR_MARGIN is that of long ones; chosen
(see benchmarks/tracking_scenes.py, seeds 0 to 29 and 50000 to 50049): by 11 twice as many joins are wrong."""

OVERLAP = 3
"""Frames of (3); chosen (see studies/infrared_footage.py)."""

ROUNDS = 4
"""Times at most that (3) is done; chosen: the fourth finds hardly anything new."""

MAX_PAIRS = 10_000
"""Pairs of pieces that are compared at most, those of the shortest gaps; chosen: more take long."""

AT_ONCE = 1_000
"""Pairs that are worked out in one go; more would take memory and no less time; chosen."""


class Places(NamedTuple):
    """Of n ends of pieces the distance (n, N) mm from each of N tracks, NaN where not known, and its variance, mm²,
    next to the gap, and in AWAY_S (5)."""

    distance: Floats
    variance: Floats
    later: Floats

    def of(self, which: Ints, far: Bools) -> Places:
        """Only these ends, beside gaps of which some are far (5)."""
        variance = np.where(far[:, None], self.later[which], self.variance[which])
        return Places(self.distance[which], variance, self.later[which])


class Pairs(NamedTuple):
    """n pairs of pieces: the earlier and the later one (n) each, the score (2) and the usual σ of (1), mm."""

    a: Ints
    b: Ints
    score: Floats
    sd: Floats

    def take(self, which: Bools) -> Pairs:
        """Only these."""
        return Pairs(self.a[which], self.b[which], self.score[which], self.sd[which])


def joined_pieces(
    cloud: Cloud, ids: Ints, whole: Stitched, T: float, method: Simultaneous
) -> tuple[Cloud, Ints, Stitched]:
    """The points, one a frame, and their tracks, those joined that impacts ended or that companions tell.

    Tracks go by the numbers that the points have now: what a number became before, another track may have by now.
    """
    joins = with_impacts(TrackPoints.of(cloud, ids), Stitched(np.arange(len(whole.id)), []), T, method)
    joins = with_companions(TrackPoints.of(cloud, ids := joins.id[ids]), joins, T, method)
    ids = joins.id[ids]
    once = once_a_frame(TrackPoints.of(cloud, ids), T, method)
    return cloud.keep(once), ids[once], Stitched(joins.id[whole.id], whole.stitches + joins.stitches)


def with_companions(points: TrackPoints, whole: Stitched, T: float, method: Simultaneous) -> Stitched:
    """The stitches and more, of P points whose tracks are numbered after the stitches; T s between frames."""
    name, number = np.unique(points.id, return_inverse=True)
    points = points._replace(id=number)  # tables of tracks that are there no more would be most of the memory
    piece = rows_of(points)
    pairs, ids = _possible(points, piece, T, method), np.arange(len(piece))
    found: list[Stitch] = []
    for least, sure in ((LONG, CLEAR_MARGIN), (SHORTEST, SURE)):
        for _ in range(ROUNDS):
            length = np.bincount(ids[points.id], minlength=len(ids))[ids]
            long = pairs.take((length[pairs.a] >= least) & (length[pairs.b] >= least) & (ids[pairs.a] != ids[pairs.b]))
            if not len(long.a) or not (joined := _joined(piece >= 0, ids, _scored(points, piece, ids, long, T), sure)):
                break
            found += joined
    found = [one._replace(before=int(name[one.before]), after=int(name[one.after])) for one in found]
    of_all = np.arange(len(whole.id))
    of_all[name] = name[ids]
    return Stitched(of_all[whole.id], whole.stitches + found)


def once_a_frame(points: TrackPoints, T: float, method: Simultaneous) -> Bools:
    """(P) the points of which each track has one in a frame, by (4)."""
    twice = _in_frames_of_several(points)
    if not twice.any():
        return ~twice
    off = np.zeros(len(points.id))
    off[twice] = off_the_motion(points, twice, T, method)
    order = np.lexsort([off, points.id, points.frame])
    kept = np.zeros(len(points.id), bool)
    kept[order] = begins(points.frame[order], points.id[order])
    return kept


def _in_frames_of_several(points: TrackPoints) -> Bools:
    """(P) points beside which their track has another in their frame."""
    order = np.lexsort([points.id, points.frame])
    new = np.append(begins(points.frame[order], points.id[order]), True)
    several = np.empty(len(order), bool)
    several[order] = ~(new[:-1] & new[1:])
    return several


def _possible(points: TrackPoints, piece: NDArray[np.int32], T: float, method: Simultaneous) -> Pairs:
    """Pieces of which the second begins as the first ends, or later, where the marker can be by then."""
    there = piece >= 0
    some = np.flatnonzero(there.any(1))
    if not len(some):
        return Pairs(some, some, *np.zeros((2, 0)))
    first, last = there[some].argmax(1), there.shape[1] - 1 - there[some, ::-1].argmax(1)
    gap = first - last[:, None]
    ended, begun = points.xyz[piece[some, last]], points.xyz[piece[some, first]]
    reach = 3 * method.velocity_sd * T * np.maximum(np.abs(gap), 1) + method.uncertain_sd
    near = np.linalg.norm(begun - ended[:, None], axis=-1) < reach
    a, b = np.nonzero(near & (gap > -OVERLAP) & (first > first[:, None]) & (last > last[:, None]))
    soon = np.sort(np.argsort(gap[a, b], kind="stable")[:MAX_PAIRS])
    return Pairs(some[a[soon]], some[b[soon]], *np.zeros((2, len(soon))))


def _scored(points: TrackPoints, piece: NDArray[np.int32], ids: Ints, pairs: Pairs, T: float) -> Pairs:
    """The pairs that have a score above 0."""
    rows = rows_of(points._replace(id=ids[points.id]))
    spread = float(np.linalg.norm(points.xyz.std(0)) * np.sqrt(2)) + LEAST
    (a, end), (b, begin) = (np.unique(one, return_inverse=True) for one in pairs[:2])
    ends, begins = _places(points, piece, rows, ids, a, -1, T), _places(points, piece, rows, ids, b, 1, T)
    far = _gaps(piece, pairs) * T > FAR_S
    score, sd = np.zeros((2, len(pairs.a)))
    for first in range(0, len(score), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        score[part], sd[part] = _scores(ends.of(end[part], far[part]), begins.of(begin[part], far[part]), spread)
    return Pairs(pairs.a, pairs.b, score, sd).take(score > 0)


def _gaps(piece: NDArray[np.int32], pairs: Pairs) -> Ints:
    """(n) frames between the end of the earlier piece and the beginning of the later one."""
    there = piece >= 0
    last = there.shape[1] - 1 - there[pairs.a, ::-1].argmax(1)
    return np.asarray(there[pairs.b].argmax(1) - last)


def _places(
    points: TrackPoints, piece: NDArray[np.int32], rows: NDArray[np.int32], ids: Ints, which: Ints, way: int, T: float
) -> Places:
    """Of the ends (way −1) or beginnings (1) of pieces `which`, in the frames next to them."""
    distance, variance, later = np.full((3, len(which), len(rows)), np.nan)
    for k, i in enumerate(which.tolist()):
        own = np.flatnonzero(piece[i] >= 0)[::way]
        frames, long = own[:NEXT], own[: max(round(AWAY_S / T), NEXT)]
        long = long[evenly(len(long), LOOKED_AT)]
        there = rows[:, frames] >= 0
        beside = there.sum(1) >= FEWEST
        beside[ids[i]] = False
        others, at = rows[np.ix_(beside, frames)], piece[i, frames]
        off = np.where(there[beside, :, None], points.xyz[others], np.nan) - points.xyz[at]
        r = np.linalg.norm(off, axis=-1)
        u = off / np.maximum(r, LEAST)[..., None]
        said = np.einsum("nfi,nfij,nfj->nf", u, points.cov[others] + points.cov[at], u)
        middle = row_medians(r)
        steady = SD_PER_MEDIAN * row_medians(np.abs(r - middle[:, None]))
        distance[k, beside] = middle
        variance[k, beside] = np.maximum(steady**2, np.nanmean(said, axis=1)) + LEAST**2
        moved = _moved(points, rows[np.ix_(beside, long)], piece[i, long], middle)
        later[k, beside] = np.maximum(variance[k, beside], moved**2)
    return Places(distance, variance, later)


def _moved(points: TrackPoints, others: NDArray[np.int32], own: NDArray[np.int32], middle: Floats) -> Floats:
    """(n) mm by which distances are usually off `middle` (n), in frames in which tracks (n, f) and a piece (f) are."""
    xyz = np.where((others >= 0)[..., None], points.xyz[others], np.nan)
    r = np.linalg.norm(xyz - points.xyz[own], axis=-1)
    return np.asarray(SD_PER_MEDIAN * row_medians(np.abs(r - middle[:, None])))


def _scores(before: Places, after: Places, spread: float) -> tuple[Floats, Floats]:
    """(2) of n pairs, −∞ of fewer than FEWEST companions, and the usual σ of (1), mm; one that lacks says nothing."""
    squared = before.variance + after.variance
    off = (after.distance - before.distance) ** 2 / squared
    score = 2 * np.log((1 - STRAY) * spread / np.sqrt(2 * np.pi * squared) * np.exp(-off / 2) + STRAY)
    none = ~np.isfinite(score)
    means, usual = [], []
    for order in (np.minimum(before.distance, after.distance), squared):
        best = np.argsort(np.where(none, np.inf, order), axis=1, kind="stable")[:, :MATES]
        some, there = np.take_along_axis(score, best, 1), ~np.take_along_axis(none, best, 1)
        enough = there.sum(1) >= FEWEST
        means.append(np.where(enough, np.where(there, some, 0.0).mean(1), -np.inf))
        usual.append(np.sqrt(np.where(there, np.take_along_axis(squared, best, 1), 0.0).mean(1)))
    return 3 * np.min(means, axis=0), usual[0]


def _joined(there: Bools, ids: Ints, pairs: Pairs, sure: float) -> list[Stitch]:
    """The joins by (3) of scores above `sure`, the likeliest first; `ids` are then those of what is joined."""
    found = []
    for p in np.argsort(-pairs.score, kind="stable").tolist():
        a, b, score = int(pairs.a[p]), int(pairs.b[p]), float(pairs.score[p])
        if score < sure:
            break
        before, after = int(ids[a]), int(ids[b])
        if before == after or _meet(there, ids == before, ids == after):
            continue
        rival = _rival(there, ids, pairs, a, b)
        if score - rival < CLEAR_MARGIN:
            continue
        ids[ids == max(before, after)] = min(before, after)
        last, first = int(np.flatnonzero(there[a])[-1]), int(there[b].argmax())
        found.append(Stitch(a, b, score, score - rival, float(pairs.sd[p]), last, first))
    return found


def _meet(there: Bools, one: Bools, other: Bools) -> bool:
    """Whether any two pieces of one group and another are there at the same time for more than OVERLAP frames."""
    both = there[one].astype(np.float32) @ there[other].T.astype(np.float32)
    return bool((both > OVERLAP).any())


def _rival(there: Bools, ids: Ints, pairs: Pairs, a: int, b: int) -> float:
    """The highest score of either piece with another marker's, that which is there at the time of its rival."""
    scores = [0.0]
    for one, other, own, taken in ((pairs.a, pairs.b, a, b), (pairs.b, pairs.a, b, a)):
        near = np.flatnonzero((one == own) & ~np.isin(ids[other], ids[[a, b]]))
        at_once = (there[other[near]] & there[taken]).sum(1) > OVERLAP
        scores.append(float(pairs.score[near][at_once].max(initial=0.0)))
    return max(scores)
