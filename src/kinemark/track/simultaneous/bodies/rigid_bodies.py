"""Rigid bodies among the tracks: which keep their distances, and the shape that they have.

Markers on a plate, a cluster or a head keep their distances. With the median m of the distance of two tracks, and s,
within which it is in KEPT of the frames that have both, the pair is steady where

    s < max(STEADY_MM, STEADY m)                                                          (1)

Tracks that are steady to MOST of those that they are seen with are one body. Its shape is the median, over frames, of
the places of its tracks in the frame of the body, whose pose R, t is that of the least squares to those of its tracks
that fit, those that do not being left out one after another: a track may have gone over to another marker of the body.
Tracks of one place are one member.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data.array_types import Bools, Floats, Ints
from ....geometry.align import nearest_rotations
from ....numerics.robust import SD_PER_MEDIAN
from ....numerics.row_quantiles import row_medians, row_quantiles
from ..joining.companions import LONG
from ..points.neighbouring_points import TrackPoints

STEADY, STEADY_MM = 0.02, 2.0
"""Of (1), a share and mm; chosen: the plate of studies/infrared_footage.py has 0.001 to 0.02, skin of one segment 0.01
to 0.05."""

KEPT = 0.8
"""Share of the frames that have both in which the distance is within s of (1); chosen: tracks of a plate that go over
to another marker do so for less, and a person who stands still for half of the time is no body."""

MOST = 0.7
"""Share of the tracks that a track is seen with, to which it must be steady; chosen: some of these have gone over."""

MEMBERS = 4
"""Of a body at least; three could be placed by any three points. Chosen."""

FEWEST = 24
"""Frames from which a distance or a place is known; chosen, as in `companions`."""

MOST_FRAMES, MOST_TRACKS = 600, 150
"""That are looked at, of a long recording; chosen: more take long."""

ROUNDS = 4
"""Of shape and poses in turn; chosen: the fourth changes hardly anything."""

LEFT_OUT = 6
"""Tracks that are left out of a pose at most, one after another; chosen."""

APART = 0.25
"""Of the distance to the nearest other member, how far from its place a member can be: such balls do not meet; by
definition below a half, chosen."""

FLAT = 0.02
"""Least second eigenvalue of the places' scatter, as a share of the first: others are as good as on a line; chosen."""


class Poses(NamedTuple):
    """Of F frames: R (F, 3, 3) and t (F, 3) mm from body to world, how many members fit (F), and their RMS (F) mm."""

    R: Floats
    t: Floats
    fit: Ints
    rms: Floats


class RigidBody(NamedTuple):
    """K members: shape (K, 3) mm, sd (K) mm of each about its place; and of N tracks the member that each is, or −1."""

    shape: Floats
    sd: Floats
    member: Ints

    @property
    def reach(self) -> Floats:
        """(K) mm by which a point may lie off a member's place."""
        apart = np.linalg.norm(self.shape[:, None] - self.shape, axis=-1)
        np.fill_diagonal(apart, np.inf)
        return np.asarray(APART * apart.min(1))


