"""Problems of one path of a file that are looked at together: a stretch with many steps is one thing to look at.

Other systems keep what they could not name in a few tracks, each many points one after another; and a marker that is
lost comes and goes several times. Each step is judged by itself, and is a problem by itself (`problems(one_by_one)`);
whoever looks at one sees the others in the same curves, and settles them in one act.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from ...data.edits import Claim, Edit, Erase, is_named
from ...data.problems import Alternative, Problem, problem_id
from ...report.words.problems import action_text, mend_text, together_text
from .context import Context

BESIDE_S = 1.0
"""s between steps of a marker that are looked at together, at most; chosen: what the curves show beside a problem.
Those of a track without a name are so however far apart they are."""
LIKELY = 0.5
"""Probability from which on a step is mended with the others of its path, by definition: below it is rather right."""


def together(context: Context, some: Sequence[Problem]) -> Iterator[Problem]:
    """These, with those that are worth a look and of one path and stretch in one."""
    steps = [one for one in some if one.asked and _is_step(one)]
    mine = {id(one) for one in steps}
    yield from (one for one in some if id(one) not in mine)
    for track, own in groupby(sorted(steps, key=lambda one: (one.tracks, one.first)), key=lambda one: one.tracks[0]):
        beside = BESIDE_S * context.now.rate if is_named(track) else float("inf")
        for stretch in _stretches(list(own), beside):
            yield stretch[0] if len(stretch) == 1 else _one(context, stretch)


def _is_step(one: Problem) -> bool:
    """Whether it is about one path alone, which jumps."""
    return one.kind in ("join", "spike") and len(one.tracks) == 1


def _stretches(some: Sequence[Problem], beside: float) -> Iterator[list[Problem]]:
    """Problems of one path in the order of time, apart where nothing is for long."""
    stretch, last = [some[0]], some[0].last
    for one in some[1:]:
        if one.first - last > beside:
            yield stretch
            stretch = []
        stretch.append(one)
        last = max(last, one.last) if len(stretch) > 1 else one.last
    yield stretch


def _one(context: Context, some: Sequence[Problem]) -> Problem:
    """Several in one: mended as each is likeliest, or right as they are."""
    worst, track = max(some, key=lambda one: one.cost), some[0].tracks[0]
    first, last, wrong = some[0].first, max(one.last for one in some), max(one.wrong for one in some)
    least = LIKELY if wrong >= LIKELY else 0.0  # where none is likely, to mend is to mend all
    mended, kept = [_way(one, keeps=one.wrong < least) for one in some], [_way(one, keeps=True) for one in some]
    cuts = [one.frame for one, way in zip(some, mended, strict=True) if way.action == "cut"]
    erased = sum(one.at_stake for one, way in zip(some, mended, strict=True) if way.action == "erase")
    edits, verdicts = _mending(context, track, mended, cuts), tuple(edit for way in kept for edit in way.edits)
    right = action_text("keep", (track,), first, float("nan"))
    ways = (
        Alternative("mend", mend_text(track, erased, cuts), wrong, _cost(mended), edits=edits),
        Alternative("keep", right, 1 - wrong, _cost(kept), edits=verdicts),
    )
    return replace(
        worst, id=problem_id("join", *(one.id for one in some)), kind="join", first=first, last=last, wrong=wrong,
        at_stake=sum(one.at_stake for one in some), cost=sum(one.cost for one in some),
        words=together_text(track, first, last, len(some)), alternatives=tuple(sorted(ways, key=lambda way: way.cost)),
        values={"places": float(len(some))},
    )  # fmt: skip


def _way(one: Problem, *, keeps: bool) -> Alternative:
    return next(way for way in one.alternatives if (way.action == "keep") == keeps)


def _cost(some: Sequence[Alternative]) -> float:
    return sum(way.cost for way in some)


def _mending(context: Context, track: str, some: Sequence[Alternative], cuts: Sequence[int]) -> tuple[Edit, ...]:
    """What all say, in the order of time. A piece ends where the next begins, and what is erased in it is its."""
    said, of, path = list[Edit](), track, context.now.names.index(track)
    pieces = iter(zip(cuts, [*(frame - 1 - context.start for frame in cuts[1:]), None], strict=True))
    for way in some:
        begins = next((edit.name for edit in way.edits if isinstance(edit, Claim) and edit.name), "")
        for edit in way.edits:
            if isinstance(edit, Claim) and edit.name:
                first, last = next(pieces)
                said += context.claim(path, edit.name, first - context.start, last)
            else:
                said.append(replace(edit, marker=of) if isinstance(edit, Erase) else edit)
        of = begins or of
    return tuple(said)
