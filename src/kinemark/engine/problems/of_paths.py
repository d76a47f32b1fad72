"""Problems that paths show by themselves: changes of identity, spikes, loose pieces, ghosts, unmeasured samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...data import MarkerTrajectory, Trajectories
from ...data.edits import Edit, is_named
from ...data.problems import Alternative, Problem, ProblemKind
from ...edit.probable_errors import (
    Change,
    Filling,
    Ghost,
    Leap,
    Paths,
    Piece,
    Spike,
    Told,
    breaks,
    changes,
    fillings,
    ghosts,
    leaps,
    pieces,
    places,
    spikes,
    unbroken,
)
from ...edit.probable_errors.paths import UNTOLD_MM
from ...report.words.problems import problem_text, untold_text
from .context import VERSIONS, Context
from .found import LIKELY, Found, apart_from, by_trial, likeliest, not_exchanged, numbered
from .of_breaks import of_breaks

TOGETHER_S = 0.2
"""s within which changes of one path are one problem; chosen: what happens once is seen at several frames."""
LEAST_OFF_MM = 1.0
"""mm that a sample which nobody measured is off at least; chosen: nothing tells less where it is."""
GHOST_MM = 20.0
"""mm that a sample of no marker is off; chosen: what filling may be off at most."""


def of_paths(context: Context) -> Iterator[Problem]:
    """All of them, not in order."""
    now = context.now
    found = _found(context.markers, now.rate, now.first_frame, tuple(_told(context)))
    for spike in found.spikes:
        yield _spike(context, spike)
    for leap in found.leaps:
        yield _leap(context, leap)
    for change in found.changes:
        yield _change(context, found.paths, change)
    for piece in found.pieces:
        yield _piece(context, piece)
    for ghost in found.ghosts:
        yield _ghost(context, ghost)
    for filling in found.fillings:
        yield _filling(context, filling)
    yield from of_breaks(context, found.as_it_is, found.breaks)


@lru_cache(maxsize=VERSIONS)
def _found(some: tuple[MarkerTrajectory, ...], rate: float, first_frame: int, told: tuple[Told, ...]) -> Found:
    """Of these paths; verdicts, choices for gaps and events leave them the same records, and undo brings them back."""
    now = Trajectories(some, rate, first_frame)
    as_it_is = paths = Paths.of(now)
    broken = tuple(breaks(paths))
    likely = [one for one in broken if one.wrong >= LIKELY]
    if not likely:
        return _of_each(now, paths, told)._replace(breaks=broken)
    now, frame = unbroken(paths, now.names, likely)
    found = numbered(_of_each(now, Paths.of(now), told), frame)
    return apart_from(found, likely, TOGETHER_S * rate)._replace(breaks=broken, as_it_is=as_it_is)


def _of_each(now: Trajectories, paths: Paths, told: tuple[Told, ...]) -> Found:
    """What each path shows of its own."""
    as_it_is, made = paths, fillings(paths)
    if any(one.wrong >= LIKELY for one in made):
        now = _measured(now, made)
        paths = Paths.of(now)
    own = changes(paths, places(paths, told))
    off, gone = _each_once(spikes(paths), _not_exchanged(leaps(paths), own))
    own = _once(_not_in_others(own, off, gone, paths), paths)
    loose = [one for one in pieces(paths) if not all(is_named(now.names[p]) for p in (one.before, one.after))]
    loose = not_exchanged(loose, own, TOGETHER_S * paths.rate)
    found = Found(paths, off, gone, tuple(own), tuple(loose), tuple(ghosts(paths, now)), tuple(made), (), as_it_is)
    near = TOGETHER_S * paths.rate
    return likeliest(by_trial(likeliest(found, near)), near)  # no other of a trial is evidence twice


def _measured(now: Trajectories, made: Sequence[Filling]) -> Trajectories:
    """Without the samples that probably nobody measured: they would say how paths go on, and are no evidence."""
    some = list(now.paths)
    for p in {one.path for one in made if one.wrong >= LIKELY}:
        xyz = some[p].xyz.copy()
        for one in made:
            if one.path == p and one.wrong >= LIKELY:
                xyz[one.first : one.last + 1] = np.nan
        some[p] = MarkerTrajectory.measured(some[p].name, xyz)
    return replace(now, paths=tuple(some))


def _told(context: Context) -> Iterator[Told]:
    """Places of the tracker's ambiguous decisions, as far as nobody renamed the paths."""
    before, now = context.editing.trajectories, {id(path): k for k, path in enumerate(context.now)}
    for decision in context.editing.decisions:
        if decision.kind == "ghost":
            continue
        own = [now.get(id(before.paths[track]), -1) for track in decision.tracks if 0 <= track < len(before)]
        for k, path in enumerate(own):
            others = own[:k] + own[k + 1 :]
            if path >= 0:
                near = decision.reason == "came_near"
                yield Told(path, decision.first, decision.last, others[0] if others else -1, near)


