"""What problems are made of: the trial as it is edited now, and the edits that would mend it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ...data import MarkerTrajectory, Origin, Trajectories
from ...data.array_types import Floats, Ints
from ...data.edits import UNNAMED, Claim, Edit, Erase, Stretch, Verdict, is_named
from ...data.problems import Action, Alternative, ProblemKind, problem_id
from ...edit import Edited, stretch_of
from ...edit.crossings import unbroken
from ...fill import usual_limit
from ...numerics.finite import finite_median
from ...report.words.problems import action_text
from ..editing.editing import Editing
from ..editing.makers import REVIEWED_BESIDE, by_pieces

VERSIONS = 3
"""Of a trial whose problems are kept, a number; chosen: now, before the last act, and what is judged besides."""
GRID_MM, GRID_S = 50.0, 0.1
"""To which places and times are rounded in the id of a problem; chosen: far above what reprocessing moves them."""


@dataclass(frozen=True, eq=False)
class Context:
    """A trial that is looked at.

    Attributes:
        editing: it. edited: with all that was said.
    """

    editing: Editing
    edited: Edited

    @property
    def now(self) -> Trajectories:
        """The trajectories as they are called now."""
        return self.edited.trajectories

    @cached_property
    def pieces(self) -> Ints:
        """(M, F) of each path, unbroken (`crossings.unbroken`): worked out once for all that is said of it."""
        return unbroken(self.now.paths, self.now)

    @cached_property
    def own(self) -> tuple[Ints, ...]:
        """Frames that each path has, from 0."""
        return tuple(np.flatnonzero(path.origin != Origin.MISSING) for path in self.now)

    @cached_property
    def limit_mm(self) -> float:
        """How far off a fill may be expected to be: an open sample costs as much."""
        return usual_limit(self.now.xyz[[name not in self.computed for name in self.now.names]])

    @property
    def computed(self) -> frozenset[str]:
        """Points of a file that are no markers: what they do is no problem of its own."""
        return self.editing.computed

    @property
    def markers(self) -> tuple[MarkerTrajectory, ...]:
        """The paths of now, those of computed points as never seen."""
        away = self.computed
        return tuple(_unseen(path) if path.name in away else path for path in self.now) if away else self.now.paths

    @property
    def start(self) -> int:
        """Number of the first frame."""
        return self.now.first_frame

    def name(self, path: int) -> str:
        """Of a path."""
        return self.now.paths[path].name

    def marker(self, path: int, after: int | None = None) -> str:
        """The name of a marker that a path is, one of its own where it has none; or of the piece that begins in a frame
        (from 0) where it is cut: all pieces of a path have names of their own, by which each is found again."""
        name, used = self.name(path), set(self.now.names)
        base = name if is_named(name) else f"track{name.removeprefix(UNNAMED)}"
        base = base if after is None else f"{base}_{after + self.start}"
        free, k = base, 2
        while free in used and free != name:
            free, k = f"{base}_{k}", k + 1
        return free

    def stretch(self, path: int, first: int | None = None, last: int | None = None) -> Stretch:
        """Of a path, frames from 0, both included; None follows it as far as it goes.

        Raises:
            ValueError: it has no sample there.
        """
        a, b = (None if f is None else f + self.start for f in (first, last))
        e = self.editing
        return stretch_of(
            self.now, self.name(path), first=a, last=b, detections=e.detections, world=e.world, pieces=self.pieces[path]
        )

    def claim(
        self, path: int, name: str | None, first: int | None = None, last: int | None = None, *, again: bool = False
    ) -> Iterator[Claim]:
        """The claim of a stretch, of each piece where it was joined (`makers.by_pieces`).

        None where there is no sample, or it has the name, unless it is said `again`.
        """
        whole = first is None and last is None
        if (whole and not again and name == self.name(path)) or not self._any(path, first, last):
            return
        where = self.stretch(path, first, last)
        yield from (Claim(one, name) for one in by_pieces(self.editing, self.now, self.name(path), where))

    def erase(self, path: int, first: int, last: int) -> tuple[Edit, ...]:
        """Samples of a path are wrong."""
        if is_named(self.name(path)):
            return (Erase(self.name(path), first + self.start, last + self.start),)
        return tuple(self.claim(path, None, first, last))

    def verdict(self, kind: ProblemKind, paths: Sequence[int], first: int, last: int, *, right: bool) -> Verdict:
        """Somebody decided a problem, frames from 0."""
        where = [self._beside(path, first, last) for path in paths if path >= 0]
        return Verdict(kind, tuple(stretch for stretch in where if stretch is not None), right)

    def id(self, kind: ProblemKind, path: int, frame: float) -> str:
        """The same when the trial is processed again: by time, and name or place."""
        name, when = self.name(path), round((frame + self.start) / (GRID_S * self.now.rate))
        if is_named(name):
            return problem_id(kind, when, name)
        own = self.samples(path)
        near = own[np.abs(own - frame).argmin()]
        return problem_id(kind, when, *np.round(self.now.paths[path].xyz[near] / GRID_MM).astype(int).tolist())

    def alternative(
        self, action: Action, tracks: Sequence[str], frame: int, probability: float, cost: float, edits: Sequence[Edit],
        *, mm: float = float("nan"), name: str = "", images: int | None = None,
    ) -> Alternative:  # fmt: skip
        """One way to settle a problem; `frame` is a number in the recording."""
        words = action_text(action, tracks, frame, mm, name)
        return Alternative(action, words, probability, cost, mm, images, tuple(edits))

    def samples(self, path: int) -> Ints:
        """Frames that a path has, from 0."""
        return self.own[path]

    def apart(self, one: int, other: int) -> float:
        """Median distance of two paths, mm; NaN where they are never seen together."""
        d: Floats = np.linalg.norm(self.now.paths[one].xyz - self.now.paths[other].xyz, axis=1)
        return finite_median(d)

    def _any(self, path: int, first: int | None, last: int | None) -> bool:
        own = self.samples(path)
        low, high = (-1 if first is None else first), (np.inf if last is None else last)
        return bool(((own >= low) & (own <= high)).any())

    def _beside(self, path: int, first: int, last: int) -> Stretch | None:
        """A stretch with witnesses a little before and after."""
        e, within = self.editing, (first - REVIEWED_BESIDE + self.start, last + REVIEWED_BESIDE + self.start)
        if not self._any(path, first - REVIEWED_BESIDE, last + REVIEWED_BESIDE):
            return None
        return stretch_of(
            self.now, self.name(path), first=first + self.start, last=last + self.start, within=within,
            detections=e.detections, world=e.world, pieces=self.pieces[path],
        )  # fmt: skip


@lru_cache(maxsize=1024)
def _unseen(path: MarkerTrajectory) -> MarkerTrajectory:
    """The same record for the same path, so that what is known of the others is not worked out again."""
    return MarkerTrajectory.measured(path.name, np.full_like(path.xyz, np.nan))
