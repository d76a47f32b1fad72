"""Places where a path may go on as another marker, and whose it may be exchanged with.

    gap       a path was not seen in between
    jump      it goes on where its motion does not lead
    near      another path is so near that either could be the other

At each place the two halves of the path are before and after. Another path may be cut anywhere in it: in a gap, before
the first of its samples there, after the last, in the middle, or where it jumps. Which paths are looked at: those whose
half before is near the half after of the first, or the other way round.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...numerics.runs import true_runs
from .companion_steps import companion_steps
from .paths import Paths

NEAR_SD, NEAR_MM = 8.0, 3.0
"""Standard deviations of both, and mm: within them a path may be another; chosen."""
ONE_PLACE_MM = 5.0
"""mm: two paths that are mostly nearer are computed points or one marker twice, and are not exchanged; chosen: less
than two markers' radii."""
TOLD_S = 0.05
"""s within which a place is one that tracking was not sure of; chosen: such decisions last some frames."""
REACH_MM, REACH_SPEED = 40.0, 3000.0
"""mm, and mm/s: how far a marker may be from where it was last seen; chosen: a marker of a running foot."""
PARTNERS = 4
"""Other paths that are looked at, at most, of a place; chosen."""
APART_S = 1.0
"""s: another path's half that ends, or begins, longer before or after is not looked at; chosen."""


class Partner(NamedTuple):
    """Another path (−1: none), and the index of its last sample before it is cut (−1: it begins later)."""

    path: int
    sample: int


BLOCK = 16
"""Frames whose places are in one box, by which most pairs of paths are seen to keep apart; chosen: of 8 to 64 the
quickest."""
NOBODY = Partner(-1, -1)
"""No other path; by definition."""


class Told(NamedTuple):
    """Tracking was not sure of a path in these frames, `other` (−1: none) being what it may have gone on as; `near`:
    because both came so near that either could have had the other's images."""

    path: int
    first: float
    last: float
    other: int = -1
    near: bool = False

    @property
    def middle(self) -> float:
        """Frame."""
        return (self.first + self.last) / 2


class Place(NamedTuple):
    """Where path `path` goes from its sample of index `sample` to the next, in the middle (frame), and other paths.

    `told` says whether tracking itself was not sure there; `near` whether as another came near (`Told.near`).
    """

    path: int
    sample: int
    middle: float
    partners: tuple[Partner, ...]
    told: bool = False
    near: bool = False


def places(paths: Paths, told: Iterable[Told] = ()) -> list[Place]:
    """All places of a trial.

    Args:
        paths: of the trial.
        told: what tracking was not sure of.
    """
    found = dict[tuple[int, int], set[int]]()
    left = companion_steps(paths)
    for p, own in enumerate(paths.frames):
        for i in [*np.flatnonzero(np.diff(own) > 1).tolist(), *paths.jumps[p].tolist(), *left[p].tolist()]:
            found.setdefault((p, i), set())
    told = tuple(told)
    for p, frame, q in (*_near(paths), *((one.path, one.middle, one.other) for one in told)):
        i = paths.index_before(p, frame)
        if 0 <= i < len(paths.frames[p]) - 1:
            found.setdefault((p, i), set()).update({q} - {-1})
    unsure, near, beside = _unsure(paths, told), _came_near(paths, told), _Beside.of(paths)
    return [
        _place(paths, beside, p, i, others)._replace(told=(p, i) in unsure, near=(p, i) in near)
        for (p, i), others in sorted(found.items())
    ]


def _unsure(paths: Paths, told: Iterable[Told]) -> set[tuple[int, int]]:
    """Paths and indices near to which tracking was not sure."""
    out = set[tuple[int, int]]()
    for one in told:
        own, near = paths.frames[one.path], TOLD_S * paths.rate
        out |= {(one.path, i) for i in range(*np.searchsorted(own, [one.middle - near, one.middle + near]).tolist())}
        out.add((one.path, paths.index_before(one.path, one.middle)))
    return out


def _came_near(paths: Paths, told: Iterable[Told]) -> set[tuple[int, int]]:
    """Paths and indices from which they go on while, or shortly before or after, another came near."""
    out, near = set[tuple[int, int]](), TOLD_S * paths.rate
    for p, first, last, _, _ in (one for one in told if one.near):
        a, b = paths.index_before(p, first - near), paths.index_before(p, last + near)
        out |= {(p, i) for i in range(a, b + 1)}
    return out