def _not_exchanged(gone: Sequence[Leap], some: Sequence[Change]) -> list[Leap]:
    """The leaps that are no exchange of two paths, which is as likely and says more."""
    known = [
        (path, one.place.middle, one.wrong) for one in some if one.wrong >= LIKELY and one.partner.path >= 0
        for path in (one.place.path, one.partner.path)
    ]  # fmt: skip

    def said(leap: Leap) -> bool:
        return any(leap.path == p and leap.before <= f <= leap.after and leap.wrong <= wrong for p, f, wrong in known)

    return [one for one in gone if not said(one)]


def _each_once(off: Sequence[Spike], gone: Sequence[Leap]) -> tuple[tuple[Spike, ...], tuple[Leap, ...]]:
    """Without the leaps into spikes or out of them, which make those as likely, and the spikes that leaps say."""
    edges = [[leap for leap in gone if _edge_of(spike, leap)] for spike in off]
    surer = [
        spike._replace(wrong=max([spike.wrong, *(leap.wrong for leap in edge)]))
        for spike, edge in zip(off, edges, strict=True)
    ]
    rest = tuple(leap for leap in gone if not any(leap in edge for edge in edges))
    return tuple(one for one in surer if not _said(rest, one.path, one.first, one.last, one.wrong)), rest


def _edge_of(spike: Spike, leap: Leap) -> bool:
    """Whether a leap goes into a likely spike or out of it, or there and back as one does."""
    within = spike.first - 1 <= leap.before and leap.after <= spike.last + 1
    return spike.path == leap.path and within and (spike.wrong >= LIKELY or leap.back)


def _said(gone: Sequence[Leap], path: int, first: int, last: int, wrong: float) -> bool:
    """Whether a leap that is as likely says what is seen in these frames."""
    return any(one.path == path and one.before <= last and first <= one.after and wrong <= one.wrong for one in gone)


def _not_in_others(some: Sequence[Change], off: Sequence[Spike], gone: Sequence[Leap], paths: Paths) -> list[Change]:
    """The changes that are not the edge of a spike that is likelier, and that leaps do not say: where there is no
    partner, a likely leap says as much.
    """
    inside = {(s.path, f): s.wrong for s in off for f in range(s.first - 1, s.last + 1)}
    kept = []
    for one in some:
        path, (f, g) = one.place.path, paths.frames[one.place.path][one.place.sample :][:2].tolist()
        edge = inside.get((path, f), 0.0) >= max(one.wrong, LIKELY)
        least = one.wrong if one.partner.path >= 0 else min(one.wrong, LIKELY)
        if not edge and not _said(gone, path, f + 1, g - 1, least):
            kept.append(one)
    return kept


def _once(some: Sequence[Change], paths: Paths) -> list[Change]:
    """The likeliest of changes that are about the same paths at one time."""
    kept: list[Change] = []
    of: dict[int, list[Change]] = {}
    for one in sorted(some, key=lambda change: -change.wrong):
        mine = one.place.path
        if any(abs(k.place.middle - one.place.middle) <= TOGETHER_S * paths.rate for k in of.get(mine, ())):
            continue
        kept.append(one)
        for path in {mine, one.partner.path} - {-1}:
            of.setdefault(path, []).append(one)
    return kept


