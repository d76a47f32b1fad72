"""Stitching over impacts: a track that ends where another goes on from the same place with another velocity.

A ball that bounces, a foot that strikes the floor or a body that lands changes its velocity within a frame by more than
the process noise allows. The track ends, and another begins in the next frame, which was followed back in time to the
impact. With the notation of `stitch`, an impact that changes the velocity by w at a time s before the middle of the gap
between them moves the place there by s w:

    δ = (s w, w) + e,   e ~ N(0, S)                                                       (1)

With w ~ N(m, V), the difference δ is normal about (s m, m) with the covariance

    S_s = S + (s, 1) (s, 1)ᵀ ⊗ V                                                          (2)

for one s, and as any s within the gap is as likely as any other, Laplace's method about the best one gives

    ln p(δ) = ln N(δ; (s m, m), S_s) + ln (√(2π) σ_s / (2 REACH gap)),
    s = δₓ·δᵥ / |δᵥ|²,   σ_s² = δᵥᵀ Sₓₓ δᵥ / |δᵥ|⁴                                          (3)

What hits one marker hits those beside it. Of each pair of tracks p(δ) is the mean of that of an impact of its own,
m = 0, and that of the impacts of up to MATES pairs near it that end in the same frame, m = δᵥ of theirs (4). The score
is that of (1) in `stitch` with this p(δ), and the share of tracks that end by an impact.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Floats, Ints
from ..points.neighbouring_points import TrackPoints
from ..simultaneous_method import Simultaneous
from .stitch import (
    CLEAR_MARGIN,
    Ends,
    Stitched,
    best_stitches,
    differences,
    ends_of,
    log_normal,
    possible,
    prior_of_stitch,
)

GAP = 2
"""Frames of a gap at most; chosen (see benchmarks/impacts.py): of the gaps at impacts 85 % are one frame, as tracks are
followed from both sides."""

OWN_SD = (1500.0, 5000.0)
"""mm/s, the square roots of V of (2), for an impact of which nothing is known: that of a step, and that of a ball.
Chosen (see benchmarks/impacts.py)."""

SHARED_SD = 700.0
"""mm/s, that of the impact of another marker near; chosen (see benchmarks/impacts.py)."""

SHARE = 0.2
"""Of the tracks that end, those that do by an impact; chosen (see benchmarks/impacts.py)."""

REACH = 0.75
"""Of the gap, how far from its middle an impact may be, as the last point of a track may be one after the impact.
Chosen (see benchmarks/impacts.py)."""

LEAST_JUMP, LEAST_SHARE = 1.0, 1e-9
"""mm/s, and of the gap; by definition: of no account beside OWN_SD."""

MATES = 6
"""Pairs of tracks of (4) at most; chosen (see benchmarks/impacts.py)."""


class Jumps(NamedTuple):
    """Of n pairs of tracks δ (n, 6) mm, mm/s and S (n, 6, 6) of `stitch`, s (n) s and ln of the last factor of (3)."""

    delta: Floats
    S: Floats
    s: Floats
    log_width: Floats

    def take(self, which: Ints) -> Jumps:
        """Only these."""
        return Jumps(*(column[which] for column in self))


def with_impacts(points: TrackPoints, whole: Stitched, T: float, method: Simultaneous) -> Stitched:
    """The stitches and those over impacts, of P points whose tracks are numbered after the stitches; T s between
    frames."""
    if not len(points.id):
        return whole
    method = replace(method, max_gap=(GAP + 0.5) * T)
    ends = ends_of(points, T, method)
    a, b = possible(ends, T, method)
    if not len(a):
        return whole
    jumps = _jumps(ends, a, b, T, method)
    alone = _log_alone(jumps)
    shared = _log_shared(jumps, _mates(ends, a, b, alone))
    log_p = np.logaddexp(alone, shared) + np.log(SHARE / 2)
    score = prior_of_stitch(points, ends, T, method) + 2 * (log_p + jumps.log_width)
    sd = np.sqrt(np.trace(jumps.S[:, :3, :3], axis1=1, axis2=2))
    made = [one for one in best_stitches(ends, a, b, score, sd) if one.margin > CLEAR_MARGIN]
    ids = np.arange(len(whole.id))
    for one in sorted(made, key=lambda one: one.last):
        ids[one.after] = ids[one.before]
    return Stitched(ids[whole.id], whole.stitches + made)


def _jumps(ends: Ends, a: Ints, b: Ints, T: float, method: Simultaneous) -> Jumps:
    """What pairs of tracks differ by, and when they meet."""
    delta, S = differences(ends, a, b, T, method)
    dx, dv, reach = delta[:, :3], delta[:, 3:], REACH * T * (ends.first[b] - ends.last[a])
    squared = np.maximum((dv**2).sum(1), LEAST_JUMP**2)
    width = np.sqrt(2 * np.pi * np.einsum("ni,nij,nj->n", dv, S[:, :3, :3], dv)) / squared
    s = np.clip((dx * dv).sum(1) / squared, -reach, reach)
    return Jumps(delta, S, s, np.log(np.clip(width / (2 * reach), LEAST_SHARE, 1.0)))  # (3)


def _log_of_jump(jumps: Jumps, mean: Floats, V: Floats) -> Floats:
    """ln N(δ; (s m, m), S_s) (n) for m (n, 3) mm/s and V (n, 3, 3)."""
    side = np.stack([jumps.s, np.ones(len(jumps.s))], 1)
    S = jumps.S + np.einsum("ni,nj,nkl->nikjl", side, side, V).reshape(-1, 6, 6)  # (2)
    return log_normal(jumps.delta - (side[:, :, None] * mean[:, None]).reshape(-1, 6), S)


def _log_alone(jumps: Jumps) -> Floats:
    """ln of the mean p(δ) (n) over OWN_SD."""
    none, one = np.zeros((len(jumps.s), 3)), np.broadcast_to(np.eye(3), (len(jumps.s), 3, 3))
    each = [_log_of_jump(jumps, none, sd**2 * one) for sd in OWN_SD]
    return np.asarray(np.logaddexp.reduce(each, axis=0) - np.log(len(OWN_SD)))


def _mates(ends: Ends, a: Ints, b: Ints, log_p: Floats) -> list[Ints]:
    """Of each pair the nearest ones that end in its frame, of other tracks, each the likeliest of both its tracks."""
    best = _best(a, log_p) & _best(b, log_p)
    found = []
    for k in range(len(a)):
        near = np.flatnonzero(best & (ends.last[a] == ends.last[a[k]]) & (a != a[k]) & (b != b[k]))
        apart = np.linalg.norm(ends.end.position[:, a[near]] - ends.end.position[:, a[k], None], axis=0)
        found.append(near[np.argsort(apart, kind="stable")[:MATES]])
    return found


def _best(track: Ints, log_p: Floats) -> Bools:
    """(n) which pairs are the likeliest of their track (n)."""
    top = np.full(int(track.max()) + 1, -np.inf)
    np.maximum.at(top, track, log_p)
    return np.asarray(log_p == top[track])


def _log_shared(jumps: Jumps, mates: list[Ints]) -> Floats:
    """ln of the mean p(δ) (n) over the impacts of the mates of each pair, −∞ where it has none."""
    count = np.array([len(own) for own in mates])
    k, other = np.repeat(np.arange(len(mates)), count), np.concatenate(mates)
    V = jumps.S[other, 3:, 3:] + SHARED_SD**2 * np.eye(3)
    log_p = np.full(len(mates), -np.inf)
    np.logaddexp.at(log_p, k, _log_of_jump(jumps.take(k), jumps.delta[other, 3:], V))
    return log_p - np.log(np.maximum(count, 1))
