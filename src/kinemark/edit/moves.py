"""Edits of a file whose places were moved as a whole: written again with another origin, or with other axes.

A file without images has nothing but places to find an edit by, and in another world all of its edits would be lost.
So where edits find nothing, a move x' = R x + t is looked for that lays the witnesses of one edit upon a path within
CLOSE_MM (1), and by which most of the others find their samples again (2). These go with it: their witnesses, and a
place that was put. Where there is no such move nothing is carried over, and edits are what they would be without.

Where all markers move alike, as on a sledge, the path of any is that of any other, moved: a move by markers of the same
name goes first then, and one beside which another finds as much elsewhere is none (3). And somebody who stands still
in two recordings stands so by some move: samples are the same only where the witnesses also sway alike (4).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ..data import Trajectories
from ..data.array_types import Floats, Ints
from ..data.edits import Claim, Edit, Put, Stretch, Verdict
from ..geometry import rigid_align
from .claims import ENOUGH
from .values import Footage
from .votes import NEAR_MM, KnownVotes, known_votes, votes

CLOSE_MM = 1.0
"""mm, RMS, of (1); chosen: a file that was moved has the same samples, rounded otherwise."""
FEWEST = 4
"""Witnesses that tell of a move; by definition: three always lie upon three others nearly enough."""
SWAY = 0.25
"""Times how far witnesses are from the middle of their marker, the median, that they may be off, of (4); chosen: those
of another recording are off by more than once that."""
ROUNDED_MM = 0.02
"""mm that they may be off however still they are; chosen: twice what files are rounded to that give 0.01 mm."""
MOST_TRIED = 24
"""Moves that are tried; chosen: the first is mostly right, as few paths can be laid upon each other so closely."""
TRIES = 60
"""Moves by three places each, of which the one that most others agree with is taken; chosen: where a third of these are
another marker's, one of four tries has none of them."""


class Move(NamedTuple):
    """x' = R x + t, mm."""

    R: Floats
    t: Floats

    def __call__(self, xyz: Any) -> Floats:
        """Places (N, 3) mm, moved."""
        return np.asarray(np.asarray(xyz) @ self.R.T + self.t)


class Tried(NamedTuple):
    """A move, and whether it lays samples on those of markers that are called so now."""

    of: Move
    by_name: bool


def carried_over(edits: Sequence[Edit], given: Trajectories, of: Footage) -> list[Edit]:
    """The edits, moved where they find nothing and most of those that do not find their samples by one move.

    Args:
        edits: in their order. given: before all of them. of: what is behind the samples; with images nothing is moved.
    """
    if of.detections is not None:
        return list(edits)
    known = known_votes(given, None, of.world)
    lost = tuple(k for k, edit in enumerate(edits) if not _placed(edit, known))
    if not lost:
        return list(edits)
    key = tuple(id(edits[k]) for k in lost)
    if key not in known.moved:
        known.moved[key] = _all_moved([edits[k] for k in lost], known)
    _, moved = known.moved[key]
    found = dict(zip(lost, moved, strict=True))
    return [found.get(k, edit) for k, edit in enumerate(edits)]


def is_moved(edit: Edit, stated: Edit) -> bool:
    """Whether an edit has other places than it was stated with."""
    both = zip(_stretches(edit), _stretches(stated), strict=False)
    return any(now.witnesses[0].xyz != then.witnesses[0].xyz for now, then in both)


def _placed(edit: Edit, known: KnownVotes) -> bool:
    """Whether an edit has no witness, or finds its samples as it is; found out once."""
    if id(edit) not in known.placed:
        if not _finds(edit, known):
            return False
        known.placed[id(edit)] = edit  # which is kept, so that its id stays its own
    return True


