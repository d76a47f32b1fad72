"""Paths and how they go on: the motion model by which every place of a trial is judged.

A path is continued from its nearest samples as in `connect`: x(t) = x₀ + v t + a t²/2 + w(t) + noise, v and a of known
variance, w of an acceleration that changes at random by q per √s,

    cov(w(s), w(t)) = q² (m⁵/20 + d m⁴/8 + d² m³/12),   m = min(s, t), d = |s − t|                         (1)

so that x₀ and its variance follow by generalised least squares; w of the past and of the future are independent. Two
ends are continued to the middle between them (2).

The trial itself says how noisy its samples are and how fast accelerations change. Each path's noise is that of its
third differences, robustly, 1.48 median |Δ³x| / √20 (3), motion being smooth over four frames. q is such that the ends
of pieces of HELD s that are taken out of the paths meet within what (2) states in half of all cases (4).

A path jumps from one frame to the next where the step is off the mean of the steps before and after it by more than
JUMP times what is usual there, its running median (5), which counts up to RESTLESS times that of the path.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ...data import Origin, Trajectories
from ...data.array_types import Bools, Floats, Ints
from ...numerics.evenly import evenly

NEAREST = 12
"""Samples that a path is continued from; chosen: farther ones tell nothing new."""
LOOK_S = 0.3
"""s of path that is continued; chosen, as in `connect`."""
SPEED, ACCELERATION = 1500.0, 15_000.0
"""mm/s and mm/s²: standard deviations of each component of v and a; chosen, as in tracking."""
USUAL_Q = 40_000.0
"""q where a trial is too short to tell it, mm/s² per √s; chosen, as in tracking."""
LEAST_Q, MOST_Q = 4_000.0, 400_000.0
"""What a trial may make of it; chosen: a tenth of what is usual, and ten times."""
LEAST_SD, MOST_SD = 0.05, 5.0
"""mm, noise of a sample per axis; chosen: below any system's, and above what a marker's size allows."""
ROUNDED = 1e-12
"""Share of a variance that is added to it; chosen: a minute after the last sample double precision loses the noise."""
HELD = 0.1
"""s; of (4). Chosen: as long as a gap that is judged by motion alone."""
TESTS = 400
"""Pieces that are taken out at most, over all paths; chosen."""
HALF = 2.366
"""Median of χ² with three degrees of freedom; by definition."""
SIGNIFICANT = 11.34
"""χ² of three degrees of freedom that 1 in 100 exceeds; by definition."""

UNTOLD_MM = 300.0
"""σ from which on a distance over a gap says nothing; chosen: a limb's length, any marker of which may be meant."""

JUMP, JUMP_MM = 6.0, 3.0
"""Times what is usual, and mm besides noise, of (5); chosen: noise alone reaches them once in thousands of samples."""
USUAL_STEPS, RESTLESS = 25, 5.0
"""Steps on each side that say what is usual, and times the median of the path that it may be; chosen: a path that jumps
all the time does not hide its jumps."""


class Paths(NamedTuple):
    """The paths of a trial.

    Attributes:
        xyz: (M, F, 3) mm, NaN where missing. seen: (M, F). frames: of each path, those with a sample.
        sd: (M) mm, noise of each axis. rate: Hz. q: of (1).
        images: (M, F) of each sample; 0 where they are not known.
        jumps: of each path, indices of the last samples before jumps (5): it is not continued over them.
    """

    xyz: Floats
    seen: Bools
    frames: tuple[Ints, ...]
    sd: Floats
    rate: float
    images: Ints
    q: float = USUAL_Q
    jumps: tuple[Ints, ...] = ()

    @classmethod
    def of(cls, trajectories: Trajectories) -> Paths:
        """Those of a trial; samples that were filled count as missing."""
        seen = np.array([(p.origin != Origin.MISSING) & (p.origin != Origin.FILLED) for p in trajectories])
        seen = seen.reshape(len(trajectories), trajectories.n_frames)
        xyz = np.where(seen[..., None], trajectories.xyz, np.nan)
        frames = tuple(np.flatnonzero(row) for row in seen)
        images = np.array([(p.detection >= 0).sum(1) for p in trajectories], np.int64).reshape(seen.shape)
        paths = cls(xyz, seen, frames, _noise(xyz), trajectories.rate, images)
        paths = paths._replace(jumps=tuple(_jumps(xyz[p, own], own, paths.sd[p]) for p, own in enumerate(frames)))
        return paths._replace(q=_process_noise(paths))

    def index_before(self, p: int, f: float) -> int:
        """Of path p the index of its last sample at or before frame f; −1 where there is none."""
        return int(np.searchsorted(self.frames[p], f, side="right")) - 1


