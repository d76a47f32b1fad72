"""Two markers that are exchanged for some frames, too few for two exchanges: both seem to jump away and back.

Each of them is a spike by itself, and who takes both away loses samples that are right. With x the place of a path and
f the first of the frames, motion leads from before to 2 x(f − 1) − x(f − 2); likewise back from after them. The markers
are exchanged where the samples of each are less than half as far from where the other is led, in all, as from where
their own path is (1).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ...data.array_types import Floats
from ...data.edits import Edit, Verdict
from ...data.problems import Alternative, Problem, problem_id
from ...report.words.problems import action_text, exchange_text, exchanged_text
from .context import Context

LESS = 0.5
"""Times, of (1); chosen: markers are farther apart than motion is off from one frame to the next."""


def exchanged_back(context: Context, some: Sequence[Problem]) -> Iterator[Problem]:
    """These, with the spikes of two markers that are exchanged meanwhile, and their change there or back, in one."""
    done = set[int]()
    spikes = [one for one in some if one.asked and one.kind == "spike"]
    for one, other in combinations(spikes, 2):
        at_once = (one.first, one.last) == (other.first, other.last)
        if at_once and not {id(one), id(other)} & done and _are_exchanged(context, one, other):
            edges = [swap for swap in some if swap.kind == "swap" and _is_edge(swap, one, other)]
            done |= {id(part) for part in (one, other, *edges)}
            yield _in_one(context, (one, other), edges)
    yield from (one for one in some if id(one) not in done)


def _is_edge(swap: Problem, one: Problem, other: Problem) -> bool:
    """Whether an exchange is the one with which the spikes of two markers begin or end."""
    return {*swap.tracks} == {*one.tracks, *other.tracks} and one.first - 1 <= swap.first <= swap.last <= one.last + 1


def _are_exchanged(context: Context, one: Problem, other: Problem) -> bool:
    """Whether the samples of each go on what is beside those of the other (1)."""
    first, last = one.first - context.start, one.last - context.start
    if first < 2 or last + 2 >= context.now.n_frames:
        return False
    both = [context.now[part.tracks[0]].xyz for part in (one, other)]
    led = np.array([[2 * x[first - 1] - x[first - 2], 2 * x[last + 1] - x[last + 2]] for x in both])
    own = np.array([x[[first, last]] for x in both])
    return _off(own, led[::-1]) < LESS * _off(own, led)  # not where a sample is missing


def _off(samples: Floats, led: Floats) -> float:
    """mm in all between samples and where motion leads, each (2, 2, 3)."""
    return float(np.linalg.norm(samples - led, axis=-1).sum())


def _in_one(context: Context, both: Sequence[Problem], edges: Sequence[Problem]) -> Problem:
    """Two spikes in one: the markers are exchanged in these frames; or both stand off, or are right."""
    one, tracks = both[0], tuple(name for part in both for name in part.tracks)
    keep, erase = ([way for part in both for way in part.alternatives if way.action == a] for a in ("keep", "erase"))
    kept = [*keep, *(way for swap in edges for way in swap.alternatives if way.action == "keep")]
    wrong, n = max(part.wrong for part in (*both, *edges)), sum(part.at_stake for part in both)
    cost = sum(part.at_stake * way.jump_mm for part, way in zip(both, keep, strict=True))
    verdicts = [edit for way in erase for edit in way.edits if isinstance(edit, Verdict)]
    ways = (
        Alternative("exchange", exchange_text(tracks, one.first, one.last), wrong, (1 - wrong) * cost,
                    edits=(*_exchange(context, tracks, one), *verdicts)),
        Alternative("erase", action_text("erase", tracks, one.first, float("nan")), 0.0, n * context.limit_mm,
                    edits=_all(erase)),
        Alternative("keep", action_text("keep", tracks, one.first, float("nan")), 1 - wrong, wrong * cost,
                    edits=_all(kept)),
    )  # fmt: skip
    return replace(
        one, id=problem_id("swap", *(part.id for part in both)), kind="swap", tracks=tracks, wrong=wrong, at_stake=n,
        cost=wrong * cost, words=exchanged_text(tracks, one.first, one.last),
        alternatives=tuple(sorted(ways, key=lambda way: way.cost)), values={"errors": sum(part.wrong for part in both)},
    )  # fmt: skip


def _exchange(context: Context, tracks: Sequence[str], one: Problem) -> Iterator[Edit]:
    """In these frames each has the other's name; tracks without get one of their own."""
    p, q = (context.now.names.index(track) for track in tracks)
    mine, theirs = context.marker(p), context.marker(q)
    first, last = one.first - context.start, one.last - context.start
    yield from context.claim(p, mine)
    yield from context.claim(q, theirs)
    yield from context.claim(p, theirs, first, last)
    yield from context.claim(q, mine, first, last)


def _all(ways: Sequence[Alternative]) -> tuple[Edit, ...]:
    return tuple(edit for way in ways for edit in way.edits)
