"""Which markers tell most of another: reference markers by measured skill.

Two measures, both over frames where all concerned are seen. *Rigidity*: the standard deviation of the distance between
two markers; 0 on one rigid body. *Skill in a gap of half length h*: what a linear bridge over it leaves over half way,

    e(t) = y(t) − (y(t − h) + y(t + h)) / 2                                                             (1)

of whatever y is to be bridged; e is linear in y, so (1) of a difference of markers is the difference of their (1). It
is worked out at a few hundred instants spread over the trial, and h is rounded to within some 6 %, so that gaps of
about the same length share it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from ..data.array_types import Bools, Floats, Ints
from ..geometry.rigid_pairs import distances_from
from .known_samples import KnownSamples

INSTANTS = 150
"""Instants at which reference markers are judged; chosen (see benchmarks/gaps.py)."""


class MarkerDistances(NamedTuple):
    """Distances from one marker to all.

    Attributes:
        mean: (M) mm, infinite where the two are never seen together.
        sd: (M) mm, infinite where they are seen together in fewer than two frames.
        together: (M) frames in which both are seen.
    """

    mean: Floats
    sd: Floats
    together: Ints


Distances = Callable[[int], MarkerDistances]


def distances(known: KnownSamples) -> Distances:
    """A function that gives the distances of all markers from one, worked out once for each."""
    x = known.x[:, known.thin(INSTANTS)]
    return cache(lambda marker: _apart(x, marker))


def _apart(x: Floats, marker: int) -> MarkerDistances:
    found = distances_from(x, marker)
    mean, sd = np.where(found.frames > 0, found.mean, np.inf), np.where(found.frames > 1, found.spread, np.inf)
    mean[marker], sd[marker] = 0.0, 0.0
    return MarkerDistances(mean, sd, found.frames)


def nearest(distance: Floats, there: Bools, most: int) -> Ints:
    """Up to so many of the markers at hand, the nearest first, by distances (M) that may be infinite."""
    order = np.argsort(np.where(there, distance, np.inf), kind="stable")[:most]
    return order[there[order] & np.isfinite(distance[order])]


def rounded(half: int) -> int:
    """h, to within 6 % above 8 frames."""
    return half if half <= 8 else round(8 * 1.12 ** round(np.log(half / 8) / np.log(1.12)))


def triples(known: KnownSamples, half: int) -> Floats:
    """All markers (M, 3, T, 3) at t − h, t and t + h for T instants t; h shrinks where the trial is too short."""
    h = min(rounded(half), (known.n_frames - 1) // 2)
    t = np.arange(h, known.n_frames - h) if h else np.zeros(0, np.int64)
    t = t[:: max(1, -(-len(t) // INSTANTS))]
    return known.at(np.arange(len(known.names))[:, None, None], np.stack([t - h, t, t + h]))


def bridge_error(y: Floats) -> Floats:
    """(1) for y (…, 3, T, 3): (…, T, 3)."""
    return y[..., 1, :, :] - (y[..., 0, :, :] + y[..., 2, :, :]) / 2


def mean_square(e: Floats, *, least: int = 1) -> Floats:
    """Mean |e|² (…) of errors (…, T, 3), infinite where fewer than `least` are known."""
    square = (e * e).sum(-1)
    n = (~np.isnan(square)).sum(-1)
    total = np.nansum(square, axis=-1)
    return np.divide(total, n, out=np.full(np.shape(total), np.inf), where=n >= max(least, 1))


def covariance(e: Floats) -> Floats:
    """Mean e eᵀ (3, 3) of errors (T, 3), NaN where none is known."""
    e = e[~np.isnan(e[:, 0])]
    return e.T @ e / len(e) if len(e) else np.full((3, 3), np.nan)