class Ends(NamedTuple):
    """The NEAREST samples of N ends of paths, from the outermost inwards: frame (N, n), xyz (N, n, 3), variance (N, n),
    infinite where there is none."""

    frame: Floats
    xyz: Floats
    variance: Floats

    @property
    def outermost(self) -> Floats:
        """(N) frame."""
        return self.frame[:, 0]


def ends(paths: Paths, who: Ints, index: Ints, step: int) -> Ends:
    """The ends of paths `who` (N) at the samples of that index (N), looking back (step −1) or ahead (1).

    An end whose index is outside its path has no sample at all.
    """
    N = len(who)
    frame, xyz = np.zeros((N, NEAREST)), np.zeros((N, NEAREST, 3))
    variance = np.full((N, NEAREST), np.inf)
    for p in np.unique(who):
        rows, own = np.flatnonzero(who == p), paths.frames[p]
        at = index[rows, None] + step * np.arange(NEAREST)
        there = (at >= 0) & (at < len(own)) & (index[rows, None] >= 0)
        f = own[np.clip(at, 0, max(len(own) - 1, 0))] if len(own) else np.zeros_like(at)
        piece = np.searchsorted(paths.jumps[p], np.clip(at, 0, max(len(own) - 1, 0)))
        there &= (np.abs(f - f[:, :1]) <= LOOK_S * paths.rate) & (piece == piece[:, :1])
        frame[rows], xyz[rows] = f, np.where(there[..., None], paths.xyz[p, f], 0.0)
        variance[rows] = np.where(there, paths.sd[p] ** 2, np.inf)
    return Ends(frame, xyz, variance)


class _Lags(NamedTuple):
    """What continues N ends to frames, whatever q: which samples are known (N, n), and covariances (N, n, n) of them,
    mm², of w where q is 1, and of v and a."""

    end: Ends
    known: Bools
    walk: Floats
    steady: Floats


def _lags(end: Ends, to: Floats, rate: float) -> _Lags:
    known = np.isfinite(end.variance)
    t = np.where(known, (end.frame - to[:, None]) / rate, 0.0)
    s, u = t[:, :, None], t[:, None, :]
    m, d = np.where(s * u > 0, np.minimum(np.abs(s), np.abs(u)), 0.0), np.abs(s - u)
    walk = m**5 / 20 + d * m**4 / 8 + d**2 * m**3 / 12  # (1)
    return _Lags(end, known, walk, s * u * SPEED**2 + s**2 * u**2 / 4 * ACCELERATION**2)


def continued(end: Ends, to: Floats, rate: float, q: float) -> tuple[Floats, Floats]:
    """Where paths are at frames `to` (N): (N, 3) mm, and the variance of each axis (N) mm², infinite without any."""
    return _continued(_lags(end, to, rate), q)


