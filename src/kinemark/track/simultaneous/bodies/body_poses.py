"""Where a rigid body is in every frame: by its tracks, and where these break, by all points or images there are.

A frame in which AGREE of the body's tracks, three and more, fit its shape has its pose from these. Others are gone to
from the frame beside them, with its rotation. The body is moved so that some member lies on some point of the frame,
each on each; where the most members then lie within their reach of a point is its pose, after some rounds of fitting
and taking the points anew. It counts where ENOUGH of the members, SEARCHED and more, lie so, and CLEARLY more than
anywhere else (1): a plate with markers on a grid fits beside its place as well, but for a few of them.

A point is that of the member within whose reach it lies, and within GATE standard deviations,

    s² = s_k² + rms² + s_p²                                                               (2)

with the member's spread s_k, what the pose leaves in its frame, and the point's own s_p.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data.array_types import Bools, Floats, Ints
from ....geometry import rigid_align
from ....signal import assign
from ..points.neighbouring_points import TrackPoints, parts_of_frames
from .rigid_bodies import Poses, RigidBody, fitted, places

AGREE = 0.6
"""Share of the members seen in a frame that must fit; chosen: two of five tracks may have gone over."""

ENOUGH, SEARCHED, CLEARLY = 0.4, 5, 2
"""Of (1): a share of the members, and numbers of them; chosen (see studies/infrared_footage.py)."""

FITS = 6
"""Rounds of a fit; chosen: points hardly ever change after the third."""

STARTS = 12
"""Places from which a fit is begun, the best by the number of members near points; chosen."""

GATE = 4.0
"""Standard deviations of (2); chosen, for errors that are not normal."""

AT_ONCE = 5_000
"""Points of whole frames that are looked at in one go; chosen: more would take memory and no less time."""

MIN_FIT = 3
"""Points of a pose; by definition."""

Points = Callable[[int], Floats]
"""The points (n, 3) mm of a frame."""


class Fit(NamedTuple):
    """A pose R (3, 3), t (3) mm, how many members lie within reach of a point, their RMS mm, and all places (K, 3)."""

    R: Floats
    t: Floats
    number: int
    rms: float
    at: Floats


def body_poses(body: RigidBody, points: TrackPoints, rows: NDArray[np.int32], others: Points) -> Poses:
    """The poses of a body in all frames, `fit` 0 where unknown.

    Args:
        rows: (N, F) of the points of each track. others: points that the images of a frame make, whosever.
    """
    poses, starts = by_tracks(body, points, rows), np.searchsorted(points.frame, np.arange(rows.shape[1] + 1))
    if len(body.shape) < SEARCHED:
        return poses
    R, t, fit, rms = poses.R.copy(), poses.t.copy(), poses.fit.copy(), poses.rms.copy()
    for way in (1, -1):
        for f in range(len(fit))[::way]:
            beside = f - way
            if fit[f] or not 0 <= beside < len(fit) or not fit[beside]:
                continue
            for found in (points.xyz[starts[f] : starts[f + 1]], None):
                pose = searched(body, others(f) if found is None else found, R[beside], t[beside])
                if pose:
                    R[f], t[f], fit[f], rms[f] = pose.R, pose.t, pose.number, pose.rms
                    break
    return Poses(R, t, fit, rms)


def by_tracks(body: RigidBody, points: TrackPoints, rows: NDArray[np.int32]) -> Poses:
    """The poses by the tracks of the body's members; of several tracks of one member in a frame by the longest."""
    own = np.full((len(body.shape), rows.shape[1]), -1, np.int32)
    length = (rows >= 0).sum(1)
    for track in np.argsort(-length, kind="stable").tolist():
        k = body.member[track]
        if k >= 0:
            own[k] = np.where(own[k] < 0, rows[track], own[k])
    poses = fitted(body.shape, places(points, own).swapaxes(0, 1), body.reach)
    return poses._replace(fit=np.where(poses.fit >= AGREE * (own >= 0).sum(0), poses.fit, 0))


