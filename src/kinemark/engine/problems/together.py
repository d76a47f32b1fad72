"""Problems of a file that are looked at together: of one path with many steps, and of loose pieces one after another.

Other systems keep what they could not name in a few tracks, each many points one after another; and a marker that is
lost comes and goes several times. Each step is judged by itself, and is a problem by itself (`problems(one_by_one)`);
whoever looks at one sees the others in the same curves, and settles them in one act. Likewise stray images make many
short pieces without a name, each of which may be the one before: those that are rather none of them are one problem.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from ...data.edits import Claim, Edit, Erase, is_named
from ...data.problems import Alternative, Problem, problem_id
from ...report.words.problems import action_text, all_one_text, apart_text, chain_text, mend_text, together_text
from .context import Context

BESIDE_S = 1.0
"""s between steps of a marker that are looked at together, at most; chosen: what the curves show beside a problem.
Those of a track without a name are so however far apart they are."""
LIKELY = 0.5
"""Probability from which on a step is mended with the others of its path, by definition: below it is rather right, and
is looked at with others that are."""
CHAIN = 3
"""Joins of pieces one after another that are one problem, at least; chosen: two are soon looked at one by one."""


def together(context: Context, some: Sequence[Problem]) -> Iterator[Problem]:
    """These, with those that are worth a look and of one path and stretch, or of one chain of pieces, in one."""
    chains = list(_chains([one for one in some if one.asked and _is_loose(one)]))
    chained = {id(one) for chain in chains for one in chain}
    yield from (_chain(context, chain) for chain in chains)
    some = [one for one in some if id(one) not in chained]
    steps = [one for one in some if one.asked and _is_step(one)]
    mine = {id(one) for one in steps}
    yield from (one for one in some if id(one) not in mine)
    for (track, _), own in groupby(sorted(steps, key=_order), key=lambda one: _order(one)[:2]):
        beside = BESIDE_S * context.now.rate if is_named(track) else float("inf")
        for stretch in _stretches(list(own), beside):
            yield stretch[0] if len(stretch) == 1 else _one(context, stretch)


def _order(one: Problem) -> tuple[str, bool, int]:
    """Steps of one path, those that are rather right for themselves: nobody says so of them who mends the others."""
    return one.tracks[0], one.wrong < LIKELY, one.first


def _is_step(one: Problem) -> bool:
    """Whether it is about one path alone, which jumps."""
    return one.kind in ("join", "spike") and len(one.tracks) == 1


def _is_loose(one: Problem) -> bool:
    """Whether it is about two pieces without a name that are rather two markers."""
    two = one.kind == "join" and len(one.tracks) == 2
    return two and one.wrong < LIKELY and not any(map(is_named, one.tracks))


def _chains(some: Sequence[Problem]) -> Iterator[list[Problem]]:
    """Joins that have pieces in common, in the order of time."""
    chains = list[list[Problem]]()
    for one in sorted(some, key=lambda one: (one.first, one.last)):
        mine = [chain for chain in chains if any({*one.tracks} & {*other.tracks} for other in chain)]
        chains = [chain for chain in chains if chain not in mine]
        chains.append([*(other for chain in mine for other in chain), one])
    yield from (chain for chain in chains if len(chain) >= CHAIN)


def _chain(context: Context, some: Sequence[Problem]) -> Problem:
    """Joins of loose pieces in one: none of them is one marker with another, or all are."""
    worst = max(some, key=lambda one: one.cost)
    tracks = tuple(dict.fromkeys(name for one in some for name in one.tracks))
    first, last = min(one.first for one in some), max(one.last for one in some)
    wrong = max(one.wrong for one in some)
    kept, joined = [_way(one, keeps=True) for one in some], [_way(one, keeps=False) for one in some]
    name = next(edit.name for edit in joined[0].edits if isinstance(edit, Claim))
    claims = [said for of in tracks for said in context.claim(context.now.names.index(of), name, again=True)]
    verdicts = [edit for way in joined for edit in way.edits if not isinstance(edit, Claim)]
    apart = tuple(edit for way in kept for edit in way.edits)
    ways = (
        Alternative("keep", apart_text(len(tracks)), 1 - wrong, _cost(kept), edits=apart),
        Alternative("join", all_one_text(len(tracks)), min(one.wrong for one in some), _cost(joined),
                    edits=(*claims, *verdicts)),
    )  # fmt: skip
    return replace(
        worst, id=problem_id("join", *(one.id for one in some)), tracks=tracks, first=first, last=last, wrong=wrong,
        at_stake=sum(one.at_stake for one in some), cost=sum(one.cost for one in some),
        words=chain_text(len(tracks), first, last), alternatives=tuple(sorted(ways, key=lambda way: way.cost)),
        values=_values(some),
    )  # fmt: skip


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
    """Several in one: all of them mended, or right as they are."""
    worst, track = max(some, key=lambda one: one.cost), some[0].tracks[0]
    first, last, wrong = some[0].first, max(one.last for one in some), max(one.wrong for one in some)
    mended, kept = ([_way(one, keeps=keeps) for one in some] for keeps in (False, True))
    cuts = [one.frame for one, way in zip(some, mended, strict=True) if way.action == "cut"]
    erased = sum(one.at_stake for one, way in zip(some, mended, strict=True) if way.action == "erase")
    edits, verdicts = _mending(context, track, mended, cuts), tuple(edit for way in kept for edit in way.edits)
    right = action_text("keep", (track,), first, float("nan"))
    ways = (
        Alternative("mend", mend_text(track, erased, cuts), min(one.wrong for one in some), _cost(mended), edits=edits),
        Alternative("keep", right, 1 - wrong, _cost(kept), edits=verdicts),
    )
    return replace(
        worst, id=problem_id("join", *(one.id for one in some)), kind="join", first=first, last=last, wrong=wrong,
        at_stake=sum(one.at_stake for one in some), cost=sum(one.cost for one in some),
        words=together_text(track, first, last, len(some)), alternatives=tuple(sorted(ways, key=lambda way: way.cost)),
        values=_values(some),
    )  # fmt: skip


def _values(some: Sequence[Problem]) -> dict[str, float]:
    """How many places there are, and errors that are expected in them."""
    return {"places": float(len(some)), "errors": sum(one.wrong for one in some)}


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
