"""Whole markers exchanged where the places that a template foretells say so: for templates that may be off.

All that has one label is taken as one marker, and so are tracks without a label that are seen for long, alone or as a
chain. Markers take labels anew as one assignment by

    e3(m, a) + 0.1 e(m, a)                                                                                       (1)

with e3 the mean of `shape` (2) and e of `sweeps` (1), and the places follow, until nothing changes. The first rounds go
by e3 alone: distances carry a chain of wrong names, each of which supports the next. Of the labellings before and after
that is kept whose sum of (1) is greater; each label without a marker costs 10 nats.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats, Ints
from ..numerics.evenly import evenly_rounded
from .chains import rechained
from .evidence import PairScore, Single
from .on_body import on_body
from .shape import ALL, FLOOR, Shapes
from .stretches import Stretches
from .sweeps import places
from .template import Template

FRAMES = 40
"""In which markers are looked at; chosen."""
TEMPER = 0.1
"""Of distances' evidence: some ten of them are worth one independent proof; chosen."""
ROUNDS = (0.0, 0.0, 0.0, TEMPER, TEMPER, TEMPER)
"""Share of distances in each round; chosen."""
ABSENT = 10.0
"""What a label costs that no marker has, nats; chosen: one marker in a hundred is absent,
and one long track in a hundred is no marker."""
CLEAR = 3.0
"""By which a track goes on as another rather than as the next, or as none, nats; chosen."""
TRUSTED = -2.0
"""Least of e3 with which a marker tells where others are, nats; chosen: one that is off misleads."""
CHAIN_FRAMES = 10
"""In which chains of markers are looked for; chosen: those that gain are then scored in all."""
LONG = 0.3
"""Share of the frames in which a track without label counts as a marker; chosen."""


class Markers(NamedTuple):
    """M markers in some frames: (K, M, 3) places, (M) their labels, −1 for none; (T) which a track is part of."""

    xyz: Single
    label: Ints
    of: Ints