def _finds(edit: Edit, known: KnownVotes, share: float = 0.5) -> bool:
    """Whether such a share of an edit's witnesses in the trial have a sample of any path within NEAR_MM."""
    frame, xyz = _witnesses(edit, known.trajectories)
    if isinstance(edit, Claim):  # whose witnesses vote in any case: one that is on a path has a sample of it so near
        on = votes([edit.where], known.trajectories, None, world=known.world).path >= 0
        if on.sum() >= share * len(frame):
            return True
    near = np.isfinite(_nearest(frame, xyz, known)[:, 0])
    return bool(near.sum() >= share * len(frame))


def _nearest(frame: Ints, xyz: Floats, known: KnownVotes) -> Floats:
    """(W, 3) mm, the sample of any path that is nearest to each place, NaN where none is within NEAR_MM."""
    least, found = np.full(len(frame), NEAR_MM), np.full((len(frame), 3), np.nan)
    for path in known.trajectories if len(frame) else ():
        apart = np.linalg.norm(path.xyz[frame] - xyz, axis=1)
        nearer = apart <= least
        least[nearer], found[nearer] = apart[nearer], path.xyz[frame[nearer]]
    return found


def _witnesses(edit: Edit, trajectories: Trajectories) -> tuple[Ints, Floats]:
    """Frames (W), from 0, and places (W, 3) mm of an edit's witnesses that lie in the trial."""
    n, start = trajectories.n_frames, trajectories.first_frame
    inside = [w for stretch in _stretches(edit) for w in stretch.witnesses if 0 <= w.frame - start < n]
    return np.array([w.frame - start for w in inside], np.int64), np.array([w.xyz for w in inside]).reshape(-1, 3)


def _stretches(edit: Edit) -> Iterator[Stretch]:
    """All that have witnesses of an edit."""
    many = edit.where if isinstance(edit, Verdict) else (getattr(edit, "where", None), getattr(edit, "whose", None))
    yield from (one for one in many if one is not None)


def _all_moved(lost: Sequence[Edit], known: KnownVotes) -> tuple[Sequence[Edit], list[Edit]]:
    """Edits that find nothing, and the same with their moves; files may have been moved more than once."""
    now, left = list(lost), list(range(len(lost)))
    while left:
        tried = list(islice(_moves([lost[k] for k in left], known), MOST_TRIED))
        for move in tried:
            found = [k for k in left if _finds(_moved(lost[k], move.of), known, ENOUGH)]
            if 2 * len(found) > len(left):  # (2)
                break
        else:
            break
        own = [lost[k] for k in found]
        exact = _by_all(own, move.of, known)
        if not _is_same(own, exact, known) or not (move.by_name or _is_only_one(own, move.of, tried, known)):
            break
        for k in found:
            now[k] = _moved(lost[k], exact)
        left = [k for k in left if k not in found]
    return lost, now


def _is_same(edits: Sequence[Edit], move: Move, known: KnownVotes) -> bool:
    """Whether the samples that edits find by a move are those which they were said of (4)."""
    off, sway = [np.zeros(0)], [np.zeros(0)]
    for edit in (one for one in edits if _is_of_marker(one)):
        frame, xyz = _witnesses(edit, known.trajectories)
        apart = np.linalg.norm(_nearest(frame, move(xyz), known) - move(xyz), axis=1)
        off.append(apart[np.isfinite(apart)])
        sway.append(np.linalg.norm(xyz - xyz.mean(0), axis=1))
    most = min(CLOSE_MM, max(ROUNDED_MM, SWAY * float(np.median(np.concatenate(sway)))))
    return bool(np.median(np.concatenate(off)) <= most)


def _is_only_one(edits: Sequence[Edit], move: Move, tried: Sequence[Tried], known: KnownVotes) -> bool:
    """Whether no other move that was tried lays all of some edits on other samples (3)."""
    xyz = np.concatenate([_witnesses(edit, known.trajectories)[1] for edit in edits])
    for other, _ in tried:
        elsewhere = np.median(np.linalg.norm(move(xyz) - other(xyz), axis=1)) > 2 * NEAR_MM
        if elsewhere and all(_finds(_moved(edit, other), known, ENOUGH) for edit in edits):
            return False
    return True


