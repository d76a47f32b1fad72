"""Markers that are lost together keep their distances: fills of one body moved by what they say of each other.

Each gap is filled for itself. Where markers of one segment are missing at once their fills err apart, and the distances
between them come out wrong, though the trial tells these well. With x̂_a the fill of marker a in a frame, P_a its
covariance, scaled such that it states the expected error of the gap, d_ab and s_ab mean and standard deviation of the
distance of two markers where both are seen, the places in that frame are those of the least

    Σ (x_a − x̂_a)ᵀ P_a⁻¹ (x_a − x̂_a) + Σ w_ab (|x_a − x_b| − d_ab)²                                       (1)

    1 / w_ab = (K s_ab)² + (p_a + p_b) (p_a − p_b)² / (4 p_a p_b),     p = tr P / 3                         (2)

over the gap's marker and the MOST others missing there that keep their distance from it best. Found by Gauss–Newton.
Distances from markers that are seen are not used: methods have learnt from these, and more (they made fills worse). By
the second part of (2), 0 where both are known equally well, a distance fades in as the other marker gets lost: a fill
does not step where another's gap begins or ends. Fills of which `contradiction` (1) says that the expected error cannot
be true have no part in it, as they look better known than they are.
No hold-out gap hides all of them to be filled together, so expected errors and covariances stay what they were.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations

import numpy as np

from ...data.array_types import Floats
from ...geometry.rigid_pairs import distances_from
from ..marker_array import MarkerArray
from ..reference_markers import Distances, MarkerDistances
from ..reference_ranking import FEWEST
from .choice import ChosenFill
from .contradiction import SD_RATIO
from .expected_error import size

K = 4.0
"""Times the standard deviation elsewhere of a distance, to which it is known in a gap; chosen: of 1 to 4 the best."""
MOST = 3
"""Other markers that a fill is moved by; chosen: a segment mostly has four."""
INSTANTS = 400
"""Frames that tell distances, about; chosen for time."""
LEAST = 0.01
"""mm, standard deviation of a distance at least; chosen: files round to about that."""
SHARPEST = 0.001
"""mm, added to the standard deviation of a place, as P has to be invertible; chosen: well below LEAST."""
OFTEN = 0.5
"""Of the frames of the marker that is seen more, in which both are seen at least for their distance to be used; chosen:
together in a few frames, at rest say, any two keep it."""
STEPS = 3
"""Gauss–Newton steps; chosen: the next one moves places by less than noise."""


@dataclass(frozen=True, slots=True)
class _Company:
    """Fills over the L frames of the first one's gap.

    Attributes:
        xyz: (L, n, 3) mm; any where there is none.
        inverse: (L, n, 3, 3) P⁻¹; 1 where there is none.
        p: (L, n) mm², tr P / 3; 0 where there is none.
        markers: rows of the trial.
    """

    xyz: Floats
    inverse: Floats
    p: Floats
    markers: Sequence[int]


def with_kept_distances(motion: MarkerArray, fills: Sequence[ChosenFill]) -> list[ChosenFill]:
    """The fills moved by (1); as they are those that no other is made at once with, and those of a method by itself."""
    usable = [fill for fill in fills if _usable(fill)]
    marker, start, stop = np.array([fill.gap for fill in usable], np.int64).reshape(-1, 3).T
    thin = motion.xyz[:, :: max(1, motion.xyz.shape[1] // INSTANTS)]
    distances = cache(lambda marker: _distances(thin, marker))
    moved = {}
    for fill in usable:
        at_once = (marker != fill.gap.marker) & (start < fill.gap.stop) & (fill.gap.start < stop)
        s = np.where(at_once, distances(fill.gap.marker).sd[marker], np.inf)
        others = [usable[k] for k in np.argsort(s, kind="stable")[:MOST] if np.isfinite(s[k])]
        if others:
            moved[fill.gap] = _moved(fill, others, distances)
    return [moved.get(fill.gap, fill) for fill in fills]


def _usable(fill: ChosenFill) -> bool:
    """Whether it was chosen among several, and its covariance is known and does not contradict the expected error."""
    found = fill.found
    several = bool(found.method) and len(fill.candidates) > 1
    return several and bool(np.isfinite(fill.cov).all()) and found.sd_mm <= SD_RATIO * found.expected_mm


def _distances(thin: Floats, marker: int) -> MarkerDistances:
    """d and s of (1) from one marker to all; s infinite where the two are seldom seen together."""
    found = distances_from(thin, marker)
    seen = np.count_nonzero(~np.isnan(thin[..., 0]), axis=1)
    often = found.frames >= np.maximum(FEWEST, OFTEN * np.maximum(seen, seen[marker]))
    sd = np.where(often, np.maximum(found.spread, LEAST), np.inf)
    return MarkerDistances(found.mean, sd, found.frames)


def _moved(one: ChosenFill, others: list[ChosenFill], distances: Distances) -> ChosenFill:
    company = _company(one, others)
    pairs = []
    for b, a in combinations(range(len(others) + 1), 2):
        d, s, _ = (each[company.markers[b]] for each in distances(company.markers[a]))
        if company.markers[a] != company.markers[b] and np.isfinite(s):
            pairs.append((a, b, float(d), _weight(company.p[:, a], company.p[:, b], s)))
    xyz = company.xyz
    for _ in range(STEPS):
        xyz = xyz + _step(company, xyz, pairs)
    return one._replace(prediction=one.prediction._replace(xyz=xyz[:, 0]))


def _weight(p: Floats, q: Floats, s: float) -> Floats:
    """(2), 1 / mm²; 0 where one of the two has no fill."""
    both = p * q
    return np.asarray(both / np.maximum(both * (K * s) ** 2 + (p + q) * (p - q) ** 2 / 4, SHARPEST**6))


def _company(one: ChosenFill, others: Sequence[ChosenFill]) -> _Company:
    gap, n = one.gap, 1 + len(others)
    xyz = np.repeat(one.prediction.xyz[:, None], n, axis=1) + np.arange(n)[:, None]  # apart, where there is none
    inverse, p = np.tile(np.eye(3), (gap.length, n, 1, 1)), np.zeros((gap.length, n))
    for k, fill in enumerate((one, *others)):
        start, stop = max(gap.start, fill.gap.start), min(gap.stop, fill.gap.stop)
        ours, theirs = (slice(start - g.start, stop - g.start) for g in (gap, fill.gap))
        P = (fill.found.expected_mm / size(fill.cov)) ** 2 * fill.cov[theirs] + SHARPEST**2 * np.eye(3)
        xyz[ours, k], inverse[ours, k] = fill.prediction.xyz[theirs], np.linalg.inv(P)
        p[ours, k] = np.trace(P, axis1=1, axis2=2) / 3
    return _Company(xyz, inverse, p, [one.gap.marker, *(other.gap.marker for other in others)])


def _step(company: _Company, xyz: Floats, pairs: Sequence[tuple[int, int, float, Floats]]) -> Floats:
    """(L, n, 3) mm: one Gauss–Newton step of (1), from pairs a, b, d and what it counts w (L), 1 / mm²."""
    L, n = xyz.shape[:2]
    H = np.zeros((L, n, 3, n, 3))
    own = np.arange(n)
    H[:, own, :, own] = company.inverse.swapaxes(0, 1)
    g = np.einsum("fkij,fkj->fki", company.inverse, xyz - company.xyz)
    for a, b, d, w in pairs:
        apart = xyz[:, a] - xyz[:, b]
        far = np.maximum(np.linalg.norm(apart, axis=1), LEAST)
        along = apart / far[:, None]
        pull = (w * (far - d))[:, None] * along
        g[:, a] += pull
        g[:, b] -= pull
        square = w[:, None, None] * along[:, :, None] * along[:, None]
        for row, column, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            H[:, row, :, column] += sign * square
    return -np.linalg.solve(H.reshape(L, 3 * n, 3 * n), g.reshape(L, 3 * n, 1)).reshape(L, n, 3)
