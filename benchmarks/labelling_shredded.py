"""A labelled trial as an unlabelled one: whole or in pieces, among ghosts, shuffled, with the truth beside it.

Markers may be absent, there may be some that no template knows, and two tracks may go over into each other. The names
that come back are compared with the truth by `labelling_scores`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np

from kinemark.data import MarkerTrajectory, Trajectories
from kinemark.data.array_types import Bools, Floats, Ints

Ghost = Literal["walk", "midpoint", "reflection", "twin"]
"""A point that wanders near the body, one midway between two markers, one that stands still, one made of other
images of a marker beside it."""
GHOSTS: tuple[Ghost, ...] = ("walk", "midpoint", "reflection", "twin")
TWIN_MM = 10.0
"""Standard deviation of a twin's offset on each axis, mm; chosen: two twins of heels in a real trial were 9 and 29 mm
beside them in the mean."""
LEAST_GHOST, GREATEST_GHOST, MEAN_GHOST = 3, 40, 20
"""How long a ghost lives, frames: any number from the first to below the second, which are 20 in the mean where the
trial's end cuts some short; chosen, as trackers leave them."""
STEP_MM = 3.0
"""Standard deviation of a ghost's step a frame, mm; chosen, as fast as a walking subject's limbs."""


class Change(NamedTuple):
    """A track is another marker from this frame on; none where that is None."""

    frame: int
    marker: str | None


class Shredded(NamedTuple):
    """Tracks without names, and whose each is.

    Attributes:
        tracks: T of them, called `*1`, `*2`, …
        truth: (T) the marker that each is where it begins; None for ghosts.
        changes: track → where it goes over to other markers, in their order; tracks that keep theirs are not in it.
    """

    tracks: Trajectories
    truth: tuple[str | None, ...]
    changes: Mapping[int, tuple[Change, ...]] = MappingProxyType({})


class _Piece(NamedTuple):
    """A track to be: (F, 3) mm, its marker, and from which frames on it is others'."""

    xyz: Floats
    marker: str | None
    changes: tuple[Change, ...] = ()


def shredded(
    trial: Trajectories,
    pieces: int = 1,
    ghosts: float = 0.0,
    seed: int = 0,
    *,
    kinds: Sequence[Ghost] = ("walk",),
    at_gaps: bool = False,
    absent: int = 0,
    extra: int = 0,
    still: int = 0,
    exchanges: int = 0,
    returns: int = 0,
    takeovers: int = 0,
    hidden: int = 0,
) -> Shredded:
    """A trial's markers as tracks without names.

    Args:
        trial: labelled.
        pieces: into how many each marker is cut, at random.
        ghosts: mean number in a frame.
        seed: of all that is random; the same seed gives the same tracks.
        kinds: of ghosts, taken in turn.
        at_gaps: each marker is also cut where it has a gap.
        absent: markers left out, at random.
        extra: markers that the trial does not have, fixed to three near ones; called `+1`, `+2`, …
        still: points that stand still near the body all through the trial, as what shines in the room does.
        exchanges: pairs of near markers whose tracks go over into each other at some frame.
        returns: pairs that do so, and back again after a tenth to four tenths of the trial.
        takeovers: markers whose track goes over to a near one, where that one's own ends; the rest of the first is a
            track of its own.
        hidden: frames about each of these changes in which neither of both markers is seen.

    Raises:
        ValueError: pieces is below 1 or above the number of frames, another number is below 0, or there are not so
            many markers.
    """
    _check(trial, pieces, ghosts, absent, extra, still, exchanges + returns + takeovers)
    rng, other = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    gone = set(other.choice(len(trial), absent, replace=False).tolist())
    whole = [_Piece(path.xyz, path.name) for i, path in enumerate(trial) if i not in gone]
    whole += [_Piece(_fixed_to(trial.xyz, other), f"+{k}") for k in range(1, extra + 1)]
    kinds_of = (*[_exchange] * exchanges, *[_return] * returns, *[_takeover] * takeovers)
    whole = _exchanged(whole, kinds_of, other, hidden)
    whole += [_Piece(_standing(trial.xyz, other), None) for _ in range(still)]
    parts = [part for one in whole for part in _cut(one, pieces, at_gaps, rng)]
    parts += _ghosts(trial.xyz, ghosts, kinds, rng)
    order = [parts[i] for i in rng.permutation(len(parts))]
    paths = tuple(MarkerTrajectory.measured(f"*{k}", one.xyz) for k, one in enumerate(order, 1))
    changes = {t: one.changes for t, one in enumerate(order) if one.changes}
    return Shredded(Trajectories(paths, trial.rate), tuple(one.marker for one in order), MappingProxyType(changes))