def searched(body: RigidBody, points: Floats, R: Floats, t: Floats) -> Fit | None:
    """The pose among points (n, 3) mm, by (1), from that of the frame beside; None where none is clear."""
    least = max(SEARCHED, ENOUGH * len(body.shape))
    if len(points) < least:
        return None
    at, reach = body.shape @ R.T + t, body.reach
    shifts = np.concatenate([np.zeros((1, 3)), (points - at[:, None]).reshape(-1, 3)])
    apart = np.linalg.norm((at + shifts[:, None])[:, :, None] - points, axis=-1).min(2)
    near = (apart < 1.5 * reach).sum(1)
    best = np.argsort(-near, kind="stable")[:STARTS]
    starts = best[near[best] >= MIN_FIT]
    fits = [fit for k in starts if (fit := _fitted(body, points, R, t + shifts[k], reach)) is not None]
    fits.sort(key=lambda fit: (-fit.number, fit.rms))
    if not fits or fits[0].number < least:
        return None
    elsewhere = [fit.number for fit in fits if np.linalg.norm(fit.at - fits[0].at, axis=1).mean() > reach.mean()]
    return fits[0] if fits[0].number - max(elsewhere, default=0) >= CLEARLY else None


def _fitted(body: RigidBody, points: Floats, R: Floats, t: Floats, reach: Floats) -> Fit | None:
    """The pose of the points (n, 3) nearest to the members', beginning with one."""
    for _ in range(FITS):
        at = body.shape @ R.T + t
        member, point = assign(np.linalg.norm(at[:, None] - points, axis=-1), reach)
        if len(member) < MIN_FIT:
            return None
        R, t = rigid_align(body.shape[member], points[point])
    at = body.shape @ R.T + t
    rms = float(np.sqrt(((at[member] - points[point]) ** 2).sum(1).mean()))
    return Fit(R, t, len(member), rms, at)


def member_places(body: RigidBody, poses: Poses, frame: Ints) -> Floats:
    """(n, K, 3) mm where the members are in frames (n)."""
    return np.asarray(body.shape @ poses.R[frame].mT + poses.t[frame][:, None])


class InPlace(NamedTuple):
    """Of P points: the member that each is, or −1, and whether it lies off all of them; only in frames with a pose."""

    member: Ints
    off: Bools


def in_place(body: RigidBody, poses: Poses, points: TrackPoints) -> InPlace:
    """Which member each point is, by (2); of several in a frame that of the member's own tracks, or the nearest."""
    found = InPlace(np.full(len(points.id), -1), np.zeros(len(points.id), bool))
    for part in parts_of_frames(points.frame, AT_ONCE):
        found.member[part], found.off[part] = _in_place(body, poses, points.take(part))
    return found


def _in_place(body: RigidBody, poses: Poses, points: TrackPoints) -> InPlace:
    """The same of all points of some frames."""
    member, off = np.full(len(points.id), -1), np.zeros(len(points.id), bool)
    row = np.flatnonzero(poses.fit[points.frame] > 0)
    frame = points.frame[row]
    apart = np.linalg.norm(member_places(body, poses, frame) - points.xyz[row][:, None], axis=-1)
    k, apart = np.argmin(apart, axis=1), np.min(apart, axis=1)
    own = np.trace(points.cov[row], axis1=1, axis2=2) / 3
    s = np.sqrt(body.sd[k] ** 2 + poses.rms[frame] ** 2 + np.where(np.isfinite(own), own, 0.0))
    near = apart < np.minimum(body.reach[k], GATE * s)
    off[row] = ~near
    row, k, frame, apart = row[near], k[near], frame[near], apart[near]
    order = np.lexsort([apart, body.member[points.id[row]] != k, k, frame])
    key = frame[order] * len(body.shape) + k[order]
    first = order[np.diff(key, prepend=-1) > 0]
    member[row[first]] = k[first]
    return InPlace(member, off)
