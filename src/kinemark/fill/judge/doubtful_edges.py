"""Fills beside suspicious samples: made once more as if these were missing.

A fill is tied to the samples beside its gap. Where those are suspicious it may be wrong by as much as they are, and no
hold-out gap, whose edges are good, says so. Without them the gap is a longer one, and is filled as any gap of a trial
that never had them, with hold-out gaps of its own: in those of the first fill, methods learnt from bad samples too.

Where that fill contradicts the samples it stands in the gap. With d(t) from it to a sample in doubt, and C(t) its
calibrated covariance, it does so if

    |d(t)| > k √(tr C(t))     and     |d(t)| > the least error of `edges`                                 (1)

for any. k is TIMES, as in `contradicted_edges`, for samples that only the other markers contradict. Others stand out
from the marker's own motion (`edges`). Some of these are good samples of a rare movement, which the fill does not know:
its errors are several times what hold-out gaps in usual movements tell. Bad samples that stand out so are farther off
than that. So beside them k is RARE. Where it is not contradicted the fill stays tied to the samples, and what is
expected of it and its covariance become

    max(ē, mean |d|),     V + d dᵀ                                                                          (2)
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from ...data.array_types import Bools
from ..marker_array import Gap, MarkerArray
from ..methods.stage import filler_of
from .choice import FIRST, ChosenFill
from .contradicted_edges import TIMES
from .contradiction import largest_sd

RARE = 7.0
"""k of (1), without unit, where samples stand out from the marker's own motion; chosen: docs/theory/fill.md has
what others cost."""
Fill = Callable[[MarkerArray, list[Gap], Collection[str]], list[ChosenFill]]
"""Fills some gaps of a trial, each as it is done best by methods of these names."""


def filled_without(trimmed: MarkerArray, fills: Sequence[ChosenFill], fill: Fill) -> dict[Gap, ChosenFill]:
    """Fills once more, by gap, in the trial without the suspicious samples; one that cannot be made so is left out.

    Each fills these too. For time, by no other methods than made the first fills, and `FIRST`.
    """
    longer = {one.gap: _run(trimmed.seen[one.gap.marker], one.gap) for one in fills}
    methods = {FIRST, *(name for one in fills for name in one.found.method.split(" + "))}
    made = {one.gap: one for one in fill(trimmed, sorted(set(longer.values())), methods)} if fills else {}
    return {gap: made[all_of_it] for gap, all_of_it in longer.items() if made[all_of_it].found.method}


def contradicted_mm(
    known: MarkerArray,
    trimmed: MarkerArray,
    again: ChosenFill,
    frames: Sequence[int],
    least_mm: float,
    *,
    stand_out: bool = False,
) -> float:
    """How far a fill is off its marker's samples in these frames; 0 by (1) unless it contradicts one, by more than
    `least_mm`, or where no other markers tell.

    Args:
        known: the trial. trimmed: without these samples, from which the fill was made. again: the fill.
        frames: of the samples. least_mm: of (1), mm.
        stand_out: from the marker's own motion.
    """
    at = np.array(frames, np.int64) - again.gap.start
    samples = known.xyz[again.gap.marker, again.gap.start :][at]
    d = np.linalg.norm(samples - again.prediction.xyz[at], axis=1)
    k = RARE if stand_out else TIMES
    beyond = (d > k * np.sqrt(np.trace(again.cov[at], axis1=1, axis2=2))) & (d > least_mm)
    return float(d[beyond].max()) if beyond.any() and _others_tell(trimmed, again) else 0.0


def _others_tell(trimmed: MarkerArray, again: ChosenFill) -> bool:
    """Whether `FIRST`, which needs other markers, has a prediction here; asked, as in trials of many gaps it is not."""
    by = again.witness()
    if not by or not np.isfinite(again.found.candidates[FIRST]):
        return False
    (told,) = filler_of(by.method)(trimmed, [again.gap], method=by.method)
    return bool(np.isfinite(told.xyz).all())


def cut(one: ChosenFill, gap: Gap, off_mm: float = 0.0) -> ChosenFill:
    """A fill of a longer gap as one of the gap itself, which is off the samples beside it by so much."""
    first = gap.start - one.gap.start
    part, prediction = slice(first, first + gap.length), one.prediction
    cov = one.cov[part]
    found = replace(one.found, start=gap.start, stop=gap.stop, sd_mm=largest_sd(cov), off_mm=off_mm)
    prediction = prediction._replace(xyz=prediction.xyz[part], cov=prediction.cov[part])
    return one._replace(gap=gap, found=found, prediction=prediction, cov=cov)


def doubted(one: ChosenFill, again: ChosenFill) -> ChosenFill:
    """(2) of a fill, and the same without the suspicious samples."""
    d = again.prediction.xyz - one.prediction.xyz
    cov = one.cov + np.einsum("fi,fj->fij", d, d)
    apart = float(np.linalg.norm(d, axis=1).mean())
    found = replace(one.found, expected_mm=max(one.found.expected_mm, apart), sd_mm=largest_sd(cov))
    return one._replace(found=found, cov=cov)


def _run(seen: Bools, gap: Gap) -> Gap:
    """All frames in one piece with a gap in which its marker is not seen."""
    before, after = np.flatnonzero(seen[: gap.start]), np.flatnonzero(seen[gap.stop :])
    start = int(before[-1]) + 1 if len(before) else 0
    stop = gap.stop + int(after[0]) if len(after) else len(seen)
    return Gap(gap.marker, start, stop)