def arranged(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Ints:
    """(T) labels after whole markers took those that suit them better."""
    shapes, L = Shapes.of(template), len(template)
    if not shapes.known.any() or not (label >= 0).any():
        return label
    markers = markers_of(stretches, label, L)
    now, best = markers.label, markers.label
    most = sum_of(markers, now, shapes, pairs)
    settled = -1.0
    for share in ROUNDS:
        if share == settled:
            continue
        was, tells = now, _trusted(markers, now, shapes, pairs)
        now = _assigned(nats_of(markers, tells, shapes, pairs, share), FLOOR if share == 0 else -ABSENT)
        settled = share if (now == was).all() else settled
        total = sum_of(markers, now, shapes, pairs)
        if total > most + 1e-6:
            best, most = now, total
    few = markers._replace(xyz=markers.xyz[:: max(1, len(markers.xyz) // CHAIN_FRAMES)])
    worth, was = nats_of(few, best, shapes, pairs, 0.0), best
    known = np.where(shapes.known, 0.0, -np.inf)
    best = rechained(
        was,
        lambda now: _moved_nats(few, was, now, shapes, worth) + known,
        _sum_from(few, was, shapes, pairs),
        _sum_from(markers, was, shapes, pairs),
        least=TRUSTED,
        absent=ABSENT,
    )
    return np.where(markers.of >= 0, best[markers.of], label)


def score_by_places(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> float:
    """Nats of a labelling (T), by which those before and after are judged."""
    markers = markers_of(stretches, label, len(template))
    return sum_of(markers, markers.label, Shapes.of(template), pairs)


def markers_of(stretches: Stretches, label: Ints, L: int) -> Markers:
    """Labels that are there, and long chains of tracks without one that are `on_body`."""
    chain = L + _chains(stretches, label)
    long = np.array([stretches.seen[chain == c].any(0).mean() > LONG for c in range(L, chain.max() + 1)], bool)
    whose = np.where(label >= 0, label, np.where(np.r_[np.zeros(L, bool), long][chain], chain, -1))
    kept, of = np.unique(whose[whose >= 0], return_inverse=True)
    part = np.full(len(label), -1)
    part[whose >= 0] = of
    some = evenly_rounded(len(stretches.frame), FRAMES)
    xyz, now = places(stretches, part, len(kept))[some], np.where(kept < L, kept, -1)
    there = on_body(xyz, now >= 0)
    turn = np.where(there, np.cumsum(there) - 1, -1)
    return Markers(xyz[:, there], now[there], np.r_[turn, -1][part])  # −1, of none, is the last


def _chains(stretches: Stretches, label: Ints) -> Ints:
    """(T) which tracks without label go on with each other, by motion, where no other does nearly as well, nor none.

    One that goes on by way of another does not contradict that one.
    """
    link = stretches.link.tocoo()
    free = (label[link.row] < 0) & (label[link.col] < 0) & (link.data > 0)
    row, column, nats = link.row[free].astype(np.int64), link.col[free].astype(np.int64), link.data[free]
    clear = nats > CLEAR
    steps = scipy.sparse.csr_array((np.ones(clear.sum()), (row[clear], column[clear])), shape=link.shape)
    direct = np.asarray((steps @ steps)[row, column]).ravel() == 0 if len(row) else clear
    row, column, nats = row[direct], column[direct], nats[direct]
    sure = _clearly_best(row, nats) & _clearly_best(column, nats)
    joined = scipy.sparse.coo_array((nats[sure], (row[sure], column[sure])), shape=link.shape)
    return np.asarray(scipy.sparse.csgraph.connected_components(joined, directed=False)[1])


def _clearly_best(group: Ints, nats: Floats) -> NDArray[np.bool_]:
    """Entries that are the best of their group, by `CLEAR` at least, and of so many nats more than any place has."""
    order = np.lexsort((-nats, group))
    first = np.r_[True, np.diff(group[order]) != 0] if len(order) else np.zeros(0, bool)
    next_in_group = np.r_[~first[1:], False] if len(order) else first
    gap = nats[order] - np.where(next_in_group, np.r_[nats[order][1:], 0.0][: len(order)], 0.0)
    out = np.zeros(len(nats), bool)
    out[order] = first & (gap > CLEAR)
    return out


def nats_of(markers: Markers, now: Ints, shapes: Shapes, pairs: PairScore, share: float) -> Floats:
    """(M, L) of (1), 0.1 being `share`; the names of now tell where labels are."""
    K, y = len(markers.xyz), _named(markers, now, len(shapes.sigma))
    each = shapes.nats(markers.xyz.astype(float), shapes.foretold(y))
    count = np.maximum(np.isfinite(each).sum(0), 1)
    nats = np.nansum(each, 0) / count
    if share > 0:
        far = np.where(np.isfinite(markers.xyz), markers.xyz, np.nan)
        seen = np.maximum(np.isfinite(far[..., 0]).sum(0), 1)
        told = sum(np.nan_to_num(pairs.of_points(far[k], y[k], now)) for k in range(K))
        nats = nats + share * np.asarray(told) / seen[:, None]
    return np.asarray(nats)


def _trusted(markers: Markers, now: Ints, shapes: Shapes, pairs: PairScore) -> Ints:
    """(M) the labels of now without those of markers that are far from where they should be."""
    own = nats_of(markers, now, shapes, pairs, 0.0)[np.arange(len(now)), np.maximum(now, 0)]
    return np.where((now >= 0) & (own > TRUSTED), now, -1)


def _assigned(nats: Floats, least: float) -> Ints:
    """(M) labels with the greatest sum; a marker that is not worth `least` has none."""
    gain = np.maximum(nats + ABSENT, 0.0)
    rows, columns = scipy.optimize.linear_sum_assignment(-gain)
    out = np.full(len(nats), -1)
    good = nats[rows, columns] > least
    out[rows[good]] = columns[good]
    return out


def sum_of(markers: Markers, now: Ints, shapes: Shapes, pairs: PairScore, placed: Floats | None = None) -> float:
    """Nats of a labelling; a marker that is there in some of the frames counts, and costs, by these.

    Args:
        placed: (L) of `own_places`, where they are known.
    """
    y, L = _named(markers, now, len(shapes.sigma)), len(shapes.sigma)
    nats = own_places(markers, now, shapes) if placed is None else placed
    seen = np.isfinite(y[..., 0]).sum(0)
    nats = nats + TEMPER * pairs.of_own(y).sum(0) / np.maximum(seen, 1)
    share = seen / len(y)
    return float((share * nats).sum()) - ABSENT * float(L - share.sum())


def _sum_from(markers: Markers, was: Ints, shapes: Shapes, pairs: PairScore) -> Callable[[Ints], float]:
    """`sum_of` labels (M) that were others of a few."""
    placed = own_places(markers, was, shapes)
    return lambda now: sum_of(markers, now, shapes, pairs, moved_places(markers, was, now, shapes, placed))


def own_places(markers: Markers, now: Ints, shapes: Shapes, at: Ints | slice = ALL) -> Floats:
    """(n) nats of labels, all or some, by the places of the markers that are so called; 0 where nothing is known."""
    each = shapes.nats_of_own(_named(markers, now, len(shapes.sigma)), at)
    return np.asarray(np.nansum(each, 0) / np.maximum(np.isfinite(each).sum(0), 1))


def moved_places(markers: Markers, was: Ints, now: Ints, shapes: Shapes, placed: Floats) -> Floats:
    """(L) of `own_places` under labels (M) now, from those, `placed`, under labels (M) that were others of a few."""
    anew = _anew(was, now, shapes)
    out = placed.copy()
    out[anew] = own_places(markers, now, shapes, anew)
    return out


def _moved_nats(markers: Markers, was: Ints, now: Ints, shapes: Shapes, worth: Floats) -> Floats:
    """(M, L) of `nats_of` by places alone, in the same way."""
    anew = _anew(was, now, shapes)
    out = worth.copy()
    each = shapes.nats(markers.xyz.astype(float), shapes.foretold(_named(markers, now, len(shapes.sigma)), anew), anew)
    out[:, anew] = np.nansum(each, 0) / np.maximum(np.isfinite(each).sum(0), 1)
    return out


def _anew(was: Ints, now: Ints, shapes: Shapes) -> Ints:
    """Labels that another marker has now, and those that have one of them as a neighbour."""
    both = np.concatenate([was[now != was], now[now != was]])
    return np.flatnonzero(np.isin(shapes.near, both).any(1) | np.isin(np.arange(len(shapes.sigma)), both))


def _named(markers: Markers, now: Ints, L: int) -> Single:
    """(K, L, 3) where each label is; NaN where no marker has it."""
    y = np.full((len(markers.xyz), L, 3), np.nan, np.float32)
    y[:, now[now >= 0]] = markers.xyz[:, now >= 0]
    return y
