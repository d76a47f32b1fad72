"""What happened to all markers of a file at once, one problem a cause: lost and repeated frames, another world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import get_args

import numpy as np

from ...data.edits import Edit
from ...data.problems import Problem
from ...edit.probable_errors import Break, BreakKind, Paths
from ...report.words.problems import break_text, breaks_text
from .context import Context

VERDICTS = 5
"""Paths that witness a verdict, at most; chosen: one that finds its place is enough, and each costs witnesses."""
LIKELY, SEVERAL = 0.5, 3
"""Probability of a break, and how many at most are looked at one by one; chosen: more are how the system works."""
INSTEAD = {
    "lost": "export it again without loss, or use its parts apart",
    "moved": "process it again with one calibration, or use its parts apart",
}
"""What a laboratory can do where no edit mends it."""


def of_breaks(context: Context, paths: Paths, some: Sequence[Break]) -> Iterator[Problem]:
    """Those of a trial, `paths` as it is."""
    for group in _groups(some):
        who = np.flatnonzero(paths.seen[:, group[0].before]).tolist()
        if who:
            yield _problem(context, group, who)


def _groups(some: Sequence[Break]) -> Iterator[Sequence[Break]]:
    """What has one cause: a system that loses or repeats frames does so all the time."""
    for kind in get_args(BreakKind):
        mine = [one for one in some if one.kind == kind]
        likely = [one for one in mine if one.wrong >= LIKELY]
        often = kind in ("lost", "repeated") and len(likely) > SEVERAL
        if often:
            yield likely
        yield from ((one,) for one in mine if not (often and one in likely))


def _problem(context: Context, some: Sequence[Break], who: Sequence[int]) -> Problem:
    """Of these paths."""
    one, end, tracks = some[0], some[-1], tuple(context.name(p) for p in who)
    first, last = one.before + context.start, end.after + context.start
    mends, mm = one.kind in ("repeated", "shaken"), max(each.mm for each in some)
    inside = [(each.before + 1, each.after - 1) for each in some]
    rest = min(one.before + 1, context.now.n_frames - end.after) if len(some) == 1 else context.now.n_frames
    n = len(who) * (sum(b - a + 1 for a, b in inside) if mends else rest)
    wrong = max(each.wrong for each in some)
    cost, span = wrong * n * mm, (who[:VERDICTS], one.before, end.after)
    keep = context.alternative(
        "keep", tracks, last, 1 - wrong, cost, [context.verdict(one.kind, *span, right=True)], mm=mm
    )
    no = context.verdict(one.kind, *span, right=False)
    edits: list[Edit] = [edit for p in who for a, b in inside for edit in context.erase(p, a, b)] if mends else []
    gone = context.alternative(
        "erase" if mends else "note", tracks, last, wrong, (1 - wrong) * n * mm, [*edits, no],
        name=INSTEAD.get(one.kind, ""),
    )  # fmt: skip
    degrees = one.motion.degrees if one.motion is not None else 0.0
    words = break_text(one.kind, one.before + context.start, one.after + context.start, one.frames, mm, degrees)
    if len(some) > 1:
        words = breaks_text(one.kind, first, one.after + context.start, len(some), sum(map(_frames, some)))
    return Problem(
        context.id(one.kind, who[0], one.before), one.kind, tracks, first + mends, last - mends,
        (one.before + 1 if mends else one.after) + context.start, wrong, n, cost, words,
        tuple(sorted((keep, gone), key=lambda way: way.cost)),
        one.evidence._asdict() | {"frames": float(sum(each.frames for each in some)), "places": float(len(some))},
    )  # fmt: skip


def _frames(one: Break) -> int:
    """That are lost, or repeated."""
    return one.frames if one.kind == "lost" else one.after - one.before - 1
