"""Faults seeded into trials whose truth is known, for the study of probable errors.

exchange   two paths have each other's samples from a frame on: near ones, or at a gap
stretch    the same for 0.2 to 1 s only: a mislabelled stretch
join       a path goes on as another one, whose own rest is a path without a name
spike      1 to 6 samples stand 15 to 100 mm off
cut        a path is two, from a gap on
rough      in files: up to three paths near each other have up to three wrong stretches each within a second, of 1 to 20
           frames, at another marker's place or 20 to 200 mm off; some end or begin at a gap; steps are smeared over 1
           to 6 frames, as filters do
smeared    in files: two paths have each other's samples from a frame on, and were filtered afterwards
filled     in files: for 0.05 to 1.5 s a path stands still and jumps back, or goes straight; or it stands still from a
           frame on, or up to one: nobody's samples
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from kinemark.data import MarkerTrajectory, Origin, Trajectories
from kinemark.data.array_types import Floats, Ints
from kinemark.signal import assign

FAR = 20.0  # mm; a sample belongs to the nearest true marker within
COLUMNS = ("xyz", "cov", "origin", "residual", "cameras", "detection")


def owners(trajectories: Trajectories, truth: Floats) -> Ints:
    """(P, F) the true marker of each sample; −1 for none."""
    mine = trajectories.xyz
    owner = np.full(mine.shape[:2], -1, np.int64)
    for f in range(mine.shape[1]):
        there = np.flatnonzero(np.isfinite(truth[:, f, 0]))
        rows = np.flatnonzero(np.isfinite(mine[:, f, 0]))
        if len(there) and len(rows):
            apart = np.linalg.norm(mine[rows, f, None] - truth[there, f], axis=-1)
            i, j = assign(apart, np.full(len(rows), FAR))
            owner[rows[i], f] = there[j]
    return owner


@dataclass
class Faulty:
    """A trial while faults are seeded: columns of each path, owners (F) of each, and what was done: kind and frame."""

    source: Trajectories
    columns: list[dict[str, np.ndarray]]
    names: list[str]
    owner: list[Ints]
    done: list[tuple[str, int]] = field(default_factory=list)

    @classmethod
    def of(cls, trajectories: Trajectories, owner: Ints) -> Faulty:
        """A trial before any."""
        columns = [{name: getattr(path, name).copy() for name in COLUMNS} for path in trajectories]
        return cls(trajectories, columns, list(trajectories.names), [row.copy() for row in owner])

    @property
    def trajectories(self) -> Trajectories:
        """The trial as it is now."""
        pairs = zip(self.names, self.columns, strict=True)
        return replace(self.source, paths=tuple(MarkerTrajectory(name, **columns) for name, columns in pairs))

    @property
    def images(self) -> bool:
        """Whether the trial was tracked from images."""
        return any(columns["detection"].shape[1] for columns in self.columns)

    def seen(self, p: int) -> Ints:
        """Frames that a path has."""
        return np.flatnonzero(self.columns[p]["origin"] != Origin.MISSING)

    def near(self, p: int, f: int) -> list[int]:
        """Other paths that have samples on both sides, the nearest in frame f first."""
        x = self.columns[p]["xyz"][f]
        found = []
        for q in range(len(self.columns)):
            own = self.seen(q)
            if q == p or len(own) < 20 or own[0] > f - 8 or own[-1] < f + 8:
                continue
            at = own[np.abs(own - f).argmin()]
            found.append((float(np.linalg.norm(self.columns[q]["xyz"][at] - x)), q))
        return [q for _, q in sorted(found)]

    def exchange(self, p: int, q: int, first: int, stop: int) -> None:
        """Two paths have each other's samples in these frames."""
        for name in COLUMNS:
            a, b = self.columns[p][name], self.columns[q][name]
            a[first:stop], b[first:stop] = b[first:stop].copy(), a[first:stop].copy()
        a, b = self.owner[p], self.owner[q]
        a[first:stop], b[first:stop] = b[first:stop].copy(), a[first:stop].copy()

    def blank(self, f: int, stop: int, p: int) -> tuple[dict[str, np.ndarray], Ints]:
        """The part of path p in these frames as a path of its own, taken from it."""
        part = {name: column.copy() for name, column in self.columns[p].items()}
        owner = self.owner[p].copy()
        outside = np.ones(len(owner), bool)
        outside[f:stop] = False
        for columns, own, gone in ((part, owner, outside), (self.columns[p], self.owner[p], ~outside)):
            for name in ("xyz", "cov", "residual"):
                columns[name][gone] = np.nan
            columns["origin"][gone], columns["cameras"][gone] = Origin.MISSING, 0
            columns["detection"][gone] = -1
            own[gone] = -1
        return part, owner


