"""Labelled trials that contradict themselves: two markers carry each other's names for a while, told by no template.

The distance of markers a and k has the standard deviation s_ak over the frames of one subject's trials, and s'_ak where
a and b have each other's names in a part of them. Where they are exchanged there, distances vary less once the names
are put right; where names are right, those that tell anything vary more. With ε what a marker on skin moves,

    u_ak = ½ log (s_ak² + ε²),   g_a = 1/K Σ_k [ u_ak − u'_ak ],   g = min (g_a, g_b)                             (1)

over the K markers k of the least min (u_ak, u'_ak) of those that tell, |u_ak − u'_ak| > 0.05: both ways round choose
the same ones. So a posture that is new speaks for no exchange. The part is sought among windows, and then to a frame.
Which of the two ways round is right is not told: of the two parts the shorter one counts as exchanged.

Markers that drift on the skin, or a tool's that is symmetric, make distances steadier by chance. But names of markers
that are seen do not drift: where the part begins and ends within a trial, they change at once (`turned_names`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Bools, Floats, Ints
from ..numerics.evenly import evenly_rounded
from ..numerics.vectors import lengths
from .check import Exchanged
from .turned_names import names_turn

LEAST = 0.1
"""g from which on an exchange is said; chosen: in none of 53 files of twelve laboratories and programs g is above
−0.01, but for the one that has an exchange, 1.76."""
LEAST_NATS, POSE_S = 10.0, 0.5
"""And nats of all the distances of (1), of one frame a pose, from which on it is said, and how long a pose takes, s;
chosen, as of hidden exchanges: of 488 windows of 0.3 to 4 s of these files, half of them with many gaps, 14 had g above
0.1, mostly in less than a second."""
NEARLY = -0.3
"""g among windows from which on a part is sought to a frame; chosen: a window that is half exchanged hides as much."""
REFINED = 20
"""Pairs of markers of which it is sought, those of the greatest g; chosen: the right one was among the first two."""
STEADIEST = 4
"""K of (1); chosen: as many as a segment has."""
TELLS = 0.05
"""Of (1); chosen: markers on the plane of symmetry of two tell nothing of them."""
FLOOR = 0.001
"""ε of (1), as a share of the body's size; chosen: one and a half millimetres."""
MATES = 24
"""Nearest markers to either that count for (1); chosen: the steadiest are near, and of 180 points all take 10 s."""
NEAR = 8
"""Nearest markers with which one may be exchanged; chosen, as in `exchange`."""
FRAMES = 300
"""Frames of all trials that are looked at; chosen, as many as a template does."""
WINDOW_S, WINDOWS = 0.2, 32
"""Length of windows, s, and the most; chosen: of 0.5 s, 84 of 102 exchanges were found, and 97 of 0.2 s."""
SLACK = 15
"""Frames by which the ends of a part may be off; chosen: mostly they are by two at most, but by more beside gaps."""
FEWEST = 3
"""Samples of a part, and of the rest; chosen: two tell no spread."""
MOST = 10
"""Exchanges that are looked for; chosen: where there are more, most names are wrong."""


class _Looked(NamedTuple):
    """Places (F, L, 3) mm in frames (F) of trials (F); all places of each trial, and its rate, Hz."""

    y: Floats
    trial: Ints
    frame: Ints
    every: tuple[Floats, ...]
    rates: tuple[float, ...]

    def exchange(self, two: tuple[int, int], own: Bools) -> list[tuple[int, int, int]]:
        """Of two markers in frames (F); gives the stretches: trial, first and last-plus-one frame."""
        stretches = list(_stretches(self, own))
        here, both = np.flatnonzero(own)[:, None], np.array(two)
        self.y[here, both] = self.y[here, both[::-1]]
        for k, first, stop in stretches:
            self.every[k][first:stop, two] = self.every[k][first:stop, two[::-1]]
        return stretches


class _Two(NamedTuple):
    """Two markers, their distances (F, 2, K) mm to those that are near either, and ε², mm²."""

    markers: tuple[int, int]
    distance: Floats
    floor: float

    @classmethod
    def of(cls, y: Floats, markers: tuple[int, int], mean: Floats, floor: float) -> _Two:
        """Of places (F, L, 3) mm, whose mean distances are (L, L)."""
        near = mean[list(markers)].min(0)
        near[list(markers)] = np.inf
        mates = np.argsort(near, kind="stable")[: min(MATES, len(near) - 2)]
        return cls(markers, lengths(y[:, markers, None] - y[:, None, mates]), floor)


