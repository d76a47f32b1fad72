"""Problems that paths show by themselves: changes of identity, spikes, loose pieces, ghosts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...data import MarkerTrajectory, Trajectories
from ...data.edits import Edit, is_named
from ...data.problems import Alternative, Problem, ProblemKind
from ...edit.probable_errors import Change, Ghost, Paths, Piece, Spike, changes, ghosts, pieces, places, spikes
from ...report.words.problems import problem_text
from .context import VERSIONS, Context

TOGETHER_S = 0.2
"""s within which changes of one path are one problem; chosen: what happens once is seen at several frames."""
GHOST_MM = 20.0
"""mm that a sample of no marker is off; chosen: what filling may be off at most."""


class Found(NamedTuple):
    """What a trial's paths show: places of the paths, and what may be wrong with them, changes seen once."""

    paths: Paths
    spikes: tuple[Spike, ...]
    changes: tuple[Change, ...]
    pieces: tuple[Piece, ...]
    ghosts: tuple[Ghost, ...]


def of_paths(context: Context) -> Iterator[Problem]:
    """All of them, not in order."""
    now = context.now
    found = _found(context.markers, now.rate, now.first_frame, tuple(_told(context)))
    for spike in found.spikes:
        yield _spike(context, spike)
    for change in found.changes:
        yield _change(context, found.paths, change)
    for piece in found.pieces:
        if not (is_named(context.name(piece.before)) and is_named(context.name(piece.after))):
            yield _piece(context, piece)
    for ghost in found.ghosts:
        yield _ghost(context, ghost)


@lru_cache(maxsize=VERSIONS)
def _found(
    some: tuple[MarkerTrajectory, ...], rate: float, first_frame: int, told: tuple[tuple[int, float, int], ...]
) -> Found:
    """Of these paths; verdicts, choices for gaps and events leave them the same records, and undo brings them back."""
    now = Trajectories(some, rate, first_frame)
    paths = Paths.of(now)
    found = tuple(spikes(paths))
    own = _once(_not_in_spikes(changes(paths, places(paths, told)), found, paths), paths)
    return Found(paths, found, tuple(own), tuple(pieces(paths)), tuple(ghosts(paths, now)))


def _told(context: Context) -> Iterator[tuple[int, float, int]]:
    """Places of the tracker's ambiguous decisions: path, frame, another path or −1, as far as nobody renamed them."""
    before, now = context.editing.trajectories, {id(path): k for k, path in enumerate(context.now)}
    for decision in context.editing.decisions:
        if decision.kind == "ghost":
            continue
        own = [now.get(id(before.paths[track]), -1) for track in decision.tracks if 0 <= track < len(before)]
        for k, path in enumerate(own):
            others = own[:k] + own[k + 1 :]
            if path >= 0:
                yield path, (decision.first + decision.last) / 2, others[0] if others else -1


def _not_in_spikes(some: Sequence[Change], found: Sequence[Spike], paths: Paths) -> list[Change]:
    """The changes that are not the edge of a spike that is likelier."""
    inside = {(s.path, f): s.wrong for s in found for f in range(s.first - 1, s.last + 1)}
    frames = [int(paths.frames[one.place.path][one.place.sample]) for one in some]
    return [
        one for one, f in zip(some, frames, strict=True) if inside.get((one.place.path, f), 0.0) < max(one.wrong, 0.5)
    ]


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
    mm = context.apart(p, q) if q >= 0 else change.keep_mm
    mm = mm if np.isfinite(mm) else change.keep_mm
    wrong = change.wrong
    no = context.verdict(kind, (p, q), f, g, right=False)
    keep = context.alternative(
        "keep", tracks, frame, 1 - wrong, wrong * n * mm, [context.verdict(kind, (p, q), f, g, right=True)],
        mm=change.keep_mm,
    )  # fmt: skip
    if q >= 0:
        other = context.alternative(
            "exchange", tracks, frame, wrong, (1 - wrong) * n * mm, [*_exchanged(context, paths, change, g), no],
            mm=change.exchange_mm,
        )  # fmt: skip
    else:
        other = context.alternative(
            "cut", tracks, frame, wrong, (1 - wrong) * n * mm, [*context.claim(p, context.marker(p, "b"), g), no]
        )
    words = problem_text(kind, tracks, first, last, change.keep_mm)
    values = {name: float(value) for name, value in zip(change.evidence._fields, change.evidence, strict=True)}
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


def _by_cost(*some: Alternative) -> tuple[Alternative, ...]:
    return tuple(sorted(some, key=lambda one: one.cost))
