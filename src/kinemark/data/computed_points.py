"""Points of a file that are no markers, but computed of markers by a program: segments' axes, joint centres, midpoints.

A program draws a segment as an origin o and the tips a, b, c of its axes. In every frame

    (a − o)·(b − o) = (b − o)·(c − o) = (c − o)·(a − o) = 0     to hundredths of a millimetre                      (1)

which no markers on skin do. The tips are computed where they are equally far from o in every frame, or are named alike,
as LTIB1, LTIB2 and LTIB3 are; a marker that the axis was made of lies on it as well (LKNE on that of the femur), but is
neither. The origin is computed where it is the tip of another segment, or is named as its tips are; a marker may be
the origin, but not where another point is nearer to it than two markers can be. Computed as well is what is

    the mean of two other points in every frame, whose distance changes,                                          (2)
    or moves along no axis of the world, or not along one, while the others move,                                 (3)

and what stands above the latter and begins its name, as a centre of mass. Nothing is told by a name alone. Points that
hang on markers in other ways are not found: they compete with markers that are near, and no others.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, takewhile
from typing import NamedTuple

import numpy as np

from .array_types import Bools, Floats, Ints
from .trajectories import Trajectories

FRAMES = 40
"""Frames of a trial that are looked at, evenly spread; chosen: markers keep (1) in none of them."""
FEWEST = 10
"""Of these, in which points must be seen together, or all of a shorter trial; chosen."""
SEEN = 0.3
"""Share of them that a point must be seen in to be looked at; chosen: pieces of tracks are not, as there are many."""
FIRST = 4
"""Frames by which pairs are passed over that do not keep (1); chosen, for speed."""
EXACT = 2e-6
"""Of the size of all that is seen: 0.004 mm of 2 m; chosen: of 30 trials, axes keep (1) to 0.002 mm, and no markers do
to 0.1 mm."""
COARSE = 3.0
"""Steps of coordinates that were stored coarsely, within which (1) to (3) hold; chosen: three points are rounded."""
APART = 100.0
"""Times as much as is exact: by which two points are apart, or that of those that a mean is of changes; chosen."""
LEAST_LEFT = 4
"""Points that are left, by definition of `learn_template`; else all is one thing of right angles."""
NEAR = 1.5e-3
"""Of the same size, by which two markers are apart, at the least: 3 mm of 2 m, the smallest marker; chosen."""
MOVES = 0.05
"""Of the same size, by which a point moves, or a trial; chosen."""


class Axes(NamedTuple):
    """Numbers of the points that are an origin and three tips (1)."""

    origin: int
    tips: tuple[int, int, int]


def computed_points(trial: Trajectories, *, least_left: int = LEAST_LEFT) -> tuple[str, ...]:
    """Names of the points of a labelled trial that were computed of others, in its order; empty where none were.

    Args:
        trial: labelled. least_left: points that must be left, else none is said to be computed.
    """
    rows = np.unique(np.linspace(0, trial.n_frames - 1, min(trial.n_frames, FRAMES)).round().astype(int))
    xyz = trial.xyz[:, rows]
    seen = np.isfinite(xyz).all(-1)
    at = np.flatnonzero(seen.sum(1) >= max(1, SEEN * len(rows)))
    if len(at) < 4:
        return ()
    names, p = tuple(trial.names[k] for k in at), xyz[at] - np.nanmean(xyz[at], axis=(0, 1))
    size = float(np.linalg.norm(np.nanpercentile(p, 95, axis=(0, 1)) - np.nanpercentile(p, 5, axis=(0, 1))))
    exact = max(EXACT * size, COARSE * _step(p))
    axes = _certain([one for o in range(len(p)) for one in _axes_at(p, o, exact)], p, names, exact)
    found = _of_axes(axes, names) | _means(p, exact) | _still(p, names, exact, MOVES * size)
    found |= _beside_markers(p, axes, exact, NEAR * size)
    return tuple(np.array(names)[found].tolist()) if (~found).sum() >= least_left else ()


def _step(p: Floats) -> float:
    """The step that coordinates were stored in, mm, or less: the least that one changes by; 0 where none does."""
    change = np.abs(np.diff(p, axis=1))
    return float(np.min(change, where=change > 0, initial=np.inf)) if (change > 0).any() else 0.0


def _together(some: Floats) -> Bools:
    """Whether values (…, K), NaN where not seen, are seen in enough frames."""
    return np.asarray(np.isfinite(some).sum(-1) >= min(FEWEST, some.shape[-1]))


def _axes_at(p: Floats, o: int, exact: float) -> list[Axes]:
    """All (1) with this origin."""
    v = p - p[o]
    length = np.linalg.norm(v, axis=-1)
    near = np.where(np.isfinite(length), length, np.inf).min(1) > APART * exact
    at = np.flatnonzero(near & _together(length))
    if len(at) < 3:
        return []
    u, slack = v[at] / length[at, :, None], exact / length[at]
    right = np.zeros((len(at), len(at)), bool)
    some = np.unique(np.linspace(0, p.shape[1] - 1, FIRST).astype(int))
    looked_at = u[:, some].swapaxes(0, 1)
    angle = np.abs(looked_at @ looked_at.swapaxes(1, 2))
    maybe = ~(angle > slack.T[some][:, :, None] + slack.T[some][:, None]).any(0)
    for i, j in np.argwhere(np.triu(maybe, 1)):
        off = np.abs((u[i] * u[j]).sum(-1)) - slack[i] - slack[j]
        right[i, j] = _together(off) and bool((off[np.isfinite(off)] < 0).all())
    pairs = [tuple(pair) for pair in np.argwhere(right).tolist()]
    threes = [(i, j, k) for i, j in pairs for k in np.flatnonzero(right[i] & right[j]).tolist() if k > j]
    return [Axes(o, (int(at[i]), int(at[j]), int(at[k]))) for i, j, k in threes]


def _certain(axes: Sequence[Axes], p: Floats, names: Sequence[str], exact: float) -> list[Axes]:
    """Those whose tips are equally far from the origin, or named alike."""
    return [
        one
        for one in axes
        if _equally_far(p[list(one.tips)] - p[one.origin], exact) or _alike([names[k] for k in one.tips])
    ]


def _equally_far(v: Floats, exact: float) -> bool:
    """Whether (3, K, 3) are equally long in every frame."""
    length = np.linalg.norm(v, axis=-1)
    return bool(np.nanmax(np.ptp(length, axis=0)) < 2 * exact)


def _alike(names: Sequence[str]) -> bool:
    """Whether names begin alike and end otherwise, by no more letters than they share: LTIB1, LTIB2."""
    bare = [name.rpartition(":")[2] for name in names]
    shared = sum(1 for _ in takewhile(lambda letters: len(set(letters)) == 1, zip(*bare, strict=False)))
    return not bare[0].startswith("*") and all(0 < len(name) - shared <= shared for name in bare)


def _of_axes(axes: Sequence[Axes], names: Sequence[str]) -> Bools:
    """(M) whether each is a tip, or an origin that is named as its tips are."""
    found = np.zeros(len(names), bool)
    for one in axes:
        found[list(one.tips)] = True
        found[one.origin] |= _alike([names[k] for k in (one.origin, *one.tips)])
    return found


def _beside_markers(p: Floats, axes: Sequence[Axes], exact: float, near: float) -> Bools:
    """(M) whether each is an origin, or in the same place, where another point is too near for both to be markers."""
    found = np.zeros(len(p), bool)
    for o in {one.origin for one in axes}:
        d = np.linalg.norm(p - p[o], axis=-1)
        known = _together(d)
        far = np.nanmax(np.where(known[:, None], d, np.inf), axis=1)
        if (known & (far > exact) & (np.nanmedian(np.where(known[:, None], d, np.inf), axis=1) < near)).any():
            found |= far <= exact
    return found


def _means(p: Floats, exact: float) -> Bools:
    """(M) whether each is the mean (2) of two others."""
    found, frame = np.zeros(len(p), bool), int(np.isfinite(p[..., 0]).sum(0).argmax())
    there = np.flatnonzero(np.isfinite(p[:, frame, 0]))
    twos = np.array([pair for pair in combinations(there.tolist(), 2)], np.int64).reshape(-1, 2)
    if not len(twos):
        return found
    for pair, one in _near(p[there, frame], p[twos, frame].mean(1), exact).tolist():
        (i, j), m = twos[pair], there[one]
        apart, off = np.linalg.norm(p[i] - p[j], axis=-1), np.linalg.norm(p[m] - (p[i] + p[j]) / 2, axis=-1)
        own = np.isfinite(off)
        known = _together(off) and np.ptp(apart[own]) > APART * exact
        found[m] |= bool(known and (off[own] < exact).all() and (apart[own] > APART * exact).all())
    return found


def _near(points: Floats, places: Floats, within: float) -> Ints:
    """(H, 2) numbers of a place and of a point that is within this distance of it.

    By the axis along which the points spread most, as a tree of them would first have to be imported.
    """
    axis = int(np.ptp(points, axis=0).argmax())
    order = points[:, axis].argsort()
    along, centre = points[order, axis], places[:, axis]
    first, stop = np.searchsorted(along, centre - within), np.searchsorted(along, centre + within, side="right")
    place = np.repeat(np.arange(len(places)), stop - first)
    before = np.cumsum(stop - first) - (stop - first)
    one = order[np.arange(len(place)) + (first - before)[place]]
    near = np.linalg.norm(points[one] - places[place], axis=-1) <= within
    return np.stack([place, one], -1)[near]


def _still(p: Floats, names: Sequence[str], exact: float, moves: float) -> Bools:
    """(M) whether each keeps (3), or stands above one that does and begins its name."""
    low, high = np.nanmin(p, axis=1), np.nanmax(p, axis=1)
    fixed = high - low < exact
    travels = (high - low).max(1) > moves
    found = np.zeros(len(p), bool)
    if np.median(travels) < 1 or np.median(fixed.any(1)) > 0:
        return found
    flat = fixed.any(1) & travels
    found |= (fixed.sum(1) > 1) | flat
    for m in np.flatnonzero(flat).tolist():
        above = np.nanmax(np.abs(p - p[m])[:, :, ~fixed[m]], axis=(1, 2), initial=0.0) < exact
        found |= above & np.array([names[m].startswith(name) for name in names])
    return found