def _check(
    trial: Trajectories, pieces: int, ghosts: float, absent: int, extra: int, still: int, exchanges: int
) -> None:
    """Numbers that make sense for this trial."""
    if not 1 <= pieces <= max(trial.n_frames, 1):
        raise ValueError(f"pieces is {pieces}, wanted 1 to {trial.n_frames}, the number of frames")
    numbers = {"ghosts": ghosts, "absent": absent, "extra": extra, "still": still, "exchanges": exchanges}
    for name, value in numbers.items():
        if not 0 <= value < np.inf:
            raise ValueError(f"{name} is {value}, wanted 0 or more")
    if absent + 2 * exchanges > len(trial) or (extra and len(trial) < 3):
        raise ValueError(
            f"the trial has {len(trial)} markers, too few for {absent} absent, {exchanges} exchanges and {extra} extra"
        )


def _cut(one: _Piece, pieces: int, at_gaps: bool, rng: np.random.Generator) -> list[_Piece]:
    """At random frames, and at gaps if that is wanted; parts without samples are left out."""
    F = len(one.xyz)
    cuts = np.sort(rng.choice(np.arange(1, F), pieces - 1, replace=False)) if pieces > 1 else np.zeros(0, int)
    if at_gaps:
        seen = np.isfinite(one.xyz[:, 0]).astype(int)
        cuts = np.union1d(cuts, np.flatnonzero(np.diff(seen)) + 1)
    out = []
    for a, b in zip([0, *cuts.tolist()], [*cuts.tolist(), F], strict=True):
        if np.isfinite(one.xyz[a:b, 0]).any():
            out.append(_part(one, a, b))
    return out


def _part(one: _Piece, a: int, b: int) -> _Piece:
    """Frames from a to below b; the track is what it is there."""
    xyz = np.full_like(one.xyz, np.nan)
    xyz[a:b] = one.xyz[a:b]
    own = np.flatnonzero(np.isfinite(xyz[:, 0]))
    first, last = (int(own[0]), int(own[-1])) if len(own) else (a, b)
    before = [change for change in one.changes if change.frame <= first]
    inside = tuple(change for change in one.changes if first < change.frame <= last)
    return _Piece(xyz, before[-1].marker if before else one.marker, inside)


_Exchange = Callable[[_Piece, _Piece, Ints, np.random.Generator], tuple[_Piece, ...]]
"""What two near markers, seen together in some frames, become."""


def _exchanged(whole: list[_Piece], kinds: Sequence[_Exchange], rng: np.random.Generator, hidden: int) -> list[_Piece]:
    """With pairs of nearest markers exchanged, each in one of these ways, and hidden for some frames about it."""
    left = list(rng.permutation(len(whole)))
    out = list(whole)
    for exchange in kinds:
        a = left.pop()
        apart = [_apart(whole[a], whole[b]) for b in left]
        b = left.pop(int(np.argmin(apart)))
        frames = np.flatnonzero(_both(whole[a], whole[b]))
        if len(frames) >= 3:
            both = exchange(whole[a], whole[b], frames, rng)
            at = [change.frame for one in both for change in one.changes]
            out[a], out[b], *rest = (_hidden(one, at, hidden) for one in both)
            out += rest
    return out


