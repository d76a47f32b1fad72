"""Whether two pieces of path are one marker: what is looked at before one name is claimed for both (KISS 4.3).

    overlap    in frames that both have, they must be at one place: their distance against its standard deviation, by
               the covariances of both (1)
    gap        else each is continued to the middle of the gap, and both must come to one place there (2)

A path is continued by the motion model of tracking: with t the time from the place that is asked for, a sample is
x(t) = x₀ + v t + a t²/2 + w(t) + noise, with v and a of known variance, and w of an acceleration that changes at random
by q per √s,

    cov(w(s), w(t)) = q² (m⁵/20 + d m⁴/8 + d² m³/12),   m = min(s, t), d = |s − t|                       (3)

so that x₀ and its variance follow by generalised least squares. They are connectable where the median of √3
distance over standard deviation, of all axes together, is at most SURE. In millimetres the distance is stated too, for
whoever decides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..data import MarkerTrajectory, Origin
from ..data.array_types import Floats, Ints

SURE = 3.0
"""Standard deviations; chosen: of places in three axes 1 in 30 is farther by chance."""
LOOK_S = 0.3
"""s of path that is continued; chosen: more tells nothing new of how it goes on."""
PROCESS_NOISE = 40_000.0
"""q, mm/s² per √s; chosen, as in tracking."""
SPEED, ACCELERATION = 1500.0, 15_000.0
"""mm/s and mm/s²: standard deviations of each component of v and a; chosen, as in tracking."""
ROUNDED = 1e-12
"""Share of a variance that is added to it; chosen: a minute after the last sample double precision loses the noise."""
USUAL_MM = 1.0
"""mm, standard deviation of a sample that states none, per axis; chosen."""
LEAST_MM = 1.0
"""mm, standard deviation below which two paths are not told apart, per axis; chosen: centroids of one marker differ by
as much where cameras differ."""


class Connection(NamedTuple):
    """How well two pieces go together.

    Attributes:
        overlap: frames that both have. gap: frames from the end of one to the start of the other; 0 where they overlap.
        off_mm: how far apart they are, where both are, or where one is continued to the other. sd_mm: its standard
            deviation; deviations: median of distance over that, of all three axes together.
        connectable: whether they may be one marker.
    """

    overlap: int
    gap: int
    off_mm: float
    sd_mm: float
    deviations: float
    connectable: bool


def connection(one: MarkerTrajectory, other: MarkerTrajectory, *, rate: float) -> Connection:
    """How well two pieces of path go together.

    Args:
        one, other: of one trial. rate: Hz.

    Raises:
        ValueError: one has no sample.
    """
    a, b = (np.flatnonzero(path.origin != Origin.MISSING) for path in (one, other))
    if not len(a) or not len(b):
        raise ValueError(f"{(one if not len(a) else other).name} has no sample")
    both = np.intersect1d(a, b)
    if len(both):
        off = np.linalg.norm(one.xyz[both] - other.xyz[both], axis=1)
        sd = np.sqrt(_variance(one, both) + _variance(other, both))  # (1)
        return _judged(len(both), 0, off, sd)
    near = np.searchsorted(a, b[0])
    if 0 < near < len(a):  # b lies in a gap of a, or reaches over several: look at the nearest ends
        return _judged(0, *_over_gaps(one, other, a, b, rate))
    first, last, x, y = (one, other, a, b) if a[-1] < b[0] else (other, one, b, a)
    distance, deviation = _across(first, last, x, y, rate)
    return _judged(0, int(y[0] - x[-1] - 1), np.array([distance]), np.array([deviation]))


def _over_gaps(
    one: MarkerTrajectory, other: MarkerTrajectory, a: Ints, b: Ints, rate: float
) -> tuple[int, Floats, Floats]:
    """The shortest gap, and distances and standard deviations over every change from one path to the other."""
    frames = np.concatenate([a, b])
    whose = np.repeat([0, 1], [len(a), len(b)])
    order = np.argsort(frames)
    frames, whose = frames[order], whose[order]
    found = []
    for k in np.flatnonzero(whose[1:] != whose[:-1]).tolist():
        before, after = (one, other) if whose[k] == 0 else (other, one)
        x, y = (a, b) if whose[k] == 0 else (b, a)
        apart = int(frames[k + 1] - frames[k] - 1)
        found.append((apart, *_across(before, after, x[x <= frames[k]], y[y >= frames[k + 1]], rate)))
    gap, off, sd = zip(*found, strict=True)
    return min(gap), np.array(off), np.array(sd)


def _across(before: MarkerTrajectory, after: MarkerTrajectory, x: Ints, y: Ints, rate: float) -> tuple[float, float]:
    """Distance, mm, and its standard deviation, of both paths continued to the middle of a gap (2)."""
    middle = (x[-1] + y[0]) / 2
    p, u = _continued(before, x[::-1], middle, rate)
    q, v = _continued(after, y, middle, rate)
    return float(np.linalg.norm(p - q)), float(np.sqrt(u + v))


def _continued(path: MarkerTrajectory, frames: Ints, to: float, rate: float) -> tuple[Floats, float]:
    """Where a path is at `to`, (3) mm, and its variance, all axes together, mm²; of its frames, the nearest first."""
    near = frames[np.abs(frames - frames[0]) <= LOOK_S * rate]
    t = np.abs(near - to) / rate
    m, d = np.minimum(t, t[:, None]), np.abs(t - t[:, None])
    cov = PROCESS_NOISE**2 * (m**5 / 20 + d * m**4 / 8 + d**2 * m**3 / 12)  # (3)
    cov += np.outer(t, t) * SPEED**2 + np.outer(t**2, t**2) / 4 * ACCELERATION**2
    cov += np.diag(_variance(path, near) / 3 + ROUNDED * np.diagonal(cov))
    weight = np.linalg.solve(cov, np.ones(len(t)))
    origin = path.xyz[near[0]]
    place = origin + weight @ (path.xyz[near] - origin) / weight.sum()
    return place, float(3 / weight.sum())


def _variance(path: MarkerTrajectory, frames: Ints) -> Floats:
    """Of samples, all axes together, mm²."""
    own = np.trace(path.cov[frames], axis1=1, axis2=2)
    return np.maximum(np.where(np.isfinite(own), own, 3 * USUAL_MM**2), 3 * LEAST_MM**2)


def _judged(overlap: int, gap: int, off: Floats, sd: Floats) -> Connection:
    """By the median; a distance of three axes is √3 times that of one."""
    deviations = float(np.median(off / sd * np.sqrt(3)))
    return Connection(overlap, gap, float(np.median(off)), float(np.median(sd)), deviations, deviations <= SURE)