def place(faulty: Faulty, rng: np.random.Generator, *, at_gap: bool) -> tuple[int, int] | None:
    """A path and a frame, away from its ends; the first after a gap where that is asked for."""
    long = [p for p in range(len(faulty.columns)) if len(faulty.seen(p)) > 40]
    for p in rng.permutation(long).tolist():
        own = faulty.seen(p)
        inside = own[15:-15]
        if at_gap:
            inside = inside[np.diff(own)[14 : 14 + len(inside)] > 1]
        if len(inside):
            return p, int(rng.choice(inside))
    return None


def exchange(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=bool(rng.random() < 0.5)) or place(faulty, rng, at_gap=False)
    others = faulty.near(*where)[:3] if where else []
    if not where or not others:
        return False
    faulty.exchange(where[0], others[int(rng.integers(len(others)) if rng.random() < 0.3 else 0)], where[1], 10**9)
    faulty.done.append(("exchange", where[1]))
    return True


def stretch(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=False)
    others = faulty.near(*where)[:3] if where else []
    if not where or not others:
        return False
    n = round(float(rng.uniform(0.2, 1.0)) * faulty.source.rate)
    faulty.exchange(where[0], others[0], where[1], where[1] + n)
    faulty.done += [("exchange", where[1])]
    if where[1] + n < faulty.source.n_frames - 10:
        faulty.done += [("exchange", where[1] + n)]
    return True


def join(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=bool(rng.random() < 0.7)) or place(faulty, rng, at_gap=False)
    others = faulty.near(*where)[:2] if where else []
    if not where or not others:
        return False
    p, f = where
    part, owner = faulty.blank(f, 10**9, p)
    faulty.columns.append(part)
    faulty.owner.append(owner)
    faulty.names.append(f"*{900 + len(faulty.columns)}")
    faulty.exchange(p, others[0], f, 10**9)
    faulty.done.append(("join", f))
    return True


def spike(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=False)
    if not where:
        return False
    p, f = where
    n = int(rng.integers(1, 7))
    part = faulty.columns[p]["xyz"][f : f + n]
    part += float(rng.uniform(15, 100)) * (v := rng.normal(size=3)) / np.linalg.norm(v) + rng.normal(0, 2, part.shape)
    faulty.done.append(("spike", f))
    return True


def cut(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=True)
    if not where:
        return False
    part, owner = faulty.blank(where[1], 10**9, where[0])
    faulty.columns.append(part)
    faulty.owner.append(owner)
    faulty.names.append(f"*{900 + len(faulty.columns)}")
    faulty.done.append(("cut", where[1]))
    return True


