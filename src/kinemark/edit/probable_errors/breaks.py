"""Breaks: what happens to all paths of a file at once has one cause, and is one problem.

    lost      the system skipped frames: each path goes on where it would be some frames later
    repeated  it wrote a frame several times: no path moves, as nothing measured ever does
    moved     the world is another from a frame on, as after a new calibration: all paths jump as one rigid body
    shaken    the same for a few frames only, in which a calibration was off

Each path leads from its n last samples up to frame f, and back from its n first ones from frame g = f + s on, by a
parabola through them (1), to the middle between both. With k frames lost in between it is (s + k) / 2 frames away from
either. What the two are apart, r, is compared with what it usually is on the path, a running median u of χ² = H,

    cost = 7/2 ln(1 + χ²/4) + 3/2 ln(2π σ²),    χ² = r²/σ²,  σ² = u²/H,                                   (2)

as of `changes`. A cause speaks for itself by the cost of r as it is less the cost of what it leaves of r (3), a mean
over the paths: a loss leaves the r of k lost frames, a movement what the rigid motion leaves that best lays the ends
before on those after. A person's motion is neither: not all that they wear comes to be further on its own way at once,
nor elsewhere as if they were a statue.

Tracks that have images are not looked at: cameras that lose frames are another matter (`calibrate`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from ...geometry.align import rigid_align
from ...numerics.finite import finite_median
from ...numerics.runs import true_runs
from .paths import HALF, Paths
from .probability import probability
from .ways import LONGEST_S, SMEARED, UNUSUAL, WINDOW, Ways

BreakKind = Literal["lost", "repeated", "moved", "shaken"]

FEWEST = 4
"""Paths that must be seen on both sides; chosen: three of them fit any rigid motion."""
MOST = 20.0
"""Nats of (3) that a path speaks for a cause, or against it, at most; chosen: no path decides for all."""
APART = WINDOW + SMEARED
"""Frames between two breaks at least; chosen: nearer ones are in each other's samples."""
LEAST_GAIN = 0.1
"""Nats a path (3) from which on a cause is one; chosen: of what happened by nature hardly any comes to it."""
MOTION = 6
"""Numbers of a rigid motion, which cost ln(n) / 2 nats each for n coordinates (Schwarz 1978); by definition."""
ROUNDS, FAR = 6, 3.0
"""Of fitting a motion without the points that do not follow it, and times the median that these are off; chosen."""
SHAKEN = 2.0
"""Times that a path's nats count where the world comes back (`_worth`); chosen."""
BACK, BACK_S = 0.3, 1.0
"""Share of a movement that is left when it comes back, at most, and s within which it does as one problem; chosen."""
STILL_SHARE = 1e-3
"""Share of samples that repeat the one before by chance where none does; chosen: none of 300 samples tells no less."""


class BreakEvidence(NamedTuple):
    """What tells of a break.

    Attributes:
        gain: (3) a path, the mean; of repeated frames the nats by which so many paths would not rest by chance.
        share: of the paths, for which (3) is above 0. paths: ln of their number. left: mean of ln(1 + χ²/4) of what
            the cause leaves. mm: ln(1 + mm) by which the paths are off, the median: the ends of a filter shake all.
    """

    gain: float
    share: float
    paths: float
    left: float
    mm: float


class Rigid(NamedTuple):
    """x ↦ R x + t, mm."""

    R: Floats
    t: Floats

    def of(self, x: Floats) -> Floats:
        """(…, 3) mm of points (…, 3)."""
        return x @ self.R.T + self.t

    def back(self, x: Floats) -> Floats:
        """Points (…, 3) of which `of` makes these."""
        return (x - self.t) @ self.R

    def left(self, a: Floats, b: Floats) -> Floats:
        """(N) mm from where it lays points a to points b (N, 3)."""
        return np.asarray(np.linalg.norm(self.of(a) - b, axis=1))

    @property
    def degrees(self) -> float:
        """By how much it turns."""
        return float(np.degrees(np.arccos(np.clip((np.trace(self.R) - 1) / 2, -1, 1))))


