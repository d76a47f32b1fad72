"""Gaps, and edits that no longer find their places, as problems."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...data.edits import GapChoice, Undo, Verdict, is_named
from ...data.problems import Alternative, Problem, problem_id
from ...fill import LIMIT, FilledGap
from ...report.words.problems import problem_text
from .context import Context

OFFERED = 4
"""Methods that are offered for a gap, at most; chosen: as many as keys and curves can tell apart."""


def of_gaps(context: Context, gaps: Sequence[FilledGap]) -> Iterator[Problem]:
    """The gaps of named markers for which nobody chose anything; `gaps` are what filling said, frames from 0."""
    chosen = context.edited.choices
    for gap in gaps:
        first, last = gap.start + context.start, gap.stop - 1 + context.start
        about = any(c.marker == gap.marker and c.first <= last and c.last >= first for c in chosen)
        if is_named(gap.marker) and gap.marker in context.now.names and not about and gap.state != "left_open":
            yield _gap(context, gap, first, last)


def _gap(context: Context, gap: FilledGap, first: int, last: int) -> Problem:
    """A gap; that it is filled by more than LIMIT off is as likely as errors about the one expected are."""
    expected = gap.expected_mm if np.isfinite(gap.expected_mm) else np.inf
    wrong = float(np.exp(-LIMIT / max(expected, 1e-9))) if gap.method else 1.0
    tracks, n = (gap.marker,), gap.length
    open_cost = n * LIMIT
    cost = n * min(expected, LIMIT)

    def way(name: str, mm: float) -> Alternative:
        return context.alternative(
            "fill", tracks, first, float("nan"), n * mm, [GapChoice(gap.marker, first, last, name)], mm=mm, name=name
        )

    single = {name: mm for name, mm in gap.candidates.items() if "+" not in name and np.isfinite(mm)}
    ways = [way("best", expected)] if np.isfinite(expected) else []
    ways += [way(name, mm) for name, mm in sorted(single.items(), key=lambda one: one[1])[:OFFERED]]
    leave = [GapChoice(gap.marker, first, last, "open")]
    ways.append(context.alternative("leave_open", tracks, first, float("nan"), open_cost, leave))
    return Problem(
        context.id("gap", context.now.names.index(gap.marker), gap.start), "gap", tracks, first, last, first, wrong, n,
        cost, problem_text("gap", tracks, first, last, gap.expected_mm),
        tuple(sorted(ways, key=lambda one: one.cost)), {"expected_mm": float(gap.expected_mm)},
    )  # fmt: skip


def of_edits(context: Context) -> Iterator[Problem]:
    """Edits that are thin, or orphans."""
    for k, one in enumerate(context.edited.applied):
        if one.outcome not in ("thin", "orphan") or isinstance(one.edit, Verdict):
            continue
        tracks = (str(getattr(one.edit, "marker", None) or getattr(one.edit, "name", None) or "*"),)
        where = getattr(one.edit, "where", None)
        frames = [witness.frame for witness in getattr(where, "witnesses", ())]
        first = min(frames, default=getattr(one.edit, "first", getattr(one.edit, "frame", context.start)))
        last = max(frames, default=getattr(one.edit, "last", first))
        drop = context.alternative("drop_edit", tracks, first, float("nan"), 0.0, [Undo(one.entry)])
        wait = context.alternative("wait", tracks, first, float("nan"), 0.0, [])
        yield Problem(
            problem_id("edit", one.entry, k), "edit", tracks, first, last, first, 1.0, one.samples, 0.0,
            f"{problem_text('edit', tracks, first, last, float('nan'))}: {one.reason}", (drop, wait),
            {"share": one.share},
        )  # fmt: skip
