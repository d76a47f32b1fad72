"""What is different between two versions of a trial: first who is who, then where.

A sample that is at exactly the same place in both versions is the same sample; where its name is another, it was
renamed. What is left of a marker was added, erased, or moved. Markers that share their record, as edits leave those
that they are not about, are not looked at.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Bools, Floats, Ints


class Renamed(NamedTuple):
    """Samples that have another name: which, first and last frame (numbers in the recording), and how many."""

    before: str
    after: str
    first: int
    last: int
    samples: int


class Changed(NamedTuple):
    """Samples of a marker that were added, erased or moved: frames, how many, and how far at most, mm."""

    marker: str
    what: Literal["added", "erased", "moved"]
    first: int
    last: int
    samples: int
    max_mm: float = float("nan")


@dataclass(frozen=True, slots=True)
class Difference:
    """Between two versions of a trial: what has another name, and what has other samples."""

    renamed: tuple[Renamed, ...] = ()
    changed: tuple[Changed, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.renamed or self.changed)


def difference(before: Trajectories, after: Trajectories) -> Difference:
    """What is different; frames that only one version has, as after trimming, count as added or erased.

    Args:
        before, after: versions of one trial.

    Raises:
        ValueError: their rates differ.
    """
    if before.rate != after.rate:
        raise ValueError(f"the versions have {before.rate:g} and {after.rate:g} Hz, wanted two of one trial")
    start = min(before.first_frame, after.first_frame)
    n = max(one.first_frame + one.n_frames for one in (before, after)) - start
    same_frames = before.first_frame == after.first_frame and before.n_frames == after.n_frames
    shared = {id(path) for path in after} & {id(path) for path in before} if same_frames else set[int]()
    old, new = (
        {path.name: _on(path.xyz, one.first_frame - start, n) for path in one if id(path) not in shared}
        for one in (before, after)
    )
    named_alike = {(p, q): _equal(old[p], new[q]) for p in old for q in new}
    renamed = [
        Renamed(p, q, *_span(run, start), len(run))
        for (p, q), same in named_alike.items()
        if p != q
        for run in _runs(same, np.isfinite(old[p][:, 0]))
    ]
    kept_old = {p: _any([named_alike[p, q] for q in new], n) for p in old}
    kept_new = {q: _any([named_alike[p, q] for p in old], n) for q in new}
    changed = [
        one for name in dict.fromkeys([*old, *new]) for one in _changed(name, old, new, kept_old, kept_new, start)
    ]
    return Difference(
        tuple(sorted(renamed, key=lambda one: (one.first, one.before))),
        tuple(sorted(changed, key=lambda one: (one.first, one.marker))),
    )


def _changed(
    name: str,
    old: dict[str, Floats],
    new: dict[str, Floats],
    kept_old: dict[str, Bools],
    kept_new: dict[str, Bools],
    start: int,
) -> Iterator[Changed]:
    """Samples of a marker that are not the same ones under any name."""
    nothing = np.full_like(next(iter((old or new).values())), np.nan)
    a, b = old.get(name, nothing), new.get(name, nothing)
    in_a, in_b = np.isfinite(a[:, 0]), np.isfinite(b[:, 0])
    gone = in_a & ~kept_old.get(name, ~in_a)
    come = in_b & ~kept_new.get(name, ~in_b)
    off = np.linalg.norm(b - a, axis=1)
    for run in _runs(gone & come, in_a | in_b):
        yield Changed(name, "moved", *_span(run, start), len(run), float(off[run].max()))
    for run in _runs(gone & ~come, in_a):
        yield Changed(name, "erased", *_span(run, start), len(run))
    for run in _runs(come & ~gone, in_b):
        yield Changed(name, "added", *_span(run, start), len(run))


def _on(xyz: Floats, shift: int, n: int) -> Floats:
    """A path (F, 3) on the frames that both versions have together."""
    whole = np.full((n, 3), np.nan)
    whole[shift : shift + len(xyz)] = xyz
    return whole


def _equal(a: Floats, b: Floats) -> Bools:
    same: Bools = (a == b).all(1)
    return same


def _any(masks: list[Bools], n: int) -> Bools:
    return np.any(masks, axis=0) if masks else np.zeros(n, bool)


def _runs(chosen: Bools, there: Bools) -> list[Ints]:
    """The chosen samples in runs that no other sample that is there interrupts."""
    at = np.flatnonzero(chosen)
    others = np.cumsum(there & ~chosen)
    return np.split(at, np.flatnonzero(np.diff(others[at])) + 1) if len(at) else []


def _span(run: Ints, start: int) -> tuple[int, int]:
    return int(run[0]) + start, int(run[-1]) + start
