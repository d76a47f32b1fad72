"""Identities by claims: whose every sample is.

On one path, a claim speaks for all samples between two of its witnesses that follow each other and are both on the path
(1), and there a later claim counts for more than an earlier one. Every other sample takes the claim of its nearest
witness among claims whose frames cover it, of two as near the later (2), unless a witness of the claim that denies the
path (`votes`) is nearer still (3). So a witness that strayed onto the path alone, between those of another claim,
changes nothing.

Where two samples of one frame have one name, the later claim's stays, then the one nearer to its witness; a sample that
nobody claimed gives way to a claimed one. What gives way becomes unnamed (4). Of what is left of an unnamed track, the
pieces before and after one that is claimed as a marker are tracks of their own (5): what is between them is another
one. Samples that are no marker part nothing, as a spike that is taken away leaves the track one.

A path that steps onto the place of another (`crossings`) goes on as another marker, or not: a claim speaks of those of
its pieces that have a witness of it (7).

A witness says nothing any more where a later claim gives its piece another name in its frame, or gives its name to
other paths around it (6): where tracks were made again otherwise, it would stand on another marker.

Where a witness of one marker follows one of another on a path, in frames that both claims speak of, nothing tells which
of the samples between are whose: a claim of which many lie so is not sure (8).

Frames whose samples were said to be no marker stay so under a later claim that has no witness there (9): whoever names
the rest of the path sees them no more.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..data import Detections, MarkerTrajectory, Origin, Trajectories
from ..data.array_types import Bools, Floats, Ints
from ..data.edits import UNNAMED, Claim, is_named
from .joined import joined
from .votes import KnownVotes, Votes, denies, known_votes, votes

ENOUGH = 0.8
"""Share of a claim's witnesses that must be found for it to hold; chosen (see studies/edits.py)."""
UNSURE, FEW_UNSURE = 0.05, 2
"""Share of a claim's samples, and samples, above which it does not hold where they lie between witnesses of two
markers; chosen: of 13 wrong claims on a child's feet 8 are above it, and of 5294 right ones of 17 trials that it was
not chosen on at most 15 (see studies/edits.py)."""
MOST_ROWS = 256
"""Paths with their claims that are kept for the next version; chosen: each is 160 kB of 10 000 frames."""


Owned = dict[int, tuple[Ints, Floats]]
"""The paths that have a witness, by their indices: the claim (F) that has each sample, −1 for none, and the frames to
its nearest witness. All others are nobody's, and most are: an edit is of one path among many."""


class Claimed(NamedTuple):
    """What claims made of the paths.

    Attributes:
        trajectories: with the names claimed.
        asked, found: (K) witnesses of each claim that lie in the trial, and those of them that are on a path.
        samples: (K) that each claim has in the end; changed: (K) of these, how many were called otherwise before;
            unsure: (K) how many lie between witnesses of two markers (8).
    """

    trajectories: Trajectories
    asked: Ints
    found: Ints
    samples: Ints
    changed: Ints
    unsure: Ints


def with_claims(
    trajectories: Trajectories, claims: Sequence[Claim], detections: Detections | None, *, world: str = ""
) -> Claimed:
    """The trajectories with the identities that were claimed, later claims winning.

    Args:
        trajectories: as they come from tracking, or from a file.
        claims: in the order in which they were made.
        detections: behind the samples; None for a file without its images.
        world: key of the cameras in whose world they are.
    """
    none = np.zeros(len(claims), np.int64)
    if not claims:
        return Claimed(trajectories, none, none, none, none, none)
    said = votes([claim.where for claim in claims], trajectories, detections, world=world)
    inside = (said.frame >= 0) & (said.frame < trajectories.n_frames)
    asked = np.bincount(said.stretch[inside], minlength=len(claims))
    found = np.bincount(said.stretch[said.path >= 0], minlength=len(claims))
    said = _uncontradicted(said, claims, known_votes(trajectories, detections, world))
    owned = _owners(claims, said, known_votes(trajectories, detections, world))
    kept = _one_a_frame(trajectories, claims, owned)
    samples, changed = none.copy(), none.copy()
    for p, (of, _) in owned.items():
        path, own = trajectories.paths[p], of[kept[p] & (of >= 0)]
        other = np.array([claim.name != path.name for claim in claims])
        samples += np.bincount(own, minlength=len(claims))
        changed += np.bincount(own[other[own]], minlength=len(claims))
    unsure = _unsure(trajectories, claims, said, {p: np.where(kept[p], of, -1) for p, (of, _) in owned.items()})
    return Claimed(_renamed(trajectories, claims, owned, kept), asked, found, samples, changed, unsure)


