"""Which points are which markers, judged by the body: where each marker should be, by the others that it moves with.

A point p of a frame is off marker m by d² = (p − b)ᵀ (B + C)⁻¹ (p − b), with the place b of `body_places`, its
covariance B, and the point's own C (1). Markers that have no point in a frame, or one that is off, and the points that
are off or have no name, are assigned to each other so that Σ (g² − d²) over pairs with d < g is greatest (2). So two
markers that took each other's place change back, a piece that nobody named finds its marker, and a point that is off
and is no other's either is put aside where the place is known well.

A track without a name gives points to markers only where most of it lies at places of such markers: a marker that has
no name passes others' places, and stays at its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ..data.array_types import Bools, Floats, Ints
from .body_places import BodyPlaces, distance

GATE = 5.0
"""g of (2), standard deviations; chosen, as that of the tracker."""
KNOWN_MM = 10.0
"""mm, the most that the standard deviation of a place is by which a marker is given a point; chosen: markers are 25 mm
apart and more."""
ASIDE = 8.0
"""d from which on a point that is no marker's is put aside; chosen: tails of soft tissue and of steps are shorter."""
KEEPS = 0.8
"""Least share of a track without a name that lies at places of markers that have no point; chosen."""
ASIDE_POINT = -2
"""In place of a marker, of a point that is put aside; by definition."""


class NamedPoints(NamedTuple):
    """P points: frame, track, marker (P), −1 of a track without a name; xyz (P, 3) mm, cov (P, 3, 3) mm²; fixed (P),
    of which a person said what they are."""

    frame: Ints
    track: Ints
    marker: Ints
    xyz: Floats
    cov: Floats
    fixed: Bools


def judged(points: NamedPoints, body: BodyPlaces) -> Ints:
    """(P) the marker of each point, −1 for none, ASIDE_POINT where it is put aside."""
    out = points.marker.copy()
    off = _off(points, body) & ~points.fixed
    well = np.sqrt(np.trace(body.cov, axis1=-2, axis2=-1)) < KNOWN_MM
    has = np.zeros(well.shape, bool)
    kept = (points.marker >= 0) & ~off
    has[points.marker[kept], points.frame[kept]] = True
    wanting = well & ~has
    nameless = (points.marker == -1) & ~points.fixed
    rows = np.flatnonzero(off | _at_places(points, body, nameless, wanting))
    wants = wanting.any(0)
    for f in np.unique(points.frame[rows]).tolist():
        own = rows[points.frame[rows] == f] if wants[f] else rows[:0]
        markers = np.flatnonzero(wanting[:, f])
        for p, m in _assigned(points, own, markers, body):
            out[p] = m
    lost = off & (out == points.marker) & (points.marker >= 0)
    out[lost & ~_stays(points, body, out, lost)] = ASIDE_POINT
    return out


def _square(points: NamedPoints, rows: Ints, markers: Ints, body: BodyPlaces) -> Floats:
    """(n) d² of (1) of some points from the places of markers (n)."""
    f = points.frame[rows]
    return distance(points.xyz[rows], body.place[markers, f], body.cov[markers, f] + points.cov[rows])


def _off(points: NamedPoints, body: BodyPlaces) -> Bools:
    """(P) named points that are beyond the gate."""
    rows = np.flatnonzero(points.marker >= 0)
    out = np.zeros(len(points.marker), bool)
    out[rows] = np.nan_to_num(_square(points, rows, points.marker[rows], body)) > GATE**2
    return out


def _at_places(points: NamedPoints, body: BodyPlaces, nameless: Bools, wanting: Bools) -> Bools:
    """(P) points of tracks without a name most of which lies at places of markers (M, F) that have no point."""
    rows = np.flatnonzero(nameless)
    near = np.zeros(len(rows), bool)
    for m in np.flatnonzero(wanting.any(1)).tolist():
        own = np.flatnonzero(wanting[m, points.frame[rows]])
        near[own] |= np.nan_to_num(_square(points, rows[own], np.full(len(own), m), body), nan=np.inf) < GATE**2
    track = points.track[rows]
    n = np.bincount(track)
    most = np.bincount(track, near, len(n)) >= KEEPS * n
    out = np.zeros(len(nameless), bool)
    out[rows] = near & most[track]
    return out


def _assigned(points: NamedPoints, rows: Ints, markers: Ints, body: BodyPlaces) -> list[tuple[int, int]]:
    """Points and markers of one frame by (2)."""
    if not len(rows) or not len(markers):
        return []
    i, j = (grid.ravel() for grid in np.meshgrid(rows, markers, indexing="ij"))
    square = np.nan_to_num(_square(points, i, j, body), nan=np.inf).reshape(len(rows), len(markers))
    gain = np.maximum(GATE**2 - square, 0.0)
    i, j = scipy.optimize.linear_sum_assignment(gain, maximize=True)
    good = gain[i, j] > 0
    return list(zip(rows[i[good]].tolist(), markers[j[good]].tolist(), strict=True))


def _stays(points: NamedPoints, body: BodyPlaces, out: Ints, lost: Bools) -> Bools:
    """(P) points that are off, but keep their names: nobody else took it, and they are not off by ASIDE."""
    rows = np.flatnonzero(lost)
    stays = np.zeros(len(lost), bool)
    own = points.marker[rows]
    f = points.frame[rows]
    taken = np.zeros(body.place.shape[:2], bool)
    others = (out >= 0) & (out != points.marker)
    taken[out[others], points.frame[others]] = True
    well = np.sqrt(np.trace(body.cov[own, f], axis1=-2, axis2=-1)) < KNOWN_MM
    square = _square(points, rows, own, body)
    stays[rows] = ~taken[own, f] & ~(well & (square > ASIDE**2))
    return stays