def _by_all(edits: Sequence[Edit], move: Move, known: KnownVotes) -> Move:
    """A move by all witnesses of edits that find their samples with it: those of one leave its turn a little open."""
    frame, xyz = (
        np.concatenate(parts) for parts in zip(*(_witnesses(e, known.trajectories) for e in edits), strict=True)
    )
    target = _nearest(frame, move(xyz), known)
    return Move(*rigid_align(xyz, target)) if np.isfinite(target[:, 0]).sum() >= FEWEST else move


def _is_of_marker(edit: Edit) -> bool:
    """Whether all witnesses of an edit are of one marker."""
    return isinstance(edit, Claim) or getattr(edit, "marker", None) is not None


def _moves(lost: Sequence[Edit], known: KnownVotes) -> Iterator[Tried]:
    """Moves that lay the witnesses of an edit on paths (1): first on those of their names, one by one and together."""
    named, others = list[tuple[Floats, Floats]](), list[tuple[Floats, Floats]]()
    for edit in filter(_is_of_marker, lost):
        frame, xyz = _witnesses(edit, known.trajectories)
        marker = getattr(edit, "marker", None)
        for path in known.trajectories:
            there = np.isfinite(path.xyz[frame]).all(1)
            (named if path.name == marker else others).append((xyz[there], path.xyz[frame[there]]))
    if named:
        together = _agreeing(*(np.concatenate(side) for side in zip(*named, strict=True)))
        for pair in (*named, together):
            yield from (Tried(move, True) for move in _fitted(*pair))
    for pair in others:
        yield from (Tried(move, False) for move in _fitted(*pair))


def _agreeing(source: Floats, target: Floats) -> tuple[Floats, Floats]:
    """Of places (N, 3) mm and where markers of their names are, those that agree about a move: the most of some tries.

    The others may have another marker's name by now.
    """
    rng, kept = np.random.default_rng(0), np.zeros(len(source), bool)
    for _ in range(TRIES if len(source) >= FEWEST else 0):
        three = rng.choice(len(source), 3, replace=False)
        move = Move(*rigid_align(source[three], target[three]))
        near = np.linalg.norm(move(source) - target, axis=1) <= NEAR_MM
        kept = near if near.sum() > kept.sum() else kept
    return source[kept], target[kept]


def _fitted(source: Floats, target: Floats) -> Iterator[Move]:
    """The move of places (N, 3) mm upon others, where there are enough to tell of it and it is close."""
    spread = np.linalg.svd(source - source.mean(0), compute_uv=False) / np.sqrt(len(source)) if len(source) else [0, 0]
    if len(source) < FEWEST or spread[1] < NEAR_MM:
        return
    move = Move(*rigid_align(source, target))
    off = float(np.sqrt(((move(source) - target) ** 2).sum(1).mean()))
    if off <= CLOSE_MM:
        yield move


def _moved(edit: Edit, move: Move) -> Edit:
    """An edit with its witnesses, and its place, moved."""
    if isinstance(edit, Verdict):
        return replace(edit, where=tuple(_stretch_moved(stretch, move) for stretch in edit.where))
    changed: dict[str, Any] = {
        name: _stretch_moved(stretch, move)
        for name in ("where", "whose")
        if (stretch := getattr(edit, name, None)) is not None
    }
    if isinstance(edit, Put):
        changed["xyz"] = tuple(move(edit.xyz).tolist())
    return replace(edit, **changed)


def _stretch_moved(stretch: Stretch, move: Move) -> Stretch:
    xyz = move([witness.xyz for witness in stretch.witnesses]).tolist()
    moved = (w._replace(xyz=tuple(place)) for w, place in zip(stretch.witnesses, xyz, strict=True))
    return replace(stretch, witnesses=tuple(moved))
