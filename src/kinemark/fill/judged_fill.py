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
from .judge.doubtful_edges import Fill, doubted, filled_without
from .judge.two_sides import apart_on_the_body
from .marker_array import Gap, MarkerArray, find_gaps


class KnownEdges(NamedTuple):
    """A trial whose samples beside gaps were judged.

    Attributes:
        motion: what fillers see: without outliers, and without suspicious samples where these are trimmed.
        trimmed: the same without suspicious samples.
        suspicious: frames of those that are kept, by their gap.
        plausible: (M, F) samples that can be positions.
        method: how they were judged.
        against: what contradicts a fill made without it, by the gap.
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
        """The same, with the samples that fills made without them contradict."""
        witnesses = {one.gap: by for one in fills if one.found.method and (by := one.witness())}
        if not self.method.most_trimmed or not witnesses:
            return self
        against = contradicted_edges(self.motion, witnesses, self.method.least_error)
        own = {gap: self.suspicious.get(gap, ()) for gap in against}
        ignored = [Gap(gap.marker, f, f + 1) for gap, one in against.items() for f in one.ignored(gap, own[gap])]
        listed = {gap: tuple(sorted({*own[gap], *one.frames})) for gap, one in against.items()}
        return self._replace(
            trimmed=self.trimmed.hidden(ignored), suspicious={**self.suspicious, **listed}, against=against
        )

    def is_doubtful(self, one: ChosenFill) -> bool:
        """Whether a fill is tied to suspicious samples."""
        return one.gap in self.suspicious and bool(one.found.method)


def judged(fills: Sequence[ChosenFill], known: KnownEdges, fill: Fill) -> list[ChosenFill]:
    """The fills as they are in the end, made by `fill` without samples that these contradict; what is said of them."""
    sides = [apart_on_the_body(known.trimmed, one.gap) for one in fills]
    known = known.contradicted([one for one, mm in zip(fills, sides, strict=True) if not mm])
    again = filled_without(known.trimmed, [one for one in fills if known.is_doubtful(one)], fill)
    return [_judged(one, known, mm, again.get(one.gap)) for one, mm in zip(fills, sides, strict=True)]


def _judged(one: ChosenFill, known: KnownEdges, sides_mm: float, again: ChosenFill | None) -> ChosenFill:
    """One; `again`: the same without suspicious samples."""
    beside = known.suspicious.get(one.gap, ())
    if again:
        against = known.against.get(one.gap)
        one = (
            doubted(one, again)
            if against is None
            else again._replace(found=replace(again.found, off_mm=against.off_mm))
        )
    xyz, references = one.prediction.xyz, one.prediction.references
    jump = 0.0 if beside else largest_jump(known.motion, one.gap, xyz, references)  # none to a bad sample
    return one._replace(found=replace(one.found, suspicious=beside, jump_mm=jump, sides_mm=sides_mm))