def find_own_exchanges(*trials: Trajectories) -> tuple[tuple[Exchanged, ...], ...]:
    """Of each of one subject's trials the stretches in which two near markers carry each other's names.

    `Exchanged.gain` is by how much likelier the distances of (1) are, as normal ones, a frame of the stretch.
    """
    names = sorted({name for trial in trials for name in trial.names})
    found: list[list[Exchanged]] = [[] for _ in trials]
    if len(names) < STEADIEST + 2:
        return tuple(map(tuple, found))
    looked = _looked_at(trials, names)
    seconds = sum(one.n_frames / one.rate for one in trials)
    for _ in range(MOST):
        best = _best(looked, seconds)
        if best is None:
            break
        (a, b), own, gain = best
        nats = 2 * STEADIEST * gain * len(own) / own.sum()
        for k, first, stop in looked.exchange((a, b), own):
            found[k].append(Exchanged((names[a], names[b]), first, stop, float(nats)))
    return tuple(tuple(sorted(each, key=lambda one: (one.first, one.markers))) for each in found)


def without_exchanged(trial: Trajectories, exchanged: Sequence[Exchanged]) -> Trajectories:
    """The trial without the samples whose names are found to be exchanged."""
    kept = {name: np.ones(trial.n_frames, bool) for one in exchanged for name in one.markers}
    for one in exchanged:
        for name in one.markers:
            kept[name][one.first : one.stop] = False
    return replace(trial, paths=tuple(p.only(kept[p.name]) if p.name in kept else p for p in trial))


def _looked_at(trials: Sequence[Trajectories], names: Sequence[str]) -> _Looked:
    """Frames of all trials, evenly spread."""
    n = np.array([one.n_frames for one in trials])
    every = evenly_rounded(int(n.sum()), FRAMES)
    trial = np.searchsorted(np.cumsum(n), every, side="right")
    frame = every - (np.cumsum(n) - n)[trial]
    full = [np.full((one.n_frames, len(names), 3), np.nan) for one in trials]
    for xyz, one in zip(full, trials, strict=True):
        for path in one:
            xyz[:, names.index(path.name)] = path.xyz
    y = np.concatenate([xyz[frame[trial == k]] for k, xyz in enumerate(full)])
    return _Looked(y, trial, frame, tuple(full), tuple(one.rate for one in trials))


def _best(looked: _Looked, seconds: float) -> tuple[tuple[int, int], Bools, float] | None:
    """The two whose exchange makes distances steadiest, in which frames (F), and g; None where none makes enough."""
    y = looked.y
    mean = _mean_distances(y)
    floor = (FLOOR * float(mean[np.isfinite(mean)].max(initial=0.0))) ** 2
    spans = _windows(len(y), seconds)
    pairs = _near(mean)
    gains = [_gains(_Two.of(y, markers, mean, floor), spans) for markers in pairs]
    best, most = None, LEAST
    for k in sorted(range(len(pairs)), key=lambda k: -gains[k].max())[:REFINED]:
        if gains[k].max() > NEARLY:
            span, gain = _to_a_frame(_Two.of(y, pairs[k], mean, floor), spans[gains[k].argmax()])
            poses = seconds / POSE_S * np.isfinite(y[:, pairs[k], 0]).any(1).mean()
            told = gain > most and 2 * STEADIEST * gain * poses > LEAST_NATS
            if told and _turn(looked, pairs[k], span):
                best, most = (pairs[k], span), gain
    if best is None:
        return None
    own = np.zeros(len(y), bool)
    own[slice(*best[1])] = True
    there = np.isfinite(y[:, best[0], 0]).any(1)
    return best[0], own if 2 * (own & there).sum() <= there.sum() else ~own, most


def _windows(n: int, seconds: float) -> Ints:
    """(S, 2) spans of n frames, each of one window or more."""
    windows = min(WINDOWS, max(2, int(seconds / WINDOW_S)))
    edges = np.linspace(0, n, windows + 1).round().astype(np.int64).tolist()
    return np.array([(i, j) for i in edges[1:-1] for j in edges[1:] if i < j])


def _mean_distances(y: Floats) -> Floats:
    """(L, L) mm, ∞ of two that are never seen together; frame by frame, as all at once are many."""
    total, n = np.zeros((2, y.shape[1], y.shape[1]))
    for xyz in y:
        d = lengths(xyz[:, None] - xyz[None])
        total += np.nan_to_num(d)
        n += np.isfinite(d)
    return np.where(n > 0, total / np.maximum(n, 1), np.inf)


