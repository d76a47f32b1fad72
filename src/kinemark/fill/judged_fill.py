"""The fill that was chosen for each gap, and what suspicious samples beside the gap make of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from ..data.array_types import Bools
from .edges import GapEdges, trim_edges
from .judge.choice import ChosenFill
from .judge.contradicted_edges import ContradictedEdge, contradicted_edges
from .judge.contradiction import largest_jump
from .judge.doubtful_edges import Fill, contradicted_mm, cut, doubted, filled_without
from .judge.two_sides import apart_on_the_body
from .marker_array import Gap, MarkerArray, find_gaps


class KnownEdges(NamedTuple):
    """A trial whose samples beside gaps were judged.

    Attributes:
        motion: what fillers see: without outliers, and without suspicious samples where these are trimmed.
        trimmed: the same without suspicious samples.
        suspicious: frames of those that are kept and stand out from the marker's own motion, by their gap.
        plausible: (M, F) samples that can be positions.
        method: how they were judged.
        against: what a fill made without it seems to contradict, by the gap.
    """

    motion: MarkerArray
    trimmed: MarkerArray
    suspicious: Mapping[Gap, tuple[int, ...]]
    plausible: Bools
    method: GapEdges
    against: Mapping[Gap, ContradictedEdge] = {}

    @classmethod
    def of(cls, motion: MarkerArray, edges: GapEdges, *, keep: bool) -> KnownEdges:
        """Of a trial without outliers; `keep`: suspicious samples stay in it and are listed."""
        known = trim_edges(motion, find_gaps(motion), method=edges)
        if keep:
            return cls(motion, known.motion, known.suspicious(), motion.seen, edges)
        return cls(known.motion, known.motion, {}, motion.seen, edges)

    def contradicted(self, fills: Sequence[ChosenFill]) -> KnownEdges:
        """The same, with the samples that fills made without them seem to contradict."""
        witnesses = {one.gap: by for one in fills if one.found.method and (by := one.witness())}
        if not self.method.most_trimmed or not witnesses:
            return self
        against = contradicted_edges(self.motion, witnesses, self.method.least_error)
        ignored = [
            Gap(gap.marker, frame, frame + 1)
            for gap, one in against.items()
            for frame in one.ignored(gap, self.suspicious.get(gap, ()))
        ]
        return self._replace(trimmed=self.trimmed.hidden(ignored), against=against)

    def in_doubt(self, gap: Gap) -> tuple[int, ...]:
        """Frames of all samples beside a gap that stand out or seem to be contradicted."""
        against = self.against[gap].frames if gap in self.against else ()
        return tuple(sorted({*self.suspicious.get(gap, ()), *against}))


def judged(fills: Sequence[ChosenFill], known: KnownEdges, fill: Fill) -> list[ChosenFill]:
    """The fills as they are in the end, made by `fill` without samples that these contradict; what is said of them."""
    sides = [apart_on_the_body(known.trimmed, one.gap) for one in fills]
    known = known.contradicted([one for one, mm in zip(fills, sides, strict=True) if not mm])
    doubtful = [one for one in fills if one.found.method and known.in_doubt(one.gap)]
    again = filled_without(known.trimmed, doubtful, fill)
    return [_judged(one, known, mm, again.get(one.gap)) for one, mm in zip(fills, sides, strict=True)]


def _judged(one: ChosenFill, known: KnownEdges, sides_mm: float, again: ChosenFill | None) -> ChosenFill:
    """One; `again`: the same, and the samples in doubt, without these."""
    gap, beside, doubt = one.gap, known.suspicious.get(one.gap, ()), known.in_doubt(one.gap)
    if again:
        least, stand_out = known.method.least_error, bool(beside)
        if off := contradicted_mm(known.motion, known.trimmed, again, doubt, least, stand_out=stand_out):
            one, beside = cut(again, gap, off), doubt
        elif beside:
            one = doubted(one, cut(again, gap))
    filled, references = one.prediction.xyz, one.prediction.references
    jump = 0.0 if beside else largest_jump(known.motion, gap, filled, references)  # none to a bad sample
    return one._replace(found=replace(one.found, suspicious=beside, jump_mm=jump, sides_mm=sides_mm))
