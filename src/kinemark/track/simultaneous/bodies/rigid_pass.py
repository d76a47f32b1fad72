"""A pass over the tracks of rigid bodies: what each point is by its place on the body, and what was not found.

Where a plate moves by half of the distance of its markers from frame to frame, a track goes over to the marker beside
it, or breaks, and new ones begin that do the same. But the body that the tracks show elsewhere (`rigid_bodies`) has one
place there (`body_poses`), and with it the identity of every point. Of a body of which the members have BREAKS tracks
and more each, of whose points no more than MOST_OFF lie off its places (0),

- a track of which OF_BODY of the points are in place is the body's, and so are pieces of it: each of its points is of
  the member in whose place it is, wherever the track goes over (1);
- its points that lie off all places, by a pose of STRONG members and more, are none (2); where there is no pose they
  are of the member that they were next to in time;
- a member that is not seen is looked for in the images that no point of a track of LONG points, or of a body, has,
  within GATE standard deviations of its place, which is known as (2) of `body_poses` says. Two images and more make a
  point, if it is in place (3). Points of short tracks that have one of these images are none, and so are those that
  are left of a track if they are fewer than one has at least.

Each member is the track that has the most of its points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images
from ..following.associate import associate, information, predict_images
from ..following.candidate_points import find_candidate_points, fundamentals, intersect
from ..following.kalman_states import initial_states, update
from ..following.passes import without_outliers
from ..joining.companions import LONG
from ..points.neighbouring_points import TrackPoints, rows_of
from ..simultaneous_method import Simultaneous
from .body_poses import GATE, InPlace, body_poses, by_tracks, in_place, member_places
from .rigid_bodies import Poses, RigidBody, learned_bodies
from .same_body import joined_bodies

OF_BODY = 0.5
"""Of (1), a share; chosen: a track that goes over lies beside the places for some frames."""

STRONG = 5
"""Members of a pose by which points are none (2); chosen: by fewer it may be the pose that is wrong."""

BREAKS, MOST_OFF = 2.0, 0.05
"""Of (0), tracks a member and a share of points; chosen: a body of which the tracks hold is left as it is, and so is
one that bends, as a trunk does (tests/support/scenes; the plate of studies/infrared_footage.py has 4 and 0.03)."""

LEAST_SD = 1.0
"""mm of a place, which is that of a marker and not of a body without skin; chosen, as `stitch.LEAST`."""


class RigidPass(NamedTuple):
    """Of P points the track (P) of each, −1 for none; points found, with detections (C, N); and what each of the N
    tracks became (N)."""

    id: Ints
    found: TrackPoints
    detection: Ints
    became: Ints


def rigid_pass(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> RigidPass:
    """The pass over P points of tracks, of detections (C, P)."""
    used, id = np.unique(points.id, return_inverse=True)  # most numbers have no track here; tables have a row for each
    again = _pass_over(points._replace(id=id), detection, images, T, method)
    became = np.arange(int(used.max(initial=-1)) + 1)
    became[used] = used[again.became]
    found = again.found._replace(id=used[again.found.id])
    return RigidPass(np.append(used, -1)[again.id], found, again.detection, became)


def _pass_over(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> RigidPass:
    """The same of tracks that are numbered without a gap."""
    ids, became = points.id.copy(), np.arange(int(points.id.max(initial=-1)) + 1)
    found, own = points.take(np.zeros(0, np.int64)), detection[:, :0]
    rows, F, left = rows_of(points), fundamentals(images.P), np.ones(len(became), bool)
    bodies = learned_bodies(points, rows) if len(points.id) else []
    for body in joined_bodies(bodies, rows >= 0):
        if not _may_break(body, points, rows, left | (body.member >= 0)):
            continue
        poses = body_poses(body, points, rows, lambda f: _of_images(images, F, f, method.gate))
        placed = in_place(body, poses, points)
        of_body = _tracks_of(placed, points, len(became))
        of_body &= left | (body.member >= 0)
        if not _breaks(placed, of_body, points, len(body.shape)):
            continue
        left &= ~of_body
        placed = placed._replace(member=np.where(of_body[points.id], placed.member, -1))
        owner = _owners(placed, points, len(body.shape), len(became))
        if (owner < 0).any():
            continue
        ids = _identities(placed, points, poses, of_body, owner, ids)
        became[of_body] = _most(ids, points.id, became)[of_body]
        new, seen = _looked_for(body, poses, points, ids, owner, detection, images, method)
        ids[(ids >= 0) & _short(ids) & np.isin(detection, seen[seen >= 0]).any(0) & ~of_body[points.id]] = -1
        found, own = found.plus(new), np.concatenate([own, seen], 1)
    ids[_remains(ids, points.id, max(method.min_duration / T, 4))] = -1
    return RigidPass(ids, found, own, became)


def _of_images(images: Images, F: Floats, frame: int, gate: float) -> Floats:
    """(n, 3) mm that the images of a frame make, whosever they are."""
    return find_candidate_points(images, images.usable, F, [frame], gate).xyz.T


def _tracks_of(placed: InPlace, points: TrackPoints, n: int) -> Bools:
    """(n) the tracks that are a body's (1)."""
    inside = np.bincount(points.id[placed.member >= 0], minlength=n)
    return (inside > 0) & (inside >= OF_BODY * (inside + np.bincount(points.id[placed.off], minlength=n)))