def rough(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=False)
    if not where or faulty.images:
        return False
    p, f = where
    second = round(faulty.source.rate)
    for path in [p, *faulty.near(p, f)[:3]][: int(rng.integers(1, 4))]:
        for _ in range(int(rng.integers(1, 4))):
            wrong_stretch(faulty, rng, path, int(f + rng.integers(-second // 2, second // 2 + 1)))
    return True


def wrong_stretch(faulty: Faulty, rng: np.random.Generator, p: int, f: int) -> None:
    """From frame f on, where the path is seen before and after."""
    n = round(float(np.exp(rng.uniform(0, np.log(20)))))
    own, stop = faulty.seen(p), f + n
    if own.size < 40 or f < own[5] or stop > own[-5]:
        return
    x = faulty.columns[p]["xyz"]
    others = faulty.near(p, f)[:3]
    if others and rng.random() < 0.5:
        off = faulty.columns[int(rng.choice(others))]["xyz"][f] - x[f]
    else:
        off = float(np.exp(rng.uniform(np.log(20), np.log(200)))) * (v := rng.normal(size=3)) / np.linalg.norm(v)
    if not np.isfinite(off).all():
        return
    inside = np.zeros(len(x))
    inside[f:stop] = 1.0
    x += smeared_over(inside, int(rng.integers(1, 7)))[:, None] * off
    side, missing = rng.random(), int(rng.integers(2, 20))
    if side < 0.25:
        faulty.blank(stop, stop + missing, p)
    elif side < 0.5:
        faulty.blank(f - missing, f, p)
    faulty.done += [("rough", f)] if side < 0.25 or side >= 0.5 else [("rough", stop)]


def smeared(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=False)
    others = faulty.near(*where)[:3] if where else []
    if not where or not others or faulty.images:
        return False
    (p, f), q, n = where, int(rng.choice(others)), int(rng.integers(2, 7))
    faulty.exchange(p, q, f, 10**9)
    inside = np.zeros(faulty.source.n_frames)
    inside[f:] = 1.0
    for one, other in ((p, q), (q, p)):
        own, its = faulty.columns[one]["xyz"], faulty.columns[other]["xyz"]
        step = np.nan_to_num(own[f] - its[f])
        own += (smeared_over(inside, n) - inside)[:, None] * step
    faulty.done.append(("smeared", f))
    return True


def smeared_over(inside: Floats, n: int) -> Floats:
    """A step of 0 to 1 that goes on over n frames, as a filter leaves it."""
    weight = np.hanning(n + 2)[1:-1]
    return np.convolve(np.pad(inside, n, mode="edge"), weight / weight.sum(), mode="same")[n:-n]


def filled(faulty: Faulty, rng: np.random.Generator) -> bool:
    where = place(faulty, rng, at_gap=False)
    if not where or faulty.images:
        return False
    p, f = where
    n = max(4, round(float(np.exp(rng.uniform(np.log(0.05), np.log(1.5)))) * faulty.source.rate))
    own, x = faulty.seen(p), faulty.columns[p]["xyz"]
    inside = own[(own >= f) & (own < f + n)]
    if len(inside) < n or f + n > own[-1] or f <= own[0]:
        return False
    first, last = f - 1, f + n
    kind = str(rng.choice(["held", "line", "line", "end", "beginning"]))
    frames = {"end": own[own >= f], "beginning": own[own < last]}.get(kind, inside)
    share = (frames[:, None] - first) / (last - first)
    a, b = x[first].copy(), x[last].copy()
    x[frames] = a * (1 - share) + b * share if kind == "line" else b if kind == "beginning" else a
    faulty.owner[p][frames] = -1
    faulty.done.append(("filled", int(frames[len(frames) // 2])))
    return True


KINDS: dict[str, Callable[[Faulty, np.random.Generator], bool]] = {
    "exchange": exchange, "stretch": stretch, "join": join, "spike": spike, "cut": cut, "rough": rough,
    "smeared": smeared, "filled": filled,
}  # fmt: skip


def seeded(trajectories: Trajectories, owner: Ints, seed: int, *, counts: dict[str, int] | None = None) -> Faulty:
    """A trial with faults: of each kind 0 to 2, or so many."""
    rng = np.random.default_rng([seed, 17])
    faulty = Faulty.of(trajectories, owner)
    for kind, one in KINDS.items():
        n = int(rng.integers(0, 3)) if counts is None else counts.get(kind, 0)
        for _ in range(n):
            one(faulty, rng)
    return faulty
