"""Whole markers exchanged where the places that a template foretells say so: for templates that may be off.

All that has one label is taken as one marker, and the tracks without a label that are seen for long with them. Markers
take labels anew as one assignment by

    e3(m, a) + 0.1 e(m, a)                                                                                       (1)

with e3 the mean of `shape` (2) and e of `sweeps` (1), and the places follow, until nothing changes. The first rounds go
by e3 alone: distances carry a chain of wrong names, each of which supports the next. Of the labellings before and after
that is kept whose sum of (1) is greater; each label without a marker costs 5 nats.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Floats, Ints
from .evidence import PairScore, Single
from .shape import FLOOR, Shapes
from .stretches import Stretches
from .sweeps import places
from .template import Template

FRAMES = 40
"""In which markers are looked at; chosen."""
TEMPER = 0.1
"""Of distances' evidence: some ten of them are worth one independent proof; chosen."""
ROUNDS = (0.0, 0.0, 0.0, TEMPER, TEMPER, TEMPER)
"""Share of distances in each round; chosen."""
ABSENT = 5.0
"""What a label costs that no marker has, nats; chosen: about one marker in a hundred is absent."""
LONG = 0.5
"""Share of the frames in which a track without label counts as a marker; chosen."""


class Markers(NamedTuple):
    """M markers in some frames: (K, M, 3) places, and (M) the label of each now, −1 for none; track (M) or −1."""

    xyz: Single
    label: Ints
    track: Ints


def arranged(stretches: Stretches, label: Ints, template: Template, pairs: PairScore) -> Ints:
    """(T) labels after whole markers took those that suit them better."""
    shapes, L = Shapes.of(template), len(template)
    if not shapes.known.any() or not (label >= 0).any():
        return label
    markers = _markers(stretches, label, L)
    now, best = markers.label, markers.label
    most = _sum(_nats(markers, now, shapes, pairs, TEMPER), now, L)
    for share in ROUNDS:
        now = _assigned(_nats(markers, now, shapes, pairs, share))
        total = _sum(_nats(markers, now, shapes, pairs, TEMPER), now, L)
        if total > most + 1e-6:
            best, most = now, total
    return _spread(label, markers, best)


def _markers(stretches: Stretches, label: Ints, L: int) -> Markers:
    """Labels that are there, and long tracks without one."""
    some = np.unique(np.linspace(0, len(stretches.frame) - 1, min(len(stretches.frame), FRAMES)).round().astype(int))
    y = places(stretches, label, L)[some]
    there = np.flatnonzero(np.isfinite(y[..., 0]).any(0))
    free = np.flatnonzero((label < 0) & (stretches.seen.mean(1) > LONG))
    xyz = np.concatenate([y[:, there], stretches.xyz[free][:, some].transpose(1, 0, 2)], axis=1)
    return Markers(xyz, np.r_[there, np.full(len(free), -1)], np.r_[np.full(len(there), -1), free])


def _nats(markers: Markers, now: Ints, shapes: Shapes, pairs: PairScore, share: float) -> Floats:
    """(M, L) of (1), 0.1 being `share`; the names of now tell where labels are."""
    K, L = len(markers.xyz), len(shapes.sigma)
    y = np.full((K, L, 3), np.nan, np.float32)
    y[:, now[now >= 0]] = markers.xyz[:, now >= 0]
    each = shapes.nats(markers.xyz.astype(float), shapes.foretold(y))
    count = np.maximum(np.isfinite(each).sum(0), 1)
    nats = np.nansum(each, 0) / count
    if share > 0:
        far = np.where(np.isfinite(markers.xyz), markers.xyz, np.nan)
        seen = np.maximum(np.isfinite(far[..., 0]).sum(0), 1)
        told = sum(np.nan_to_num(pairs.of_points(far[k], y[k], now)) for k in range(K))
        nats = nats + share * np.asarray(told) / seen[:, None]
    return np.asarray(nats)


def _assigned(nats: Floats) -> Ints:
    """(M) labels with the greatest sum; a marker that is worth less than an absent label has none."""
    gain = np.maximum(nats + ABSENT, 0.0)
    rows, columns = scipy.optimize.linear_sum_assignment(-gain)
    out = np.full(len(nats), -1)
    good = nats[rows, columns] > FLOOR
    out[rows[good]] = columns[good]
    return out


def _sum(nats: Floats, now: Ints, L: int) -> float:
    """Nats of a labelling."""
    own = np.flatnonzero(now >= 0)
    return float(nats[own, now[own]].sum()) - ABSENT * (L - len(own))


def _spread(label: Ints, markers: Markers, new: Ints) -> Ints:
    """(T) the markers' new labels for their tracks."""
    turn = np.full(int(max(label.max(), markers.label.max())) + 2, -1)
    named = markers.label >= 0
    turn[markers.label[named]] = new[named]
    out = np.where(label >= 0, turn[label], -1)
    out[markers.track[~named]] = new[~named]
    return np.asarray(out)