class Break(NamedTuple):
    """All paths break between frames `before` and `after` (from 0), of which what is in between is wrong.

    Attributes:
        frames: lost in between, besides those that are there; negative where time stood still as well.
        motion: from the world before to that after; None where it is the same.
        mm: by which the paths are off, the median.
    """

    kind: BreakKind
    before: int
    after: int
    frames: int
    motion: Rigid | None
    mm: float
    evidence: BreakEvidence
    wrong: float


def breaks(paths: Paths) -> list[Break]:
    """Those of a trial, in the order of their frames; none of one that has images, or too few paths."""
    if paths.images.any() or len(paths.frames) < FEWEST or paths.xyz.shape[1] < 4 * WINDOW:
        return []
    stops = _stops(paths.xyz)
    ways = Ways(_without(paths.xyz, stops), paths.rate)
    found = [_stopped(ways, *stop) for stop in stops]
    asleep = {first for first, *_ in stops}
    found += [one for first, stop in _gaps(ways) if first not in asleep for one in _over_gap(ways, first, stop)]
    for one in sorted((*_lost(ways), *_moved(ways), *_shaken(ways)), key=_worth, reverse=True):
        if not any(k.before - APART < one.after and one.before < k.after + APART for k in found):
            found.append(one)
    return _there_and_back(sorted(found, key=lambda one: one.before), paths)


def _worth(one: Break) -> float:
    """The nats of (3), SHAKEN times as many where paths go on afterwards as before: where the world comes back, samples
    on both sides of one step look as if it moved and farther."""
    return one.evidence.gain * (SHAKEN if one.kind == "shaken" else 1.0)


# ---- Repeated frames ----


def _stops(xyz: Floats) -> list[tuple[int, int, float]]:
    """First frame and last-plus-one of runs in which all paths (M, F, 3) repeat their samples, and the nats by which a
    path would not by chance."""
    step = np.abs(np.diff(xyz, axis=1)).max(2)
    known, rests = np.isfinite(step), step == 0
    all_rest = (rests | ~known).all(0) & (known.sum(0) >= FEWEST)
    others = int((known & ~all_rest).sum())
    share = STILL_SHARE + (rests & ~all_rest).sum() / others if others else 1.0
    return [(a + 1, b + 1, float(-np.log(min(share, 1.0)))) for a, b in true_runs(all_rest).tolist()]


def _without(xyz: Floats, stops: Sequence[tuple[int, int, float]]) -> Floats:
    out = xyz.copy()
    for first, stop, _ in stops:
        out[:, first:stop] = np.nan
    return out


def _stopped(ways: Ways, first: int, stop: int, gain: float) -> Break:
    """Frames that repeat the one before, which is followed by what comes as many frames later, or at once."""
    frames, _ = _passed(ways, first, stop)
    paths = int(np.isfinite(ways.xyz[:, first - 1, 0]).sum())
    mm = finite_median(ways.off(np.array([first - 1]), stop - first + 1, 0), 0.0) if stop < ways.xyz.shape[1] else 0.0
    repeats = BreakEvidence(gain, 1.0, float(np.log(max(paths, 1))), 0.0, float(np.log1p(mm)))
    return Break("repeated", first - 1, stop, frames, None, mm, repeats, probability("repeated", repeats))


def _gaps(ways: Ways) -> Iterator[tuple[int, int]]:
    """First frame and last-plus-one of those in which no path is seen, between others."""
    n = ways.xyz.shape[1]
    seen = np.isfinite(ways.xyz[..., 0]).sum(0)
    for a, b in true_runs(seen == 0).tolist():
        if a > 0 and b < n and b - a <= LONGEST_S * ways.rate:
            yield a, b


