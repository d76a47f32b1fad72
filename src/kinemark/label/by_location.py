"""Identity by where a marker is: height, side and front (Swamidas 1997, 2.5 (10)).

"Superior markers on a subject will always have a greater Z coordinate than inferior markers. Left sided markers will
always have greater Y values. Anterior segment markers will have greater X values, although this may not be true for
markers on the lower extremities as one foot passes the other" (Olree, in the appendix). Front is here the way that the
subject goes, so that the laboratory's axes do not matter but for the vertical, and a subject that stays in place has
height alone. With c(t) the median of all markers that are seen, H the height over which they spread, f the level
direction of the way and l = up × f, the location of a marker is

    q(t) = ( z, l · (x − c), f · (x − c) ) / H                                                           (1)

A labelled trial gives mean m and variance v of each marker's q; a track whose mean is p costs

    cost = Σ (p − m)² / (v + s²),     s = `SPREAD`                                                       (2)

for each marker: v because a piece sees a part of the stride, s because no trial is like another. Tracks take names, the
cheapest pair first, one at a time of each name. A name is sure where all others that the track could have cost `MARGIN`
more. Distances (`distances`) tell far more; this asks nothing of them, and works where few markers are seen together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import KinemarkError, Trajectories
from ..data.array_types import Bools, Floats

SPREAD = 0.02
"""s, as a share of the height; chosen: 3.5 cm of an adult."""
WAY = 0.25
"""Of the height, that a subject must go for its way to be its front; chosen."""
TAIL = 0.1
"""Share of the samples above, and below, the height H; chosen: so many may be ghosts."""
MARGIN = 9.0
"""Of (2), chosen: three standard deviations."""
FARTHEST = 30.0
"""Of (2), above which a track is no marker; chosen."""


class Located(NamedTuple):
    """Names of tracks by location: name, None where none; sure: whether no other name is near."""

    name: str | None
    sure: bool


class _Places(NamedTuple):
    """Mean (N, k) and variance (N, k) of (1); k is 3, or 1 where there is no way."""

    mean: Floats
    variance: Floats


def label_by_location(trajectories: Trajectories, shown: Trajectories, *, up: str = "z") -> tuple[Located, ...]:
    """A name for each track, by where it is on the body.

    Args:
        trajectories: of a trial; the names that they have are not looked at.
        shown: a labelled trial of the same marker set.
        up: the axis that points upwards: x, y or z.

    Raises:
        KinemarkError: one of them has no samples.
        ValueError: there is no such axis.
    """
    if up not in ("x", "y", "z"):
        raise ValueError(f"up is {up!r}, wanted x, y or z")
    here, there = (_places(one, "xyz".index(up)) for one in (trajectories, shown))
    k = min(here.mean.shape[1], there.mean.shape[1])
    off = (here.mean[:, None, :k] - there.mean[:, :k]) ** 2
    cost = np.nan_to_num((off / (there.variance[:, :k] + SPREAD**2)).sum(-1), nan=np.inf)  # (2)
    return _named(cost, np.isfinite(trajectories.xyz[..., 0]), shown.names)


def _places(trial: Trajectories, up: int) -> _Places:
    """(1) of all markers."""
    xyz = trial.xyz
    if not np.isfinite(xyz).any():
        raise KinemarkError("There are no samples to tell a marker's location by. Track the recording first.")
    level = [(up + 1) % 3, (up + 2) % 3]  # so that up × the first is the second
    seen: Bools = np.isfinite(xyz[..., 0])
    known = np.flatnonzero(seen.any(0))
    low, high = np.nanpercentile(xyz[..., up], (100 * TAIL, 100 - 100 * TAIL))
    H = float(high - low)
    q = [(xyz[..., up] - low) / H]  # wherever the floor is
    way = np.nanmean(xyz[:, known[-1]][:, level], axis=0) - np.nanmean(xyz[:, known[0]][:, level], axis=0)
    if np.hypot(*way) >= WAY * H:
        front = way / np.hypot(*way)
        for axis in (np.array([-front[1], front[0]]), front):
            along = xyz[..., level] @ axis
            centre = np.full(xyz.shape[1], np.nan)
            centre[known] = np.nanmedian(along[:, known], axis=0)
            q.append((along - centre) / H)
    location = np.stack(q, -1)
    n = np.maximum(seen.sum(1), 1)[:, None]
    mean = np.where(seen.any(axis=1, keepdims=True), np.nansum(location, axis=1) / n, np.nan)
    return _Places(mean, np.nansum((location - mean[:, None]) ** 2, axis=1) / n)


def _named(cost: Floats, seen: Bools, names: tuple[str, ...]) -> tuple[Located, ...]:
    """The cheapest pair first; a name serves one track a frame."""
    taken = np.zeros((len(names), seen.shape[1]), bool)
    found = [Located(None, False)] * len(cost)
    order = np.dstack(np.unravel_index(np.argsort(cost, axis=None), cost.shape))[0]
    done = np.zeros(len(cost), bool)
    for track, name in order.tolist():
        if cost[track, name] > FARTHEST:
            break
        if not done[track] and not (taken[name] & seen[track]).any():
            others = np.delete(cost[track], name)
            sure = bool(others.min(initial=np.inf) - cost[track, name] >= MARGIN)
            found[track], done[track] = Located(names[name], sure), True
            taken[name] |= seen[track]
    return tuple(found)