def _near(mean: Floats) -> list[tuple[int, int]]:
    """Pairs of near markers, by their mean distances (L, L), ∞ where two are never seen together."""
    d = np.where(np.eye(len(mean), dtype=bool), np.inf, mean)
    near = np.argsort(d, axis=1, kind="stable")[:, :NEAR].tolist()
    return sorted({(min(a, b), max(a, b)) for a, row in enumerate(near) for b in row if d[a, b] < np.inf})


def _gains(two: _Two, spans: Ints) -> Floats:
    """(S) g of exchanges in spans (S, 2) of frames; −∞ where too few distances tell."""
    seen = np.isfinite(two.distance)
    d = np.where(seen, two.distance, 0.0)
    sums = np.stack([seen, d, d * d], axis=1, dtype=np.float64).cumsum(0)  # n, Σ d, Σ d²
    sums = np.concatenate([np.zeros_like(sums[:1]), sums])  # (F + 1, 3, 2, L)
    inside = sums[spans[:, 1]] - sums[spans[:, 0]]
    outside = sums[-1] - inside
    told = (np.minimum(inside[:, 0], outside[:, 0]) >= FEWEST).all(1)  # (S, L)
    own, other = (_spreads(outside + part, two.floor) for part in (inside, inside[:, :, ::-1]))
    tells = told[:, None] & (np.abs(own - other) > TELLS)
    rank = np.where(tells, np.minimum(own, other), np.inf)
    kth = np.partition(rank, STEADIEST - 1, axis=2)[..., [STEADIEST - 1]]
    gain = np.where(tells & (rank <= kth), own - other, 0.0).sum(2).min(1) / STEADIEST  # (1)
    return np.where(np.isfinite(kth).all((1, 2)), gain, -np.inf)


def _spreads(sums: Floats, floor: float) -> Floats:
    """(S, 2, L) u of (1), of n, Σ d and Σ d² (S, 3, 2, L)."""
    n = np.maximum(sums[:, 0], 1)
    return np.asarray(np.log(np.maximum(sums[:, 2] / n - (sums[:, 1] / n) ** 2, 0.0) + floor) / 2)


def _to_a_frame(two: _Two, span: Ints) -> tuple[tuple[int, int], float]:
    """The span that makes most, the one end after the other, and its g."""
    first, stop = span.tolist()
    gain = -np.inf
    for _ in range(2):
        ends = np.arange(first + 1, len(two.distance) + 1)
        stop = int(ends[_gains(two, np.stack([np.full_like(ends, first), ends], axis=1)).argmax()])
        starts = np.arange(stop)
        gains = _gains(two, np.stack([starts, np.full_like(starts, stop)], axis=1))
        first, gain = int(gains.argmax()), float(gains.max())
    return (first, stop), gain


def _turn(looked: _Looked, two: tuple[int, int], span: tuple[int, int]) -> bool:
    """Whether names turn where a span of frames begins and ends, but for the ends of trials; a whole trial's need not.

    In a trial alone they turn at least once.
    """
    edges = np.r_[0, np.flatnonzero(np.diff(looked.trial)) + 1, len(looked.y)]
    edge = [int(np.abs(edges - end).argmin()) for end in span]
    at_edge = [abs(int(edges[k]) - end) < SLACK for k, end in zip(edge, span, strict=True)]
    turns = [_turns_at(looked, two, end) for end in span]
    whole = len(looked.every) > 1 and edge[0] != edge[1]
    return all(a or b for a, b in zip(turns, at_edge, strict=True)) and (any(turns) or whole)


def _turns_at(looked: _Looked, two: tuple[int, int], end: int) -> bool:
    """Whether names turn near a frame, in its trial."""
    k = int(looked.trial[min(end, len(looked.trial) - 1)])
    own = np.flatnonzero(looked.trial == k)
    first, last = looked.frame[np.clip([end - SLACK, end + SLACK - 1], own[0], own[-1])].tolist()
    return names_turn(looked.every[k], two, (first, last), looked.rates[k])


def _stretches(looked: _Looked, own: Bools) -> Iterator[tuple[int, int, int]]:
    """Trial, first and last-plus-one frame of each run of frames (F) that are exchanged."""
    for k, xyz in enumerate(looked.every):
        rows = np.flatnonzero(looked.trial == k)
        there, frame = own[rows], [*looked.frame[rows].tolist(), len(xyz)]
        changes = np.flatnonzero(np.diff(np.r_[False, there, False].astype(int)))
        yield from ((k, frame[first], frame[stop]) for first, stop in changes.reshape(-1, 2).tolist())