def _over_gap(ways: Ways, first: int, stop: int) -> Iterator[Break]:
    """A gap in which more frames, or none, were lost than are missing."""
    frames, evidence = _passed(ways, first, stop)
    if frames and evidence is not None:
        mm = float(np.expm1(evidence.mm))
        yield Break("lost", first - 1, stop, frames, None, mm, evidence, probability("lost", evidence))


def _passed(ways: Ways, first: int, stop: int) -> tuple[int, BreakEvidence | None]:
    """How many frames more than those from `first` to `stop` passed in them, which tell nothing, and what tells so."""
    if stop >= ways.xyz.shape[1]:
        return 0, None
    f, n = np.array([first - 1]), stop - first
    if ways.strange(f, n + 1)[0] < UNUSUAL:
        return 0, None
    before = _costs(ways, f, n + 1, 0)
    best = min((-n, *ways.losses), key=lambda d: float(_sum(_costs(ways, f, n + 1, d))[0]))
    if _gain(before, _costs(ways, f, n + 1, best))[0] < LEAST_GAIN:
        return 0, None
    after, squared = _costs(ways, f, n + 1, best), ways.squared(f, n + 1, best)
    return best, _evidence(before[:, 0], after[:, 0], squared[:, 0], finite_median(ways.off(f, n + 1, 0), 0.0))


# ---- Lost frames ----


def _lost(ways: Ways) -> Iterator[Break]:
    """Of the frames that are unusual those at which a loss says more than that nothing happened."""
    for s in ways.spans:
        f = ways.broken(s)
        if not len(f):
            continue
        before = _costs(ways, f, s, 0)
        costs = np.array([_costs(ways, f, s, k) for k in ways.losses])
        likeliest = _sum(costs).argmin(0)
        gains = _gain(before, np.take_along_axis(costs, likeliest[None, None], axis=0)[0])
        for n in np.flatnonzero(gains > LEAST_GAIN).tolist():
            here = f[n : n + 1]
            k = _refined(ways, here, s, ways.losses[likeliest[n]])
            off, after = ways.off(here, s, 0)[:, 0], _costs(ways, here, s, k)[:, 0]
            mm = finite_median(off, 0.0)
            evidence = _evidence(before[:, n], after, ways.squared(here, s, k)[:, 0], mm)
            yield Break("lost", int(f[n]), int(f[n]) + s, k, None, mm, evidence, probability("lost", evidence))