def _change(context: Context, paths: Paths, change: Change) -> Problem:
    """A place at which a path may go on as another marker."""
    p, q, i = change.place.path, change.partner.path, change.place.sample
    f, g = int(paths.frames[p][i]), int(paths.frames[p][i + 1])
    tracks = tuple(context.name(path) for path in (p, q) if path >= 0)
    kind: ProblemKind = "swap" if q >= 0 else "join"
    first, last, frame = f + context.start, g + context.start, g + context.start
    halves = [min(int((paths.frames[k] <= f).sum()), int((paths.frames[k] >= g).sum())) for k in (p, q) if k >= 0]
    n = max(sum(halves), 1)
    told = change.evidence.own_sd < np.log(UNTOLD_MM)
    off = change.keep_mm if told else min(change.keep_mm, UNTOLD_MM)
    mm = context.apart(p, q) if q >= 0 else off
    mm = mm if np.isfinite(mm) else off
    wrong = change.wrong
    no = context.verdict(kind, (p, q), f, g, right=False)
    keep = context.alternative(
        "keep", tracks, frame, 1 - wrong, wrong * n * mm, [context.verdict(kind, (p, q), f, g, right=True)],
        mm=change.keep_mm if told else float("nan"),
    )  # fmt: skip
    edits = _exchanged(context, paths, change, g) if q >= 0 else context.claim(p, context.marker(p, g), g)
    other = context.alternative(
        "exchange" if q >= 0 else "cut", tracks, frame, wrong, (1 - wrong) * n * mm, [*edits, no],
        mm=change.exchange_mm if told and q >= 0 else float("nan"),
    )  # fmt: skip
    words = problem_text(kind, tracks, first, last, change.keep_mm) if told else untold_text(kind, tracks, first, last)
    values = {name: float(value) for name, value in zip(change.evidence._fields, change.evidence, strict=True)}
    values |= {} if told else {"assumed_mm": off}
    return Problem(
        context.id(kind, p, change.place.middle), kind, tracks, first, last, frame, wrong, n, wrong * n * mm, words,
        _by_cost(keep, other), values,
    )  # fmt: skip


def _exchanged(context: Context, paths: Paths, change: Change, g: int) -> Iterator[Edit]:
    """From frame g (from 0) on each has the other's name; tracks without get one of their own."""
    p, (q, j) = change.place.path, change.partner
    mine, theirs = context.marker(p), context.marker(q)
    yield from context.claim(p, mine)
    yield from context.claim(q, theirs)
    yield from context.claim(p, theirs, g)
    if j + 1 < len(paths.frames[q]):
        yield from context.claim(q, mine, int(paths.frames[q][j + 1]))


def _spike(context: Context, spike: Spike) -> Problem:
    """Samples that stand off."""
    tracks, n = (context.name(spike.path),), spike.last - spike.first + 1
    first, last = spike.first + context.start, spike.last + context.start
    wrong, cost = spike.wrong, spike.wrong * n * spike.keep_mm
    span = (spike.path,), spike.first, spike.last
    keep = context.alternative(
        "keep", tracks, first, 1 - wrong, cost, [context.verdict("spike", *span, right=True)], mm=spike.keep_mm
    )
    erase = context.alternative(
        "erase", tracks, first, wrong, (1 - wrong) * n * spike.erase_mm,
        [*context.erase(spike.path, spike.first, spike.last), context.verdict("spike", *span, right=False)],
        mm=spike.erase_mm,
    )  # fmt: skip
    return Problem(
        context.id("spike", spike.path, spike.first), "spike", tracks, first, last, first, wrong, n, cost,
        problem_text("spike", tracks, first, last, spike.keep_mm), _by_cost(keep, erase), spike.evidence._asdict(),
    )  # fmt: skip


def _leap(context: Context, leap: Leap) -> Problem:
    """A path that is elsewhere some frames later."""
    p, f, g, wrong = leap.path, leap.before, leap.after, leap.wrong
    tracks, own = (context.name(p),), context.samples(p)
    first, last = f + context.start, g + context.start
    inside, sides = int(((own > f) & (own < g)).sum()), min(int((own <= f).sum()), int((own >= g).sum()))
    n = max(inside if leap.back else sides, 1)
    keep = context.alternative(
        "keep", tracks, last, 1 - wrong, wrong * n * leap.mm, [context.verdict("join", (p,), f, g, right=True)],
        mm=leap.mm,
    )  # fmt: skip
    between = context.erase(p, f + 1, g - 1) if g > f + 1 else ()
    rest = () if leap.back else context.claim(p, context.marker(p, g), g)
    gone = context.alternative(
        "erase" if leap.back else "cut", tracks, last, wrong, (1 - wrong) * n * leap.mm,
        [*between, *rest, context.verdict("join", (p,), f, g, right=False)],
    )  # fmt: skip
    return Problem(
        context.id("join", p, (f + g) / 2), "join", tracks, first, last, last, wrong, n, wrong * n * leap.mm,
        problem_text("join", tracks, first, last, leap.mm), _by_cost(keep, gone), leap.evidence._asdict(),
    )  # fmt: skip