def claim_of_each(
    trajectories: Trajectories, claims: Sequence[Claim], detections: Detections | None, *, world: str = ""
) -> Ints:
    """(P, F) the claim, by its place among all, that speaks of each sample; −1 for none. Arguments as `with_claims`."""
    owned = _owners_now(trajectories, claims, detections, world)
    return _of_all(trajectories, {p: of for p, (of, _) in owned.items()})


def claims_that_hold(
    trajectories: Trajectories, claims: Sequence[Claim], detections: Detections | None, *, world: str = ""
) -> Ints:
    """The same, −1 too where a later claim gives the name to another path in that frame (4)."""
    owned = _owners_now(trajectories, claims, detections, world)
    kept = _one_a_frame(trajectories, claims, owned)
    return _of_all(trajectories, {p: np.where(kept[p], of, -1) for p, (of, _) in owned.items()})


def _of_all(trajectories: Trajectories, rows: dict[int, Ints]) -> Ints:
    """(P, F) of some rows, −1 in all others."""
    of = np.full((len(trajectories), trajectories.n_frames), -1, np.int64)
    for p, row in rows.items():
        of[p] = row
    return of


def _owners_now(
    trajectories: Trajectories, claims: Sequence[Claim], detections: Detections | None, world: str
) -> Owned:
    """Whose each sample is, by all claims."""
    known = known_votes(trajectories, detections, world)
    said = votes([claim.where for claim in claims], trajectories, detections, world=world)
    return _owners(claims, _uncontradicted(said, claims, known), known)


def _uncontradicted(said: Votes, claims: Sequence[Claim], known: KnownVotes) -> Votes:
    """The witnesses that no later claim contradicts (6)."""
    return said.of(~_refuted(said, claims, known))


def _unsure(trajectories: Trajectories, claims: Sequence[Claim], said: Votes, left: dict[int, Ints]) -> Ints:
    """(K) samples left to each claim, by path (F), between witnesses of two markers where both claims speak (8)."""
    numbers = {name: n for n, name in enumerate({claim.name for claim in claims})}
    name = np.array([numbers[claim.name] for claim in claims])[said.stretch]
    order = np.lexsort((said.frame, said.path))
    before, after = order[:-1], order[1:]
    another = (said.path[before] == said.path[after]) & (said.path[before] >= 0) & (name[before] != name[after])
    found = np.zeros(len(claims), np.int64)
    for i, j in zip(before[another].tolist(), after[another].tolist(), strict=True):
        spans = [_covered(claims[said.stretch[row]], trajectories) for row in (i, j)]
        first = max(said.frame[i] + 1, *(span.start for span in spans))
        of = left[int(said.path[i])][first : max(first, min(said.frame[j], *(span.stop for span in spans)))]
        found += np.bincount(of + 1, minlength=len(claims) + 1)[1:]
    return found


def _owners(claims: Sequence[Claim], said: Votes, known: KnownVotes) -> Owned:
    """Whose each sample is, by witnesses that no later claim contradicts."""
    owned: Owned = {}
    for p in np.unique(said.path[said.path >= 0]).tolist():
        mine = np.unique(said.stretch[said.path == p]).tolist()
        key = p, *((k, claims[k].where, said.frame[said.stretch == k].tobytes()) for k in mine)
        if key not in known.rows:
            while len(known.rows) >= MOST_ROWS:
                del known.rows[next(iter(known.rows))]
            known.rows[key] = _owner(known, p, {k: claims[k] for k in mine}, said)
        owned[p] = known.rows[key]
    return owned


def _refuted(said: Votes, claims: Sequence[Claim], known: KnownVotes) -> Bools:
    """(N) witnesses of claims that a later one contradicts (6), piece by piece of the paths, as `crossings` has them.

    Where pieces of one marker overlap, one's witnesses there give way to the other's, but still part the path from what
    it was called before.
    """
    out, elsewhere = np.zeros((2, len(said.frame)), bool)
    if len(claims) < 2:
        return out
    voting = np.flatnonzero(said.path >= 0)
    rows = np.split(voting, np.searchsorted(said.stretch[voting], np.arange(1, len(claims))))
    piece, pieces = said.path.copy(), known.pieces(said.path[voting])
    piece[voting] += len(pieces) * pieces[said.path[voting], said.frame[voting]]  # one number for path and piece
    of_piece, of_name = dict[int, set[int]](), dict[str, set[int]]()
    for k, own in enumerate(rows):
        for p in set(piece[own].tolist()):
            of_piece.setdefault(p, set()).add(k)
        of_name.setdefault(claims[k].name or "", set()).add(k)
    for later in reversed(range(len(claims))):
        all_own = rows[later][~out[rows[later]]]
        own = all_own[~elsewhere[all_own]]
        paths, name = set(said.path[own].tolist()), claims[later].name
        for p in set(piece[all_own].tolist()) if len(own) else ():
            at = said.frame[all_own[piece[all_own] == p]]
            for k in of_piece[p]:
                if k < later and claims[k].name != name and not _stays(claims[k], at, known.trajectories):
                    out[rows[k][(piece[rows[k]] == p) & _within(said.frame[rows[k]], at)]] = True
        for k in of_name[name] if name is not None and len(own) else ():
            if k < later:
                away = ~np.isin(said.path[rows[k]], list(paths))
                elsewhere[rows[k][away & _within(said.frame[rows[k]], said.frame[own])]] = True
    return out | elsewhere


