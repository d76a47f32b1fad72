"""Filling gap by gap, for a person who looks at one after the other.

    prepared = prepare(trajectories)
    prepared.candidates("LKNE", 751)   # the gap that frame 751 lies in, as each quick method fills it
    prepared.best("LKNE", 751)         # as `fill` with `auto` would fill it, were it the only one
    prepared.all_best()                # all of them, as `fill` does: each is judged by the tests of the others too

A gap is judged by hold-out gaps of its own, drawn as `fill` draws them: EARLY of them for the first answer, which takes
a few tenths of a second, and all of them for the one that counts. What was answered is kept, so that asking again takes
no time; a trial that was edited is prepared anew.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats
from ..data.progress import tell
from ..numerics.blas_threads import one_blas_thread
from .edges import GapEdges
from .fill import affordable, called, evaluate_candidates, judged_together, of_markers, tests_again, without_outliers
from .filled_gap import FilledGap
from .judge.auto import Auto
from .judge.choice import CandidateFill, ChosenFill
from .judged_fill import KnownEdges, judged
from .marker_array import Gap, MarkerArray, find_gaps
from .methods.pca import PCA
from .methods.polynomials import Cubic, Linear
from .methods.rigid_body import RigidBody
from .name_order import by_name

QUICK = (Linear(), Cubic(), RigidBody(), PCA())
"""Methods of the first answer; chosen: of each kind one that takes hundredths of a second."""
EARLY = 6
"""Hold-out gaps of the first answer; chosen: half of those that count."""


@dataclass(frozen=True, slots=True, eq=False)
class GapFill:
    """How one gap of L frames may be filled.

    Attributes:
        gap: what is said of it: method, expected error, reference markers, or why it has no fill.
        method: its name, whether or not it has a prediction.
        first: number of its first frame in the recording.
        xyz: (L, 3) mm, NaN where the method has no prediction. cov: (L, 3, 3) mm², NaN where unknown.
    """

    gap: FilledGap
    method: str
    first: int
    xyz: Floats
    cov: Floats

    @property
    def expected_mm(self) -> float:
        """Mean error expected, mm; infinite where there is no prediction, NaN where no hold-out gap tells."""
        return self.gap.expected_mm if self.gap.state != "not_predicted" else float("inf")

    @property
    def sd(self) -> Floats:
        """(L, 3) mm, standard deviation of each axis."""
        return np.asarray(np.sqrt(np.diagonal(self.cov, axis1=1, axis2=2)))


@dataclass(frozen=True, slots=True, eq=False)
class PreparedFill:
    """A trial whose gaps can be asked for one by one.

    Attributes:
        trajectories: the trial. motion: its markers as one array, by name, as `fill` takes them. gaps: of all of these.
        method: what chooses. seed: of the places of hold-out gaps.
    """

    trajectories: Trajectories
    motion: MarkerArray
    gaps: tuple[Gap, ...]
    method: Auto = field(default_factory=Auto)
    seed: int = 0
    _answered: dict[Any, Any] = field(default_factory=dict)

    def gap_at(self, marker: str, frame: int) -> Gap:
        """The gap of a marker that a frame, a number in the recording, lies in.

        Raises:
            KeyError: there is none.
        """
        at = frame - self.trajectories.first_frame
        for gap in self.gaps:
            if self.motion.names[gap.marker] == marker and gap.start <= at < gap.stop:
                return gap
        raise KeyError(f"{marker} has no gap at frame {frame}")

    def candidates(self, marker: str, frame: int, *, methods: Sequence[Any] = QUICK) -> tuple[GapFill, ...]:
        """The gap as each method would fill it, the one of the least expected error first.

        Args:
            marker: its name. frame: in the gap, a number in the recording.
            methods: as `FILL` declares them; the quick ones where not given.

        Raises:
            KeyError: there is no gap at that frame.
        """
        gap = self.gap_at(marker, frame)
        answers = self._evaluated(gap, tuple(methods), EARLY)
        fills = [(self._chosen([gap], 0, [answer]), answer.method) for answer in answers]
        found = [one for fill, by in fills for one in self._judged([fill], (by,))]  # each of this gap, which names it
        return tuple(sorted(found, key=lambda one: (not np.isfinite(one.expected_mm), one.expected_mm)))

    def best(self, marker: str, frame: int) -> GapFill:
        """The gap as it is filled in the end: by what does best in hold-out gaps, of all that `method` tries.

        Raises:
            KeyError: there is no gap at that frame.
        """
        gap = self.gap_at(marker, frame)
        methods = self.method.methods
        (found,) = self._judged([self._chosen([gap], 0, self._evaluated(gap, methods, None))], methods)
        return found

    def all_best(self, away: Collection[str] = ()) -> tuple[GapFill, ...]:
        """Every gap as `best` fills it, all judged together: a tenth of the time and less of one by one.

        Args:
            away: names of points whose gaps are not filled, as those that are no markers.
        """
        names = self.motion.names
        gaps = [gap for gap in of_markers(list(self.gaps), names) if names[gap.marker] not in away]
        with one_blas_thread():
            methods = affordable(self.method.methods, len(gaps), self.trajectories.n_frames)
            answers = judged_together(self.motion, gaps, methods, seed=self.seed)
        found = []
        for index in range(len(gaps)):
            tell(index, len(gaps))
            found.append(self._chosen(gaps, index, answers))
        place = self.trajectories.names.index
        return tuple(sorted(self._judged(found, methods), key=lambda one: (place(one.gap.marker), one.first)))

    def _evaluated(self, gap: Gap, methods: tuple[Any, ...], tests: int | None) -> list[CandidateFill]:
        key = gap, methods, tests
        if key not in self._answered:
            with one_blas_thread():
                found = evaluate_candidates(self.motion, [gap], methods, seed=self.seed, per_gap=tests)
            self._answered[key] = found
        answered: list[CandidateFill] = self._answered[key]
        return answered

    def _chosen(self, gaps: list[Gap], index: int, answers: list[CandidateFill]) -> ChosenFill:
        """That of one of the gaps that were judged together."""
        return ChosenFill.of(self.motion, gaps, index, answers)

    def _judged(self, fills: Sequence[ChosenFill], methods: Sequence[Any]) -> tuple[GapFill, ...]:
        """These, made by the best of some methods, with what samples beside their gaps say of them."""

        def again(motion: MarkerArray, gaps: list[Gap], names: Collection[str]) -> list[ChosenFill]:
            some, each = called(methods, names), tests_again(gaps, fills)
            answers = judged_together(motion, gaps, some, seed=self.seed, per_gap=each)
            return [ChosenFill.of(motion, gaps, index, answers) for index in range(len(gaps))]

        start = self.trajectories.first_frame
        return tuple(
            GapFill(
                one.found,
                one.found.method or one.candidates[0].name,
                one.found.start + start,
                one.prediction.xyz,
                one.cov,
            )
            for one in judged(fills, self._edges, again)
        )

    @property
    def _edges(self) -> KnownEdges:
        """Its samples beside gaps, judged once."""
        if KnownEdges not in self._answered:
            self._answered[KnownEdges] = KnownEdges.of(self.motion, GapEdges(), keep=True)
        known: KnownEdges = self._answered[KnownEdges]
        return known


def prepare(trajectories: Trajectories, *, method: Auto | None = None) -> PreparedFill:
    """A trial whose gaps are asked for one by one.

    Args:
        trajectories: the trial; what is filled already counts as seen.
        method: what chooses; `Auto()` where None.
    """
    motion = without_outliers(MarkerArray.of(by_name(trajectories)))
    return PreparedFill(trajectories, motion, tuple(find_gaps(motion)), method or Auto())
