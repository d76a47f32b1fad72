"""What happened to all markers of a file at once, one problem a cause: lost and repeated frames, another world."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...data.edits import Edit
from ...data.problems import Problem
from ...edit.probable_errors import Break, Paths
from ...report.words.problems import break_text
from .context import Context

VERDICTS = 5
"""Paths that witness a verdict, at most; chosen: one that finds its place is enough, and each costs witnesses."""
INSTEAD = {
    "lost": "export the recording again without loss, or use what is before and after by itself",
    "moved": "process the recording again with one calibration, or use what is before and after by itself",
}
"""What a laboratory can do where no edit mends it."""


def of_breaks(context: Context, paths: Paths, some: Sequence[Break]) -> Iterator[Problem]:
    """Those of a trial, `paths` as it is."""
    for one in some:
        who = [
            p
            for p, seen in enumerate(paths.seen)
            if seen[one.before] and (seen[one.after :].any() or one.kind == "repeated")
        ]
        if who:
            yield _problem(context, one, who)


def _problem(context: Context, one: Break, who: Sequence[int]) -> Problem:
    """Of these paths."""
    tracks, inside = tuple(context.name(p) for p in who), (one.before + 1, one.after - 1)
    first, last = one.before + context.start, one.after + context.start
    mends = one.kind in ("repeated", "shaken")
    n = len(who) * (inside[1] - inside[0] + 1 if mends else min(one.before + 1, context.now.n_frames - one.after))
    wrong, cost, span = one.wrong, one.wrong * n * one.mm, (who[:VERDICTS], one.before, one.after)
    keep = context.alternative(
        "keep", tracks, last, 1 - wrong, cost, [context.verdict(one.kind, *span, right=True)], mm=one.mm
    )
    no = context.verdict(one.kind, *span, right=False)
    edits: list[Edit] = [edit for p in who for edit in context.erase(p, *inside)] if mends else []
    gone = context.alternative(
        "erase" if mends else "note", tracks, last, wrong, (1 - wrong) * n * one.mm, [*edits, no],
        name=INSTEAD.get(one.kind, ""),
    )  # fmt: skip
    degrees = one.motion.degrees if one.motion is not None else 0.0
    return Problem(
        context.id(one.kind, who[0], one.before), one.kind, tracks, first + mends, last - mends, last, wrong, n, cost,
        break_text(one.kind, first, last, one.frames, one.mm, degrees),
        tuple(sorted((keep, gone), key=lambda way: way.cost)), one.evidence._asdict() | {"frames": float(one.frames)},
    )  # fmt: skip