def _stays(claim: Claim, frame: Ints, trajectories: Trajectories) -> bool:
    """Whether a claim takes samples of some frames away from all markers, and a later one has no witness there (9)."""
    bounded = claim.name is None and claim.where.first is not None and claim.where.last is not None
    at = _covered(claim, trajectories)
    return bounded and not ((frame >= at.start) & (frame < at.stop)).any()


def _within(frame: Ints, ends: Ints) -> Bools:
    """Whether frames lie between the first and last of others."""
    return np.asarray((frame >= ends.min()) & (frame <= ends.max()))


def _owner(known: KnownVotes, p: int, claims: dict[int, Claim], said: Votes) -> tuple[Ints, Floats]:
    """The same (F) of one path; `claims` that have a witness on it, by their numbers."""
    trajectories, piece = known.trajectories, known.pieces(np.array([p]))[p]
    of, apart = np.full(trajectories.n_frames, -1, np.int64), np.full(trajectories.n_frames, np.inf)
    on = {k: said.of(said.stretch == k) for k in claims}
    reached = {k: np.isin(piece, piece[own.frame[own.path == p]]) for k, own in on.items()}  # (7)
    for j, k in combinations(sorted(claims), 2):
        if _stays(claims[j], on[k].frame[on[k].path == p], trajectories):
            reached[k][_covered(claims[j], trajectories)] = False  # (9)
    on = {k: own.of(_at(reached[k], own.frame)) for k, own in on.items()}
    for k, own in on.items():
        denied = own.frame[denies(own, p, trajectories, known.detections)]
        _nearest(of, apart, k, own.frame[own.path == p], denied, reached[k], _covered(claims[k], trajectories))  # (2)
    for k, own in on.items():
        speaking = own.of(own.path >= 0)
        _between(of, apart, k, speaking.frame, speaking.path == p, reached[k], _covered(claims[k], trajectories))  # (1)
    of[trajectories.paths[p].origin == Origin.MISSING] = -1
    return of, apart


def _at(mask: Bools, frame: Ints) -> Bools:
    """A mask (F) at frames; false where the trial does not have them."""
    inside = (frame >= 0) & (frame < len(mask))
    return inside & mask[np.where(inside, frame, 0)]


def _covered(claim: Claim, trajectories: Trajectories) -> slice:
    """The frames, from 0, that a claim speaks of."""
    first, last, start = claim.where.first, claim.where.last, trajectories.first_frame
    stop = trajectories.n_frames if last is None else max(last - start + 1, 0)
    return slice(0 if first is None else max(first - start, 0), stop)


def _distance(frame: Ints, at: slice, n: int) -> Floats:
    """How many frames each frame of a slice is from the nearest of these, which are in order."""
    t = np.arange(n)[at]
    after = np.searchsorted(frame, t).clip(0, len(frame) - 1)
    return np.minimum(np.abs(frame[after] - t), np.abs(frame[(after - 1).clip(0)] - t)).astype(np.float64)


def _nearest(of: Ints, apart: Floats, k: int, frame: Ints, denied: Ints, reached: Bools, at: slice) -> None:
    """Claim k takes what it is nearest to, in place."""
    d = _distance(frame, at, len(of))
    nearer = reached[at] & (d <= apart[at])
    if len(denied):
        nearer &= d < _distance(denied, at, len(of))  # (3)
    of[at][nearer], apart[at][nearer] = k, d[nearer]


def _between(of: Ints, apart: Floats, k: int, frame: Ints, here: Bools, reached: Bools, at: slice) -> None:
    """Claim k takes what lies between witnesses that follow each other on the path, in place."""
    for i in np.flatnonzero(here[:-1] & here[1:]).tolist():
        part = slice(max(frame[i], at.start), min(frame[i + 1] + 1, at.stop))
        if part.start < part.stop:
            own = reached[part]
            of[part][own], apart[part][own] = k, _distance(frame[i : i + 2], part, len(of))[own]


