"""Gaps, and edits that no longer find their places, as problems."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from ...data.edits import GapChoice, Undo, Verdict, is_named
from ...data.problems import Alternative, Problem, problem_id
from ...fill import FilledGap
from ...report.words.problems import gaps_text, problem_text
from .context import Context

MOST, ALIKE = 0.5, 3
"""Share of the named markers that have a gap in the same frames, and how many at least, from which on their gaps are
one problem; by definition most of them, and chosen: a segment's markers are still looked at one by one."""
OFFERED = 4
"""Methods that are offered for a gap, at most; chosen: as many as keys and curves can tell apart."""


def of_gaps(context: Context, gaps: Sequence[FilledGap]) -> Iterator[Problem]:
    """The gaps of named markers for which nobody chose anything; `gaps` are what filling said, frames from 0."""
    open_still = [gap for gap in gaps if _asks(context, gap)]
    markers = sum(is_named(path.name) and path.name not in context.computed for path in context.now)
    for (start, stop), alike in groupby(sorted(open_still, key=_frames), key=_frames):
        some = list(alike)
        first, last = start + context.start, stop - 1 + context.start
        if len(some) > max(ALIKE, MOST * markers):
            yield _gaps(context, some, first, last)
        else:
            yield from (_gap(context, gap, first, last) for gap in some)


def _frames(gap: FilledGap) -> tuple[int, int]:
    return gap.start, gap.stop


def _asks(context: Context, gap: FilledGap) -> bool:
    """Whether it is one of a named marker that nobody said anything of."""
    first, last = gap.start + context.start, gap.stop - 1 + context.start
    said = (c.marker == gap.marker and c.first <= last and c.last >= first for c in context.edited.choices)
    there = is_named(gap.marker) and gap.marker in context.now.names
    return there and gap.state != "left_open" and not any(said)


def _gaps(context: Context, some: Sequence[FilledGap], first: int, last: int) -> Problem:
    """Gaps of most markers in the same frames, as where these were erased: one thing to look at."""
    each = [_gap(context, gap, first, last) for gap in some]
    worst = max(each, key=lambda one: one.wrong)
    tracks = tuple(gap.marker for gap in some)
    known = [gap.expected_mm for gap in some if gap.method and np.isfinite(gap.expected_mm)]
    most = max(known, default=float("nan"))
    fills = [GapChoice(gap.marker, first, last, "best") for gap in some if gap.method]
    leave = [GapChoice(gap.marker, first, last, "open") for gap in some]
    fill = context.alternative(
        "fill", tracks, first, float("nan"), sum(one.cost for one in each), fills, mm=most, name="best"
    )
    left_open = context.alternative(
        "leave_open", tracks, first, float("nan"), context.limit_mm * sum(gap.length for gap in some), leave
    )
    return Problem(
        problem_id("gap", *(one.id for one in each[:1]), "and others"), "gap", tracks, first, last, first, worst.wrong,
        sum(one.at_stake for one in each), sum(one.cost for one in each), gaps_text(len(some), first, last, most),
        (fill, left_open) if fills else (left_open,), {"expected_mm": most},
    )  # fmt: skip


def _gap(context: Context, gap: FilledGap, first: int, last: int) -> Problem:
    """A gap; that it is filled by more than the usual limit off is as likely as errors about the one expected are."""
    expected = gap.expected_mm if np.isfinite(gap.expected_mm) else np.inf
    limit = context.limit_mm
    wrong = float(np.exp(-limit / max(expected, 1e-9))) if gap.method else 1.0
    tracks, n = (gap.marker,), gap.length
    open_cost = n * limit
    cost = n * min(expected, limit)

    def way(name: str, mm: float) -> Alternative:
        return context.alternative(
            "fill", tracks, first, float("nan"), n * mm, [GapChoice(gap.marker, first, last, name)], mm=mm, name=name
        )

    single = {name: mm for name, mm in gap.expected_of.items() if "+" not in name and np.isfinite(mm)}
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