def learned_bodies(points: TrackPoints, rows: NDArray[np.int32]) -> list[RigidBody]:
    """The bodies of tracks that have rows (N, F) of the points, the largest first."""
    count = (rows >= 0).sum(1)
    long = np.argsort(-count, kind="stable")[:MOST_TRACKS]
    long = np.sort(long[count[long] >= LONG])
    frames = np.arange(0, rows.shape[1], max(rows.shape[1] // MOST_FRAMES, 1))
    xyz = places(points, rows[long][:, frames])
    bodies = []
    middle, spread = _distances(xyz)
    for group in _groups(middle, spread):
        body = _body(xyz[group], middle[np.ix_(group, group)], long[group], len(rows))
        if body is not None:
            bodies.append(body)
    return bodies


def places(points: TrackPoints, rows: NDArray[np.int32]) -> Floats:
    """(n, f, 3) mm of the points of rows (n, f), NaN where there is none."""
    return np.where((rows >= 0)[..., None], points.xyz[rows], np.nan)


def _distances(xyz: Floats) -> tuple[Floats, Floats]:
    """m and s (N, N) mm of the distances of tracks (N, F, 3), NaN where few frames have both."""
    middle, spread = np.full((2, len(xyz), len(xyz)), np.nan)
    for i in range(len(xyz) - 1):
        r = np.linalg.norm(xyz[i + 1 :] - xyz[i], axis=-1)
        some = np.flatnonzero(np.isfinite(r).sum(1) >= FEWEST)
        if len(some):
            m = row_medians(r[some])
            s = row_quantiles(np.abs(r[some] - m[:, None]), KEPT)
            middle[i, i + 1 + some], spread[i, i + 1 + some] = m, s
    return np.fmax(middle, middle.T), np.fmax(spread, spread.T)


def _groups(middle: Floats, spread: Floats) -> list[Ints]:
    """Tracks that are one body, by (1)."""
    steady, known = spread < np.maximum(STEADY_MM, STEADY * middle), np.isfinite(spread)
    left, groups = np.ones(len(middle), bool), []
    while left.any():
        degree = np.where(left, (steady & left).sum(1), -1)
        group = [int(degree.argmax())]
        for i in np.argsort(-degree, kind="stable").tolist():
            if not left[i] or i == group[0]:
                continue
            beside = known[i, group]
            if beside.sum() >= min(MEMBERS - 1, len(group)) and steady[i, group][beside].mean() >= MOST:
                group.append(i)
        if len(group) < MEMBERS:
            break
        left[group] = False
        groups.append(np.array(group))
    return groups


def _body(xyz: Floats, middle: Floats, track: Ints, n_tracks: int) -> RigidBody | None:
    """The body of tracks (n, F, 3) that are a group, with their distances (n, n); None where they have no shape."""
    shape = xyz[:, np.isfinite(xyz[..., 0]).sum(0).argmax()]
    for _ in range(ROUNDS):
        sd, shape = _shape(xyz, shape)
        if np.isfinite(sd).sum() < MEMBERS:
            return None
    member = _members(shape, sd, middle)
    first = [int(np.flatnonzero(member == k)[sd[member == k].argmin()]) for k in range(member.max() + 1)]
    if len(first) < MEMBERS:
        return None
    of = np.full(n_tracks, -1)
    of[track] = member
    return RigidBody(shape[first], sd[first], of)


def _shape(xyz: Floats, shape: Floats) -> tuple[Floats, Floats]:
    """Spread (n) mm, infinite where unknown, and places (n, 3) of tracks in the frame of a body, by its last shape."""
    poses = fitted(shape, xyz.swapaxes(0, 1), np.full(len(shape), 10 * STEADY_MM))
    inside = np.einsum("fji,nfj->nfi", poses.R, xyz - poses.t)
    inside[:, poses.fit < min(MEMBERS, np.isfinite(shape[:, 0]).sum())] = np.nan
    some = np.isfinite(inside[..., 0]).sum(1) >= FEWEST
    new, sd = np.full_like(shape, np.nan), np.full(len(shape), np.inf)
    new[some] = row_medians(inside[some].swapaxes(1, 2))
    off = np.linalg.norm(inside[some] - new[some][:, None], axis=-1)
    sd[some] = SD_PER_MEDIAN * row_medians(off) / np.sqrt(3)
    return sd, new


def _members(shape: Floats, sd: Floats, middle: Floats) -> Ints:
    """(n) which member each track is, −1 for those without a place.

    Tracks that lie by APART as near as any that are seen together, of which the distances (n, n) are known, are one.
    """
    known = np.flatnonzero(np.isfinite(sd))
    middle = middle[np.ix_(known, known)]
    reach = APART * np.nanmin(middle, axis=1, initial=np.inf)
    apart = np.linalg.norm(shape[known][:, None] - shape[known], axis=-1)
    near = (apart < np.minimum(reach[:, None], reach)) & ~np.isfinite(middle)
    out = np.full(len(shape), -1)
    for i in np.argsort(sd[known], kind="stable").tolist():
        if out[known[i]] < 0:
            out[known[near[i] & (out[known] < 0)]] = out.max() + 1
    return out


def fitted(shape: Floats, xyz: Floats, reach: Floats) -> Poses:
    """The poses by which members at xyz (F, K, 3) mm, NaN where unseen, lie by a shape (K, 3), but for some off it."""
    used, A = np.isfinite(xyz[..., 0]) & np.isfinite(shape[:, 0]), np.nan_to_num(shape)
    at = np.where(used[..., None], xyz, 0.0)
    R, t, off = np.empty((len(at), 3, 3)), np.empty((len(at), 3)), np.empty(used.shape)
    some = np.arange(len(at))
    for _ in range(LEFT_OUT + 1):
        R[some], t[some] = _aligned(A, at[some], used[some])
        apart = np.linalg.norm(at[some] - A @ R[some].mT - t[some, None], axis=-1)
        off[some] = np.where(used[some], apart, 0.0)
        worst = (off[some] > reach) & (off[some] == off[some].max(1, keepdims=True))
        used[some] &= ~worst
        some = some[worst.any(1)]  # all others stay as they are
        if not len(some):
            break
    fit = np.where(_spread_out(A, used) & np.isfinite(t).all(1), used.sum(1), 0)
    return Poses(R, t, fit, np.sqrt((off**2).sum(1) / np.maximum(used.sum(1), 1)))


def _aligned(A: Floats, at: Floats, used: Bools) -> tuple[Floats, Floats]:
    """R (F, 3, 3), t (F, 3) of the least squares from places A (K, 3) to those `used` (F, K) of `at` (F, K, 3)."""
    n = np.maximum(used.sum(1), 1)[:, None]
    a, b = used @ A / n, (at * used[..., None]).sum(1) / n
    H = np.einsum("fk,fki,fkj->fij", used, at - b[:, None], A - a[:, None])
    R = nearest_rotations(H)
    return R, b - (R @ a[..., None])[..., 0]


def _spread_out(A: Floats, used: Bools) -> Bools:
    """(F) whether the places A (K, 3) that are used (F, K) are three and more, and not on a line."""
    n = np.maximum(used.sum(1), 1)
    mean = used @ A / n[:, None]
    scatter = np.einsum("fk,ki,kj->fij", used, A, A) / n[:, None, None] - mean[:, :, None] * mean[:, None]
    value = np.linalg.eigvalsh(scatter)
    return np.asarray((used.sum(1) >= 3) & (value[:, 1] > FLAT * value[:, 2]))