def _one_a_frame(trajectories: Trajectories, claims: Sequence[Claim], owned: Owned) -> dict[int, Bools]:
    """By path (F) which samples keep the name they have now by claim, or by their path, (4); all of other paths."""
    sharing, nobody = _sharing(trajectories, claims, owned), _nobodys(trajectories.n_frames)
    concerned = {*owned, *(p for rows in sharing.values() for p in rows)}
    kept = {p: trajectories.paths[p].origin != Origin.MISSING for p in concerned}
    for name, rows in sharing.items():
        of, apart = map(np.array, zip(*(owned.get(p, nobody) for p in rows), strict=True))
        mine = np.array([*(claim.name == name for claim in claims), False])  # the last stands for no claim, −1
        claimed, present = mine[of], np.array([kept[p] for p in rows])
        own = np.array([trajectories.paths[p].name == name for p in rows])[:, None] & (of < 0) & present
        if ((claimed | own).sum(0) <= 1).all():
            continue
        worth = np.where(claimed, of + 1 / (1 + apart), np.where(own, -0.5, -np.inf))
        best = np.zeros(worth.shape, bool)
        best[worth.argmax(0), np.arange(worth.shape[1])] = True
        kept.update(zip(rows, present & (best | ~(claimed | own)), strict=True))
    return kept


def _nobodys(n: int) -> tuple[Ints, Floats]:
    """Samples (F) that no claim has."""
    return np.full(n, -1, np.int64), np.full(n, np.inf)


def _sharing(trajectories: Trajectories, claims: Sequence[Claim], owned: Owned) -> dict[str, list[int]]:
    """The names that were claimed and that samples of two or more paths have, and these paths."""
    rows: dict[str, list[int]] = {claim.name: [] for claim in claims if claim.name is not None}
    for p, path in enumerate(trajectories):
        if p not in owned:
            names = {path.name}
        else:
            count = np.bincount(owned[p][0] + 1, minlength=len(claims) + 1)
            of_claims = {claims[k].name for k in np.flatnonzero(count[1:]).tolist()} - {None}
            names = {str(name) for name in of_claims} | ({path.name} if count[0] else set())
        for name in names & rows.keys():
            rows[name].append(p)
    return {name: some for name, some in rows.items() if len(some) > 1}


def _renamed(trajectories: Trajectories, claims: Sequence[Claim], owned: Owned, kept: dict[int, Bools]) -> Trajectories:
    """The paths by what their samples are called now; paths that nothing changed are the same."""
    parts: dict[str, list[tuple[int, Bools]]] = {}
    number, as_it_was, nobody = _first_free(trajectories), set[int](), _nobodys(trajectories.n_frames)
    for p, path in enumerate(trajectories):
        there, of = path.origin != Origin.MISSING, owned.get(p, nobody)[0]
        if p not in kept or ((of < 0) & (kept[p] | ~there)).all():
            as_it_was.add(p)
            parts.setdefault(path.name, []).append((p, there))
            continue
        for name, mask in _pieces(path, claims, of, kept[p], there):
            called = name
            if not called:
                called, number = f"{UNNAMED}{number}", number + 1
            parts.setdefault(called, []).append((p, mask))
    alone = {masks[0][0] for masks in parts.values() if len(masks) == 1} & as_it_was
    paths = tuple(
        trajectories.paths[masks[0][0]] if masks[0][0] in alone else joined(trajectories, name, masks)
        for name, masks in parts.items()
    )
    same = len(paths) == len(trajectories) and all(a is b for a, b in zip(paths, trajectories, strict=True))
    return trajectories if same else replace(trajectories, paths=paths)


def _pieces(
    path: MarkerTrajectory, claims: Sequence[Claim], of: Ints, kept: Bools, present: Bools
) -> Iterator[tuple[str, Bools]]:
    """What a path falls into: names, empty for a new unnamed track, and the samples (F) of each."""
    for k in np.unique(of[(of >= 0) & kept]).tolist():
        if claims[k].name is not None:
            yield str(claims[k].name), (of == k) & kept
    left = present & (of < 0) & kept
    if is_named(path.name):
        yield path.name, left
    else:
        none = np.array([*(claim.name is None for claim in claims), False])[of]  # the last stands for no claim, −1
        for i, piece in enumerate(_uncut(left, present & ~left & ~none)):  # (5)
            yield path.name if i == 0 else "", piece
    for piece in _uncut(present & ~kept, present & kept):  # (4)
        yield "", piece


def _uncut(mask: Bools, cuts: Bools) -> Iterator[Bools]:
    """The samples (F) of `mask` by pieces, with none of `cuts` between those of one."""
    piece = np.cumsum(cuts)
    for value in np.unique(piece[mask]).tolist():
        yield mask & (piece == value)


def _first_free(trajectories: Trajectories) -> int:
    """The least number that no unnamed track has."""
    numbers = [path.name.removeprefix(UNNAMED) for path in trajectories if not is_named(path.name)]
    return max((int(n) for n in numbers if n.isdigit()), default=0) + 1
