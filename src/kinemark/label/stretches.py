"""Tracks as the labelling sees them: which are there in which of some frames, and which may go on as which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data import Trajectories
from ..data.array_types import Bools, Floats, Ints

GRID_HZ = 15.0
"""Frames a second that are looked at; chosen: distances change little in 0.07 s."""
LINK_S = 0.25
"""Longest gap over which one track may say that another goes on with it, s; chosen."""
SPEED_S = 0.05
"""Over which the speed at a track's end is taken, s; chosen."""
NOISE_SHARE = 0.002
"""Of a marker's place, as a share of the body's size; chosen: 3 mm of 1.6 m."""
ACCELERATION = 12.0
"""Standard deviation of a marker's acceleration in sizes of the body a second squared; chosen: 20 m/s² of 1.6 m."""
PART = 256
"""Frames of a part of the trial in `together`; chosen."""
FREE, NO_MARKER = -1, -2
"""Of which nothing was stated, and of which it was that it is none of the template's markers; by definition."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretches:
    """T tracks at K of F frames.

    Attributes:
        xyz: (T, K, 3) mm, about one of the points; NaN where not seen.
        frame: (K) the frames.
        seen: (T, F) where there are samples.
        start, stop: (T) first and last-plus-one frame.
        weight: (T) how many independent frames a track is worth.
        link: (T, T) nats that the column goes on where the row ends; 0 where nothing is said. into: turned round.
        fixed: (T) the label that was stated of each track; FREE, or NO_MARKER.
    """

    xyz: NDArray[np.float32]
    frame: Ints
    seen: Bools
    start: Ints
    stop: Ints
    weight: Floats
    link: scipy.sparse.csr_array
    into: scipy.sparse.csr_array
    fixed: Ints

    def __len__(self) -> int:
        return len(self.xyz)


def stretches_of(trajectories: Trajectories, size: float, fixed: Ints | None = None) -> Stretches:
    """The tracks of a trial; `size` of the body, mm. Tracks without samples have start and stop 0."""
    xyz, rate = trajectories.xyz, trajectories.rate
    seen = np.isfinite(xyz[..., 0])
    some = seen.any(1)
    origin = xyz[seen][0] if some.any() else np.zeros(3)
    start = np.where(some, seen.argmax(1), 0)
    stop = np.where(some, seen.shape[1] - seen[:, ::-1].argmax(1), 0)
    frame = _frames(seen, start, stop, rate)
    near = (xyz[:, frame] - origin).astype(np.float32)
    weight = 1.0 + seen.sum(1) / rate / 0.5  # a new pose each half second
    link = _links(xyz, seen, start, stop, rate, size)
    fixed = np.full(len(xyz), FREE) if fixed is None else fixed
    return Stretches(near, frame, seen, start, stop, weight, link, link.T.tocsr(), fixed)


def together(seen: Bools) -> Bools:
    """(T, T) which of T tracks (T, F) are seen in one frame or more with each other, none with itself.

    Part by part of the trial: of many pieces few are seen in each.
    """
    found = np.zeros((len(seen), len(seen)), bool)
    for first in range(0, seen.shape[1], PART):
        part = seen[:, first : first + PART]
        own = np.flatnonzero(part.any(1))
        here = part[own].astype(np.float32)
        found[np.ix_(own, own)] |= here @ here.T > 0
    np.fill_diagonal(found, False)
    return found


def _frames(seen: Bools, start: Ints, stop: Ints, rate: float) -> Ints:
    """Those of a grid, and one of each track that has none there."""
    step = max(1, round(rate / GRID_HZ))
    grid = np.arange(step // 2, seen.shape[1], step) if seen.shape[1] > step else np.arange(min(seen.shape[1], 1))
    missed = np.flatnonzero(~seen[:, grid].any(1) & (stop > start))
    middles = [(lambda own: own[len(own) // 2])(np.flatnonzero(seen[t])) for t in missed]
    return np.unique([*grid.tolist(), *middles]).astype(np.int64)


def _links(xyz: Floats, seen: Bools, start: Ints, stop: Ints, rate: float, size: float) -> scipy.sparse.csr_array:
    """For ends and beginnings that are near in time: log density of the step over that of any place in the volume."""
    T = len(xyz)
    some = np.flatnonzero(stop > start)
    order = some[np.argsort(start[some], kind="stable")]
    begins = start[order]
    lo, hi = np.searchsorted(begins, stop[some]), np.searchsorted(begins, stop[some] + round(LINK_S * rate) + 1)
    row = np.repeat(some, hi - lo)
    if not len(row):
        return scipy.sparse.csr_array((T, T))
    column = np.concatenate([order[a:b] for a, b in zip(lo, hi, strict=True)])
    width = max(1, round(SPEED_S * rate))
    last, first = stop - 1, start
    out, into = np.full((2, T, 3), np.nan)
    out[some] = [speed_at(xyz[t], seen[t], last[t], -width) for t in some]
    into[some] = [speed_at(xyz[t], seen[t], first[t], width) for t in some]
    frames = (first[column] - last[row]).astype(float)
    speed = speed_between(out[row], into[column])
    step = xyz[column, first[column]] - xyz[row, last[row]] - speed * frames[:, None]
    nats = link_nats(step, frames, rate, size)
    return scipy.sparse.csr_array((np.maximum(nats, -4.0), (row, column)), shape=(T, T))


def link_nats(step: Floats, frames: Floats | Ints, rate: float, size: float) -> Floats:
    """(n) log density of a track going on by steps (n, 3) beyond its speed in (n) frames over that of any place."""
    width = max(1, round(SPEED_S * rate))
    dt = frames / rate
    sigma = size * np.hypot(NOISE_SHARE, ACCELERATION * 0.25 * dt * dt + NOISE_SHARE * frames / width)
    volume = (0.5 * size) ** 3
    nats = np.log(volume / (sigma * np.sqrt(2 * np.pi)) ** 3) - 0.5 * (step**2).sum(-1) / sigma**2
    return np.asarray(nats)


def speed_at(xyz: Floats, seen: Bools, at: int, width: int) -> Floats:
    """mm a frame at a track's end, of what is seen within `width` frames of it; NaN where that is one sample."""
    other = min(max(at + width, 0), len(xyz) - 1)
    frames = np.arange(min(at, other), max(at, other) + 1)
    own = frames[seen[frames]]
    return (xyz[own[-1]] - xyz[own[0]]) / (own[-1] - own[0]) if len(own) > 1 else np.full(3, np.nan)


def speed_between(out: Floats, into: Floats) -> Floats:
    """(n, 3) mm a frame from where tracks end to where others begin: the mean of both ends, or the one that is known.

    A single sample has no speed, rather than none that moves; where neither end has one it is 0.
    """
    known = np.isfinite(out).astype(int) + np.isfinite(into)
    return np.asarray((np.nan_to_num(out) + np.nan_to_num(into)) / np.maximum(known, 1))