def _piece(context: Context, piece: Piece) -> Problem:
    """Two paths that may be one marker."""
    p, q = piece.before, piece.after
    tracks = context.name(p), context.name(q)
    low, high = sorted((piece.last, piece.first))
    first, last = low + context.start, high + context.start
    n = min(len(context.samples(p)), len(context.samples(q)))
    wrong, mm = piece.wrong, piece.join_mm
    keep = context.alternative(
        "keep", tracks, last, 1 - wrong, wrong * n * GHOST_MM,
        [context.verdict("join", (p, q), low, high, right=True)],
    )  # fmt: skip
    name = context.marker(q) if is_named(tracks[1]) else context.marker(p)
    both = [claim for path in (p, q) for claim in context.claim(path, name, again=True)]
    join = context.alternative(
        "join", tracks, last, wrong, (1 - wrong) * n * GHOST_MM,
        [*both, context.verdict("join", (p, q), low, high, right=False)], mm=mm,
    )  # fmt: skip
    return Problem(
        context.id("join", p, piece.last), "join", tracks, first, last, last, wrong, n, wrong * n * GHOST_MM,
        problem_text("join", tracks, first, last, mm), _by_cost(keep, join), piece.evidence._asdict(),
    )  # fmt: skip


def _ghost(context: Context, ghost: Ghost) -> Problem:
    """A path that may be no marker."""
    tracks, own = (context.name(ghost.path),), context.samples(ghost.path)
    first, last, wrong, n = ghost.first + context.start, ghost.last + context.start, ghost.wrong, len(own)
    path = context.now.paths[ghost.path]
    images = int((path.detection >= 0).sum()) if path.detection.shape[1] else None
    span = (ghost.path,), ghost.first, ghost.last
    keep = context.alternative(
        "keep", tracks, first, 1 - wrong, wrong * n * GHOST_MM, [context.verdict("ghost", *span, right=True)],
        images=images,
    )  # fmt: skip
    gone = context.alternative(
        "no_marker", tracks, first, wrong, (1 - wrong) * n * GHOST_MM,
        [*context.claim(ghost.path, None), context.verdict("ghost", *span, right=False)],
        images=None if images is None else 0,
    )  # fmt: skip
    return Problem(
        context.id("ghost", ghost.path, ghost.first), "ghost", tracks, first, last, (first + last) // 2, wrong, n,
        wrong * n * GHOST_MM, problem_text("ghost", tracks, first, last, float("nan")), _by_cost(keep, gone),
        ghost.evidence._asdict(),
    )  # fmt: skip


def _filling(context: Context, filling: Filling) -> Problem:
    """Samples that nobody measured."""
    tracks, wrong, n = (context.name(filling.path),), filling.wrong, filling.last - filling.first + 1
    first, last = filling.first + context.start, filling.last + context.start
    span, cost = ((filling.path,), filling.first, filling.last), wrong * n * max(filling.mm, LEAST_OFF_MM)
    keep = context.alternative("keep", tracks, first, 1 - wrong, cost, [context.verdict("filled", *span, right=True)])
    gone = context.alternative(
        "erase", tracks, first, wrong, (1 - wrong) * n * max(filling.mm, LEAST_OFF_MM),
        [*context.erase(filling.path, filling.first, filling.last), context.verdict("filled", *span, right=False)],
    )  # fmt: skip
    return Problem(
        context.id("filled", filling.path, filling.first), "filled", tracks, first, last, first, wrong, n, cost,
        problem_text("filled", tracks, first, last, filling.mm), _by_cost(keep, gone), filling.evidence._asdict(),
    )  # fmt: skip


def _by_cost(*some: Alternative) -> tuple[Alternative, ...]:
    return tuple(sorted(some, key=lambda one: one.cost))
