"""The fill that was chosen for each gap, and what is said of it besides: whether it rests on suspicious samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from ..data.array_types import Bools, Floats
from .edges import GapEdges, trim_edges
from .filled_gap import FilledGap
from .judge.choice import FIRST, CandidateFill
from .judge.contradicted_edges import contradicted_edges
from .judge.contradiction import largest_jump
from .judge.doubtful_edges import TiedFill, doubted, method_again, without_suspicious
from .judge.two_sides import apart_on_the_body
from .marker_array import Gap, MarkerArray, Prediction, find_gaps


class ChosenFill(NamedTuple):
    """The method chosen for a gap, what is said of it, its prediction with the covariance, and all candidates."""

    gap: Gap
    found: FilledGap
    prediction: Prediction
    cov: Floats
    candidates: Sequence[CandidateFill]

    def tied(self) -> TiedFill:
        """The fill, and the method that is asked again without suspicious samples."""
        return TiedFill(self.prediction.xyz, method_again(self.found, self.candidates))

    def witness(self) -> CandidateFill | None:
        """How `FIRST` did, which tells best where the marker is; None where it was not tried."""
        return next((one for one in self.candidates if one.name == FIRST), None)


class KnownEdges(NamedTuple):
    """A trial whose samples beside gaps were judged.

    Attributes:
        motion: what fillers see: without outliers, and without suspicious samples where these are trimmed.
        trimmed: the same without suspicious samples.
        suspicious: frames of those that are kept, by their gap.
        plausible: (M, F) samples that can be positions.
        method: how they were judged.
    """

    motion: MarkerArray
    trimmed: MarkerArray
    suspicious: Mapping[Gap, tuple[int, ...]]
    plausible: Bools
    method: GapEdges

    @classmethod
    def of(cls, motion: MarkerArray, edges: GapEdges, *, keep: bool) -> KnownEdges:
        """Of a trial without outliers; `keep`: suspicious samples stay in it and are listed."""
        known = trim_edges(motion, find_gaps(motion), method=edges)
        if keep:
            return cls(motion, known.motion, known.suspicious(), motion.seen, edges)
        return cls(known.motion, known.motion, {}, motion.seen, edges)

    def contradicted(self, fills: Sequence[ChosenFill]) -> KnownEdges:
        """The same, with the samples that fills made without them contradict."""
        witnesses = {one.gap: by for one in fills if one.found.method and (by := one.witness())}
        if not self.method.most_trimmed or not witnesses:
            return self
        more = contradicted_edges(self.motion, witnesses, self.method.least_error)
        suspicious = dict(self.suspicious)
        for gap, frames in more.items():
            suspicious[gap] = tuple(sorted({*suspicious.get(gap, ()), *frames}))
        trimmed = self.trimmed.hidden(Gap(gap.marker, f, f + 1) for gap, frames in more.items() for f in frames)
        return self._replace(trimmed=trimmed, suspicious=suspicious)

    def is_doubtful(self, one: ChosenFill) -> bool:
        """Whether a fill is tied to suspicious samples."""
        return one.gap in self.suspicious and bool(one.found.method)


def judged(fills: Sequence[ChosenFill], known: KnownEdges) -> list[tuple[FilledGap, Floats]]:
    """What is said of each fill in the end, and its covariance (L, 3, 3) mm²."""
    sides = [apart_on_the_body(known.trimmed, one.gap) for one in fills]
    known = known.contradicted([one for one, mm in zip(fills, sides, strict=True) if not mm])
    apart = without_suspicious(known.trimmed, {one.gap: one.tied() for one in fills if known.is_doubtful(one)})
    return [_judged(one, known, mm, apart.get(one.gap)) for one, mm in zip(fills, sides, strict=True)]


def _judged(one: ChosenFill, known: KnownEdges, sides_mm: float, apart: Floats | None) -> tuple[FilledGap, Floats]:
    """Of one; `apart` (L, 3) mm from it without suspicious samples."""
    beside = known.suspicious.get(one.gap, ())
    xyz, references = one.prediction.xyz, one.prediction.references
    jump = 0.0 if beside else largest_jump(known.motion, one.gap, xyz, references)  # none to a bad sample
    found = replace(one.found, suspicious=beside, jump_mm=jump, sides_mm=sides_mm)
    return (found, one.cov) if apart is None else doubted(found, one.cov, apart)