def _hidden(one: _Piece, at: Sequence[int], n: int) -> _Piece:
    """Unseen in n frames about each of these; its own changes are where it is seen again."""
    if not n:
        return one
    xyz = one.xyz.copy()
    for frame in at:
        xyz[max(frame - n // 2, 0) : frame - n // 2 + n] = np.nan
    changes: dict[int, Change] = {}
    for change in one.changes:
        after = np.flatnonzero(np.isfinite(xyz[change.frame :, 0]))
        if len(after):  # of changes with nothing seen between them the last one counts
            first = change.frame + int(after[0])
            changes[first] = change._replace(frame=first)
    was, kept = one.marker, []
    for change in changes.values():
        kept += [change] if change.marker != was else []
        was = change.marker
    return _Piece(xyz, one.marker, tuple(kept))


def _exchange(a: _Piece, b: _Piece, frames: Ints, rng: np.random.Generator) -> tuple[_Piece, ...]:
    """Each is the other from some frame on."""
    at = int(frames[rng.integers(1, len(frames) - 1)])
    return _turned(a, b, at, len(a.xyz)), _turned(b, a, at, len(a.xyz))


def _return(a: _Piece, b: _Piece, frames: Ints, rng: np.random.Generator) -> tuple[_Piece, ...]:
    """Each is the other for a while."""
    n = max(2, round(len(frames) * rng.uniform(0.1, 0.4)))
    k = int(rng.integers(1, max(len(frames) - n, 2)))
    at, stop = int(frames[k]), int(frames[min(k + n, len(frames) - 1)])
    return _turned(a, b, at, stop), _turned(b, a, at, stop)


def _takeover(a: _Piece, b: _Piece, frames: Ints, rng: np.random.Generator) -> tuple[_Piece, ...]:
    """The first goes on as the second, which ends; what is left of the first begins anew."""
    at = int(frames[rng.integers(1, len(frames) - 1)])
    F = len(a.xyz)
    return _turned(a, b, at, F), _part(b, 0, at), _part(a, at, F)


def _apart(a: _Piece, b: _Piece) -> float:
    """Mean distance, mm; infinite where they are never seen together."""
    d = np.linalg.norm(a.xyz - b.xyz, axis=1)[_both(a, b)]
    return float(d.mean()) if len(d) else np.inf


def _both(a: _Piece, b: _Piece) -> Bools:
    """(F) whether both are seen."""
    return np.isfinite(a.xyz[:, 0]) & np.isfinite(b.xyz[:, 0])


def _turned(a: _Piece, b: _Piece, at: int, stop: int) -> _Piece:
    """The one, and in frames from `at` to below `stop` the other."""
    xyz = a.xyz.copy()
    xyz[at:stop] = b.xyz[at:stop]
    back = (Change(stop, str(a.marker)),) if stop < len(xyz) else ()
    return _Piece(xyz, a.marker, (Change(at, str(b.marker)), *back))


def _fixed_to(xyz: Floats, rng: np.random.Generator) -> Floats:
    """(F, 3) a marker fixed to a random one and the two that are nearest to it in the mean."""
    a = int(rng.integers(len(xyz)))
    apart = np.linalg.norm(xyz - xyz[a], axis=2)
    seen = np.isfinite(apart)
    mean = np.where(seen.any(1), np.where(seen, apart, 0.0).sum(1) / np.maximum(seen.sum(1), 1), np.inf)
    b, c = np.argsort(mean, kind="stable")[1:3]
    s, t = rng.uniform(-1, 1, 2)
    return xyz[a] + s * (xyz[b] - xyz[a]) + t * (xyz[c] - xyz[a])


def _standing(xyz: Floats, rng: np.random.Generator) -> Floats:
    """(F, 3) a point that stands still, as far from the middle of all that is seen as markers are."""
    seen = xyz[np.isfinite(xyz[..., 0])]
    return np.tile(seen.mean(0) + rng.normal(0, 1, 3) * seen.std(0), (xyz.shape[1], 1))


def _ghosts(xyz: Floats, each: float, kinds: Sequence[Ghost], rng: np.random.Generator) -> list[_Piece]:
    """As many as are `each` in a frame in the mean."""
    F, out = xyz.shape[1], []
    for k in range(int(each * F / MEAN_GHOST)):
        a = int(rng.integers(F))
        b = min(F, a + int(rng.integers(LEAST_GHOST, GREATEST_GHOST)))
        if len(now := np.flatnonzero(np.isfinite(xyz[:, a, 0]))) > 1:
            place = np.full((F, 3), np.nan)
            place[a:b] = _ghost(kinds[k % len(kinds)], xyz[:, a:b], now, rng)
            out.append(_Piece(place, None))
    return [one for one in out if np.isfinite(one.xyz).any()]


def _ghost(kind: Ghost, xyz: Floats, now: Ints, rng: np.random.Generator) -> Floats:
    """(n, 3) of one kind; xyz (M, n, 3) of the markers meanwhile, `now` those seen when it begins."""
    if kind == "midpoint":
        a, b = rng.choice(now, 2, replace=False)
        return 0.5 * (xyz[a] + xyz[b])
    if kind == "twin":
        return xyz[rng.choice(now)] + rng.normal(0, TWIN_MM, 3)
    here = xyz[now, 0]
    place = here.mean(0) + rng.normal(0, 1, 3) * here.std(0)
    if kind == "reflection":
        return np.broadcast_to(place, xyz.shape[1:])
    return place + np.cumsum(rng.normal(0, STEP_MM, xyz.shape[1:]), 0)