def _may_break(body: RigidBody, points: TrackPoints, rows: NDArray[np.int32], of: Bools) -> bool:
    """Whether K members could have many tracks (0) of those `of`, if all points where tracks show no pose were inside.

    Poses among the other points, which are looked for then, take most of the pass, and nearly all bodies hold.
    """
    poses = by_tracks(body, points, rows)
    placed = in_place(body, poses, points)
    open_or_inside = np.where(poses.fit[points.frame] > 0, placed.member >= 0, True)
    most, off = (np.bincount(points.id[which], minlength=len(of)) for which in (open_or_inside, placed.off))
    return bool((of & (most > 0) & (most >= OF_BODY * (most + off))).sum() >= BREAKS * len(body.shape))


def _breaks(placed: InPlace, of_body: Bools, points: TrackPoints, K: int) -> bool:
    """Whether K members have many tracks, few points of which lie off their places (0)."""
    off = placed.off[of_body[points.id]].mean() if of_body.any() else 1.0
    return bool(of_body.sum() >= BREAKS * K and off < MOST_OFF)


def _owners(placed: InPlace, points: TrackPoints, K: int, n: int) -> Ints:
    """(K) the track that each member is, −1 where there is none."""
    count = np.zeros((K, n))
    some = placed.member >= 0
    np.add.at(count, (placed.member[some], points.id[some]), 1.0)
    member, track = scipy.optimize.linear_sum_assignment(count, maximize=True)
    out = np.full(K, -1)
    out[member] = np.where(count[member, track] > 0, track, -1)
    return out


def _identities(placed: InPlace, points: TrackPoints, poses: Poses, of_body: Bools, owner: Ints, ids: Ints) -> Ints:
    """(P) the track of each point, by (1) and (2); −1 for none."""
    out, member = ids.copy(), placed.member
    whose = np.flatnonzero(of_body[points.id])
    order = whose[np.lexsort([points.frame[whose], points.id[whose]])]
    inside = np.flatnonzero(member[order] >= 0)
    right = np.minimum(np.searchsorted(inside, np.arange(len(order))), len(inside) - 1)
    left = np.maximum(right - 1, 0)
    frame, id = points.frame[order], points.id[order]
    far = [
        np.where(id[inside[one]] == id, np.abs(frame[inside[one]] - frame), np.iinfo(np.int64).max)
        for one in (left, right)
    ]
    out[order] = owner[member[order[inside[np.where(far[0] < far[1], left, right)]]]]
    wrong = placed.off & of_body[points.id] & (poses.fit[points.frame] >= STRONG)
    taken = np.zeros((len(owner), len(poses.fit)), bool)
    taken[member[member >= 0], points.frame[member >= 0]] = True
    number = np.full(int(max(out.max(initial=-1), owner.max())) + 1, -1)
    number[owner] = np.arange(len(owner))
    k = np.where(out >= 0, number[out], -1)
    twice = (member < 0) & of_body[points.id] & (k >= 0) & taken[k, points.frame]
    out[wrong | twice] = -1
    return out


def _most(ids: Ints, former: Ints, became: Ints) -> Ints:
    """(N) what most points of each former track now are; as before for those without any."""
    some = ids >= 0
    count = scipy.sparse.coo_array((np.ones(some.sum()), (former[some], ids[some])), (len(became), len(became))).tocsr()
    has = np.diff(count.indptr) > 0
    return np.where(has, np.asarray(count.argmax(axis=1)).ravel(), became)


def _short(ids: Ints) -> Bools:
    """(P) points of tracks of fewer than LONG."""
    return (ids < 0) | (np.bincount(ids[ids >= 0], minlength=int(ids.max(initial=0)) + 1)[ids] < LONG)


def _remains(ids: Ints, former: Ints, least: float) -> Bools:
    """(P) points of tracks that lost some, and have fewer than a track has at least."""
    lost = np.bincount(former, ids != former) > 0
    left = np.bincount(ids[ids >= 0], minlength=len(lost))
    return np.asarray((ids >= 0) & (lost & (left < least))[ids])


def _looked_for(
    body: RigidBody,
    poses: Poses,
    points: TrackPoints,
    ids: Ints,
    owner: Ints,
    detection: Ints,
    images: Images,
    method: Simultaneous,
) -> tuple[TrackPoints, Ints]:
    """Points of members that have none in a frame with a pose, and their detections (C, n), by (3)."""
    lacks = np.zeros((len(poses.fit), len(owner)), bool)
    lacks[poses.fit > 0] = True
    for member, track in enumerate(owner.tolist()):
        lacks[points.frame[ids == track], member] = False
    frame, k = np.nonzero(lacks)
    at = member_places(body, poses, frame)[np.arange(len(frame)), k]
    sd = np.maximum(np.hypot(body.sd[k], poses.rms[frame]), LEAST_SD)
    held = detection[:, (ids >= 0) & (~_short(ids) | np.isin(ids, owner))]
    free = images.usable.copy()
    free[held[held >= 0]] = False
    expected = initial_states(
        at.T, sd**2 * np.eye(3)[..., None], speed=method.velocity_sd, acceleration=method.acceleration_sd
    )
    seen = predict_images(images.P, expected)
    association = associate(images, free, frame, seen, method.gate)
    after = update(expected, *information(images, seen, association))
    own = without_outliers(images, method.gate, expected, seen, association, after).association.detection
    place = intersect(images, own)
    xyz, cov = place.xyz.T, place.cov.transpose(2, 0, 1)
    good = ((own >= 0).sum(0) >= 2) & np.isfinite(xyz).all(1) & np.isfinite(cov).all((1, 2))
    wide = np.sqrt(sd**2 + np.trace(np.nan_to_num(cov), axis1=1, axis2=2) / 3)
    good &= np.linalg.norm(xyz - at, axis=1) < np.minimum(body.reach[k], GATE * wide)
    return TrackPoints(frame, owner[k], xyz, cov).take(good), own[:, good]
