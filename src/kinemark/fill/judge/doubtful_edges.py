"""Fills that rest on suspicious samples: how far they would be elsewhere without these.

A fill is tied to the samples beside its gap. Where those are suspicious (`edges`, `contradicted_edges`) they may be
wrong by any amount, and no hold-out gap, whose edges are good, says so. So the method that was chosen fills the gap
once more with the suspicious samples missing. With d(t) from the one fill to the other, what is expected of the fill,
and its covariance, become

    max(ē, mean |d|),     V + d dᵀ                                                                          (1)

Which of both is right is not known: some suspicious samples are good ones of a rare movement.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats
from ..filled_gap import FilledGap
from ..marker_array import Gap, MarkerArray
from ..methods.stage import filler_of
from .choice import CandidateFill


class TiedFill(NamedTuple):
    """A fill (L, 3) mm, and the method that is asked again."""

    xyz: Floats
    method: Any


def method_again(found: FilledGap, answers: Sequence[CandidateFill]) -> Any:
    """The method of a fill as it was tried; of those that a mean names the one of the least expected error."""
    best = min(found.method.split(" + "), key=lambda name: found.candidates[name])
    return next(answer.method for answer in answers if answer.name == best)


def without_suspicious(trimmed: MarkerArray, fills: Mapping[Gap, TiedFill]) -> dict[Gap, Floats]:
    """d of (1), (L, 3) mm, of fills whose gaps have suspicious samples beside them.

    Args:
        trimmed: the trial in which these samples are missing.
        fills: by their gaps; one that cannot be filled without them is left out.
    """
    longer = {gap: _run(trimmed.seen[gap.marker], gap) for gap in fills}
    found = {}
    for method in dict.fromkeys(fill.method for fill in fills.values()):
        mine = [gap for gap, fill in fills.items() if fill.method == method]
        again = filler_of(method)(trimmed, [longer[gap] for gap in mine], method=method)
        for gap, prediction in zip(mine, again, strict=True):
            first = gap.start - longer[gap].start
            d = prediction.xyz[first : first + gap.length] - fills[gap].xyz
            if np.isfinite(d).all():
                found[gap] = d
    return found


def doubted(found: FilledGap, cov: Floats, d: Floats) -> tuple[FilledGap, Floats]:
    """(1)."""
    cov = cov + np.einsum("fi,fj->fij", d, d)
    apart = float(np.linalg.norm(d, axis=1).mean())
    sd = float(np.sqrt(np.diagonal(cov, axis1=-2, axis2=-1).max())) if np.isfinite(found.sd_mm) else found.sd_mm
    return replace(found, expected_mm=max(found.expected_mm, apart), sd_mm=sd), cov


def _run(seen: Bools, gap: Gap) -> Gap:
    """All frames in one piece with a gap in which its marker is not seen."""
    before, after = np.flatnonzero(seen[: gap.start]), np.flatnonzero(seen[gap.stop :])
    start = int(before[-1]) + 1 if len(before) else 0
    stop = gap.stop + int(after[0]) if len(after) else len(seen)
    return Gap(gap.marker, start, stop)