class _Beside(NamedTuple):
    """(M, F) of each path and frame, the frame of its last sample up to there, −1 before the first, and of its first
    from there on, F after the last."""

    last: Ints
    next: Ints

    @classmethod
    def of(cls, paths: Paths) -> _Beside:
        n = paths.seen.shape[1]
        at = np.arange(n)
        last = np.maximum.accumulate(np.where(paths.seen, at, -1), axis=1)
        ahead = np.minimum.accumulate(np.where(paths.seen, at, n)[:, ::-1], axis=1)[:, ::-1]
        return cls(last, ahead)


def _place(paths: Paths, beside: _Beside, p: int, i: int, others: set[int]) -> Place:
    own = paths.frames[p]
    middle = (own[i] + own[i + 1]) / 2
    near = dict.fromkeys([*sorted(others), *_partners(paths, beside, p, i)])
    cuts = [cut for q in near for cut in _cuts(paths, q, float(own[i]), float(own[i + 1]))]
    return Place(p, i, float(middle), (NOBODY, *cuts))


def _cuts(paths: Paths, q: int, first: float, last: float) -> list[Partner]:
    """Where path q may be cut between two frames, its own samples in them on either side."""
    frames = paths.frames[q]
    at = {paths.index_before(q, f) for f in (first, (first + last) / 2, last - 0.5)}
    jumps = paths.jumps[q]
    inside = jumps[(frames[jumps] >= first) & (frames[jumps] < last)]
    return [Partner(q, j) for j in sorted(at | set(inside.tolist()))]


def _partners(paths: Paths, beside: _Beside, p: int, i: int) -> list[int]:
    """Those whose halves are nearest to the halves of p."""
    f, g = paths.frames[p][i : i + 2].tolist()
    middle, longest = (f + g) // 2, APART_S * paths.rate
    last, ahead = beside.last[:, middle], beside.next[:, middle + 1]
    near = np.full(len(last), np.inf)
    for there, at, end, frames in (
        ((last >= 0) & (g - last < longest), last, paths.xyz[p, g], g - last),
        ((ahead < beside.last.shape[1]) & (ahead - f < longest), ahead, paths.xyz[p, f], ahead - f),
    ):
        q = np.flatnonzero(there)
        far = np.linalg.norm(paths.xyz[q, at[q]] - end, axis=1)
        near[q] = np.minimum(near[q], far / (REACH_MM + REACH_SPEED * frames[q] / paths.rate))
    near[p] = np.inf
    order = np.argsort(near, kind="stable")[:PARTNERS]
    return order[near[order] < 1].tolist()


def _near(paths: Paths) -> Iterator[tuple[int, float, int]]:
    """Two paths, and the frame in which they are nearest, of each time that they come near."""
    low, high = _boxes(paths.xyz)
    for p in range(len(paths.frames)):
        limit = NEAR_SD * (paths.sd[p] + paths.sd[p + 1 :]) + NEAR_MM
        between = np.maximum(np.maximum(low[p + 1 :] - high[p], low[p] - high[p + 1 :]), 0.0)
        for k in np.flatnonzero(((between**2).sum(-1) < limit[:, None] ** 2).any(1)).tolist():
            apart = np.linalg.norm(paths.xyz[p + 1 + k] - paths.xyz[p], axis=-1)
            row = np.where(np.isnan(apart), np.inf, apart)
            if not row.min(initial=np.inf) < limit[k] or np.nanmedian(apart) < ONE_PLACE_MM:
                continue
            for first, stop in true_runs(row < limit[k]).tolist():
                yield p, float(first + row[first:stop].argmin()), p + 1 + k


def _boxes(xyz: Floats) -> tuple[Floats, Floats]:
    """(M, B, 3) the least and the largest coordinates in each block of frames; +∞ and −∞ where nothing is seen."""
    starts = np.arange(0, xyz.shape[1], BLOCK)
    seen = np.isfinite(xyz)
    low = np.minimum.reduceat(np.where(seen, xyz, np.inf), starts, axis=1) if len(starts) else xyz
    high = np.maximum.reduceat(np.where(seen, xyz, -np.inf), starts, axis=1) if len(starts) else xyz
    return low, high