def _continued(lags: _Lags, q: float) -> tuple[Floats, Floats]:
    end, known = lags.end, lags.known
    cov = q**2 * lags.walk + lags.steady
    both = known[:, :, None] & known[:, None, :]
    own = np.where(known, end.variance + ROUNDED * np.diagonal(cov, axis1=1, axis2=2), 1.0)
    cov = np.where(both, cov, 0.0) + np.eye(known.shape[1]) * own[:, None, :]
    weight = np.linalg.solve(cov, known[..., None].astype(np.float64))[..., 0]
    total = weight.sum(1)
    origin = end.xyz[np.arange(len(known)), known.argmax(1)][:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        place = origin[:, 0] + (weight[..., None] * (end.xyz - origin)).sum(1) / total[:, None]
        return place, np.where(known.any(1), 1 / np.maximum(total, 1e-12), np.inf)


def between(before: Ends, after: Ends, to: Floats, rate: float, q: float) -> tuple[Floats, Floats]:
    """Where paths are at frames `to` (N) by what is before and after them together; as `continued`."""
    both = (np.concatenate(columns, axis=1) for columns in zip(before, after, strict=True))
    return continued(Ends(*both), to, rate, q)


class Meeting(NamedTuple):
    """How two ends meet: distance (N) mm, its variance (N) per axis mm²; NaN and infinite where one has no sample."""

    off: Floats
    variance: Floats

    @property
    def squared(self) -> Floats:
        """(N) χ² of three degrees of freedom."""
        return self.off**2 / self.variance


def meeting(before: Ends, after: Ends, rate: float, q: float) -> Meeting:
    """How N ends before go on in N ends after (2)."""
    return _meeting(_middle(before, after, rate), q)


def _middle(before: Ends, after: Ends, rate: float) -> tuple[_Lags, _Lags]:
    """Both ends continued to the middle between them."""
    to = (before.outermost + after.outermost) / 2
    return _lags(before, to, rate), _lags(after, to, rate)


def _meeting(lags: tuple[_Lags, _Lags], q: float) -> Meeting:
    (a, u), (b, v) = (_continued(one, q) for one in lags)
    there = np.isfinite(u) & np.isfinite(v)
    return Meeting(np.where(there, np.linalg.norm(a - b, axis=1), np.nan), u + v)


def _noise(xyz: Floats) -> Floats:
    """(M) by (3)."""
    third = np.abs(np.diff(xyz, 3, axis=1))
    third = third.reshape(len(xyz), third[0].size if len(third) else 0)
    known = np.isfinite(third)
    usual = np.median(third[known]) if known.any() else 1.0
    sd = np.array([np.median(row[ok]) if ok.sum() > 30 else usual for row, ok in zip(third, known, strict=True)])
    return np.clip(1.48 * sd.reshape(len(xyz)) / np.sqrt(20), LEAST_SD, MOST_SD)


def _process_noise(paths: Paths) -> float:
    """q by (4), by bisection of its logarithm."""
    held = max(2, round(HELD * paths.rate))
    who, index = _tests(paths, held)
    if len(who) < 10:
        return USUAL_Q
    lags = _middle(ends(paths, who, index, -1), ends(paths, who, index + held, 1), paths.rate)
    low, high = np.log(LEAST_Q), np.log(MOST_Q)
    for _ in range(8):
        middle = (low + high) / 2
        fits = np.nanmedian(_meeting(lags, float(np.exp(middle))).squared) < HALF
        low, high = (low, middle) if fits else (middle, high)
    return float(np.exp(high))


def _tests(paths: Paths, held: int) -> tuple[Ints, Ints]:
    """Paths and indices of last samples before pieces without a gap that are taken out, evenly spread."""
    who, index = list[int](), list[int]()
    each = max(1, TESTS // max(len(paths.frames), 1))
    for p, own in enumerate(paths.frames):
        if len(own) > 3 * held:
            whole = np.flatnonzero(own[2 * held :] - own[: -2 * held] == 2 * held) + held // 2
            chosen = whole[evenly(len(whole), each)] if len(whole) else whole
            who += [p] * len(chosen)
            index += chosen.tolist()
    return np.array(who, np.int64), np.array(index, np.int64)


def sudden(paths: Paths, p: int) -> tuple[Ints, Ints]:
    """Indices of the samples of path p from which a step to the next frame differs from the step before, and from the
    step after it, by as much as (5) says; the path's first and last step do."""
    own = paths.frames[p]
    if len(own) < 3:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    before, after, most = _step_changes(paths.xyz[p, own], own, paths.sd[p])
    before[0] = after[-1] = np.inf
    step = np.diff(own) == 1
    return np.flatnonzero(step & (before > most)), np.flatnonzero(step & (after > most))


def _jumps(xyz: Floats, frame: Ints, sd: float) -> Ints:
    """Indices of last samples (N, 3) before jumps (5), from one frame to the next."""
    if len(xyz) < 3:
        return np.zeros(0, np.int64)
    before, after, most = _step_changes(xyz, frame, sd)
    return np.flatnonzero((np.diff(frame) == 1) & (np.minimum(before, after) > most))


def _step_changes(xyz: Floats, frame: Ints, sd: float) -> tuple[Floats, Floats, Floats]:
    """How much each step (N − 1) differs from that before and after it, 0 where there is none; and (5), mm a frame."""
    change = np.linalg.norm(np.diff(np.diff(xyz, axis=0) / np.diff(frame)[:, None], axis=0), axis=1)
    before, after = np.append(0.0, change), np.append(change, 0.0)
    off = np.minimum(before, after)
    usual = scipy.ndimage.median_filter(off, 2 * USUAL_STEPS + 1, mode="nearest")
    usual = np.minimum(usual, RESTLESS * np.median(off))
    return before, after, JUMP * (usual + sd) + JUMP_MM