def _refined(ways: Ways, f: Ints, s: int, coarse: int) -> int:
    """The number beside a coarse one that leaves least, whatever is usual of each: what is usual grows with the frames
    that are lost, and where some paths rest it would decide."""
    usual = ways.usual(s, coarse, f)
    some = range(max(1, coarse // 2), 2 * coarse + 2)
    return min(some, key=lambda k: float(_sum(_cost(ways.off(f, s, k), usual))[0]))


# ---- Another world ----


def _moved(ways: Ways) -> Iterator[Break]:
    """Of the frames that are unusual those at which a rigid motion leaves little."""
    for s in ways.spans:
        f = ways.broken(s)
        if len(f):
            a, b = ways.ends(f, s, 0)
            for n, frame in enumerate(f.tolist()):
                yield from _rigid(ways, "moved", frame, s, a[:, n], b[:, n])


def _shaken(ways: Ways) -> Iterator[Break]:
    """Where paths go on as they usually do, and are elsewhere as one body meanwhile."""
    for s in ways.longer_spans:
        f = ways.near_unusual(s)
        f = f[ways.strange(f, s) < UNUSUAL]
        a, b = ways.inside(f, s)
        for n, frame in enumerate(f.tolist()):
            yield from _rigid(ways, "shaken", frame, s, a[:, n], b[:, n])


def _rigid(ways: Ways, kind: Literal["moved", "shaken"], f: int, s: int, a: Floats, b: Floats) -> Iterator[Break]:
    """A movement of points a to b (M, 3) between frames f and f + s, where it says more than that nothing happened."""
    known = np.isfinite(a).all(1) & np.isfinite(b).all(1)
    usual = ways.usual_inside(s, f) if kind == "shaken" else ways.usual(s, 0, np.array([f]))[:, 0]
    off = np.full((2, len(a)), np.nan)
    off[0, known] = np.linalg.norm(b[known] - a[known], axis=1)
    if known.sum() < FEWEST or np.log1p((off[0] / usual)[known] ** 2 * HALF / 4).mean() < UNUSUAL:
        return
    motion = _fitted(a[known], b[known])
    n = int(known.sum())
    off[1, known] = motion.left(a[known], b[known]) * np.sqrt(3 * n / (3 * n - MOTION))
    before, after = _cost(off[0], usual), _cost(off[1], usual) + MOTION * np.log(3 * n) / (2 * n)
    if _gain(before, after) > LEAST_GAIN:
        mm = finite_median(off[0], 0.0)
        evidence = _evidence(before, after, off[1] ** 2 * HALF / usual**2, mm)
        yield Break(kind, f, f + s, 0, motion, mm, evidence, probability("moved", evidence))


def _fitted(a: Floats, b: Floats) -> Rigid:
    """The motion of most points a to b (N, 3), those that do not follow it left out."""
    keep = np.ones(len(a), np.bool_)
    for _ in range(ROUNDS):
        motion = Rigid(*rigid_align(a[keep], b[keep]))
        left = motion.left(a, b)
        near = left <= np.partition(left, FEWEST - 1)[FEWEST - 1] + FAR * np.median(left)
        if (near == keep).all():
            break
        keep = near
    return motion


def _there_and_back(found: list[Break], paths: Paths) -> list[Break]:
    """Movements that come back soon as one."""
    out = list[Break]()
    for one in found:
        last = out[-1] if out else None
        if last and last.kind == one.kind == "moved" and one.before - last.after <= BACK_S * paths.rate:
            x = paths.xyz[paths.seen[:, last.before], last.before]
            assert last.motion is not None and one.motion is not None
            there = last.motion.of(x)
            if np.median(one.motion.left(there, x)) < BACK * np.median(last.motion.left(x, x)):
                wrong = min(last.wrong, one.wrong)
                out[-1] = last._replace(kind="shaken", after=one.after, wrong=wrong)
                continue
        out.append(one)
    return out


# ---- Evidence ----


def _cost(off: Floats, usual: Floats) -> Floats:
    """(2)."""
    variance = usual**2 / HALF
    return np.asarray(3.5 * np.log1p(off**2 / variance / 4) + 1.5 * np.log(2 * np.pi * variance))


def _costs(ways: Ways, f: Ints, s: int, lost: int) -> Floats:
    """(M, N) of the ends at frames f (N) and f + s, so many being lost."""
    return _cost(ways.off(f, s, lost), ways.usual(s, lost, f))


def _sum(costs: Floats) -> Floats:
    """(…, N) of costs (…, M, N) that are known."""
    return np.asarray(np.where(np.isfinite(costs), costs, 0.0).sum(-2))


def _gain(before: Floats, after: Floats) -> Floats:
    """(3) a path, the mean of those (M, …) that are known by both costs; −∞ where they are too few."""
    by = np.clip(before - after, -MOST, MOST)
    known = np.isfinite(by)
    n = known.sum(0)
    return np.where(n >= FEWEST, np.where(known, by, 0.0).sum(0) / np.maximum(n, 1), -np.inf)


def _evidence(before: Floats, after: Floats, squared: Floats, mm: float) -> BreakEvidence:
    """Of costs (M) before and after, what χ² is left, and by how much the paths are off."""
    by = before - after
    known = np.isfinite(by)
    return BreakEvidence(
        float(_gain(before, after)),
        float((by[known] > 0).mean()),
        float(np.log(known.sum())),
        float(np.log1p(squared[known] / 4).mean()),
        float(np.log1p(mm)),
    )
