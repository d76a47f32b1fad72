"""Tracks mended by facts: what people said of some points holds, and the rest is tracked again around it.

Facts are of points, images and places: this point is that marker, this one is none, this image is that marker's, here
the marker was. They part and join what the tracker made:

    points that are wrong go, and their images are free                                   (1)
    a track parts where what is said of it changes; pieces of one marker are one           (2)
    pieces that facts left alone are stitched, to each other and to markers (`stitch`)     (3)
    points that are missing are looked for with both sides known (`second_pass`)           (4)

so that a fact reaches beyond the samples that it is about: (3) gives what is cut off from one marker to the one whose
it is, and (4) the freed images to those that lacked them. No point that a fact is about is changed, nor any of a track
that no fact touches: such tracks may only gain points, of images that facts set free. A cut is where people put it:
points beside it are not looked for again, as what was cut off is then stitched less surely (studies/track_again.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...data import Cloud, Detections, Rig, Tracks
from ...data.array_types import Bools, Ints
from ...geometry.weighted_points import DEFAULT_ERRORS, ImageErrors, usable_points
from ...signal.common_time import moved_in_time
from .detection_index import Images, read_images
from .following.candidate_points import fundamentals
from .following.motion_scale import with_learned_motion
from .joining.stitch import CLEAR_MARGIN, Stitch, stitched
from .learned_delays import SeenTracks, late_images
from .noise.measurement_noise import Noise, learn_noise
from .points.neighbouring_points import TrackPoints
from .points.second_pass import points_between
from .points.solved_points import Working, precise_enough, solved, solver_for
from .simultaneous_method import DEFAULT, Simultaneous
from .simultaneous_tracking import VOLUME_MARGIN

UNSAID, NO_MARKER = -1, -2
"""What is said of a point that is of no marker by its number; by definition."""


@dataclass(frozen=True, slots=True, eq=False)
class Facts:
    """What people said of the P points of some tracks, and of D images.

    Attributes:
        marker: (P) number of the marker that each point is, UNSAID or NO_MARKER.
        said: (P) number of what was said of it, the same for points that one statement is about; −1 for nothing.
        wrong: (P) points that are erased.
        owner: (D) number of the marker whose an image is, UNSAID or NO_MARKER.
        places: where markers were, by people; `id` is the number of the marker.
    """

    marker: Ints
    said: Ints
    wrong: Bools
    owner: Ints
    places: TrackPoints

    @property
    def spoken(self) -> Bools:
        """(P) points that are a marker's by a fact."""
        return self.marker >= 0


class Mended(NamedTuple):
    """The tracks; of each of the tracks before, the one that has most of it, −1 where it is gone (N)."""

    tracks: Tracks
    became: Ints


class _Pieces(NamedTuple):
    """Tracks in pieces.

    Attributes:
        id: (P) the piece of each point, −1 where it is gone. track: (N) that each piece is of.
        marker: (N) that it is by a fact. touched: (N) whether facts cut it or are about it.
        cut: (K, 2) pieces of one track that follow each other.
    """

    id: Ints
    track: Ints
    marker: Ints
    touched: Bools
    cut: Ints


def mended_tracks(
    detections: Detections,
    rig: Rig,
    tracks: Tracks,
    facts: Facts,
    *,
    method: Simultaneous = DEFAULT,
    errors: ImageErrors = DEFAULT_ERRORS,
    volume_margin: float | None = VOLUME_MARGIN,
) -> Mended:
    """The tracks with all facts held, and what follows from them.

    Args:
        detections, rig: behind the tracks, the cameras as they were solved with (`TrackingResult.rig`).
        tracks: by whichever method, with the images of their points.
        facts: about their points. method, errors, volume_margin: as `track_simultaneously` has them.
    """
    if not len(tracks):
        return Mended(tracks, np.zeros(0, np.int64))
    timed, working, method = tracked_images(detections, rig, tracks, method)
    images = working.images
    cloud, changed = _with_owned_images(tracks.cloud, facts, working, timed, errors)
    gone = (facts.marker == NO_MARKER) | facts.wrong | (tracks.id < 0) | ((cloud.detection >= 0).sum(1) < 2)
    pieces = _pieces(tracks, facts, gone)
    left = ~gone
    known = _known(cloud, pieces.id, left, facts, pieces)
    group = _groups(known, pieces, 1 / detections.rate, method)
    free = np.zeros(len(images.uv), bool)
    lost = np.concatenate([tracks.cloud.detection[~left].ravel(), changed])
    free[lost[lost >= 0]] = True
    usable = images._replace(usable=images.usable & (facts.owner == UNSAID))
    found = _found(known._replace(id=group[known.id]), cloud, left, usable, 1 / detections.rate, method)
    touched = np.zeros(int(group.max(initial=-1)) + 1, bool)
    touched[group[pieces.touched | (np.bincount(group, minlength=len(group))[group] > 1)]] = True
    new, ids = _good(found, touched, free, working, timed, errors, volume_margin, method)
    return _numbered(tracks, cloud.keep(left), group[pieces.id[left]], new, ids, left)


def tracked_images(
    detections: Detections, rig: Rig, tracks: Tracks, method: Simultaneous
) -> tuple[Detections, Working, Simultaneous]:
    """What tracks were made of, as the tracker sees it: detections in time, images with their noise, and motion."""
    images, noise, method = _prepared(detections, rig, method)
    timed = _in_time(detections, images, tracks, method)
    if timed is not detections:
        images, noise, method = _prepared(timed, rig, method)
    return timed, Working(rig, images, noise), method


def _prepared(detections: Detections, rig: Rig, method: Simultaneous) -> tuple[Images, Noise, Simultaneous]:
    """Images and their noise, and how markers move, as the tracker learns them."""
    images, noise = learn_noise(images := read_images(detections, rig), fundamentals(images.P), method.gate)
    learned = with_learned_motion(images.without(noise.inconsistent), detections.rate, method)
    return learned.images, noise, learned.method


def _in_time(detections: Detections, images: Images, tracks: Tracks, method: Simultaneous) -> Detections:
    """Detections at the times of the frames, where the tracks show that cameras are not synchronous."""
    late = late_images(SeenTracks(tracks, images)) if method.learn_delays else None
    return detections if late is None else moved_in_time(detections, late)


def _with_owned_images(
    cloud: Cloud, facts: Facts, working: Working, detections: Detections, errors: ImageErrors
) -> tuple[Cloud, Ints]:
    """The points without the images that are another's by a fact, solved again; and these images."""
    owner = np.where(cloud.detection >= 0, facts.owner[cloud.detection], UNSAID)
    taken = (owner != UNSAID) & (owner != facts.marker[:, None])
    rows = np.flatnonzero(taken.any(1))
    if not len(rows):
        return cloud, np.zeros(0, np.int64)
    detection = np.where(taken, -1, cloud.detection)
    solver = solver_for(detections, np.zeros(len(facts.owner), bool), working, errors)
    again = solved(cloud.frame[rows], detection[rows].T, cloud.xyz[rows].T, solver)
    xyz, cov, residual = cloud.xyz.copy(), cloud.cov.copy(), cloud.residual.copy()
    good = np.isfinite(again.xyz).all(1)
    xyz[rows[good]], cov[rows[good]], residual[rows[good]] = again.xyz[good], again.cov[good], again.residual[good]
    detection[rows[~good]] = -1
    return replace(cloud, xyz=xyz, cov=cov, residual=residual, detection=detection), cloud.detection[taken]


def _pieces(tracks: Tracks, facts: Facts, gone: Bools) -> _Pieces:
    """The tracks cut where what is said of them changes (2); points of no marker cut nothing."""
    frame, id = tracks.cloud.frame, np.full(len(gone), -1)
    rows = np.flatnonzero(~gone)
    rows = rows[np.lexsort([frame[rows], tracks.id[rows]])]
    track, said = tracks.id[rows], facts.said[rows]
    new = np.ones(len(rows), bool)
    new[1:] = (track[1:] != track[:-1]) | (said[1:] != said[:-1])
    id[rows] = np.cumsum(new) - 1
    first = np.flatnonzero(new)
    follows = np.flatnonzero(track[first][1:] == track[first][:-1])
    cut = np.stack([follows, follows + 1], 1)
    marker = facts.marker[rows][first]
    touched = marker >= 0
    touched[cut] = True
    return _Pieces(id, track[first], marker, touched, cut)


def _known(cloud: Cloud, piece: Ints, left: Bools, facts: Facts, pieces: _Pieces) -> TrackPoints:
    """The points that are left, and after them the places by hand of markers that have a piece."""
    points = TrackPoints(cloud.frame[left], piece[left], cloud.xyz[left], cloud.cov[left])
    frame, xyz, cov = points.frame, points.xyz.copy(), points.cov.copy()
    extra: list[int] = []
    of, places = np.full(len(facts.places.id), -1), facts.places
    for k, number in enumerate(places.id.tolist()):
        own = np.flatnonzero(pieces.marker == number)
        if not len(own):
            continue
        same = np.flatnonzero(np.isin(points.id, own) & (frame == places.frame[k]))
        if len(same):
            xyz[same[0]], cov[same[0]] = places.xyz[k], places.cov[k]
            continue
        near = np.flatnonzero(np.isin(points.id, own))
        if len(near):
            of[k] = points.id[near[np.abs(frame[near] - places.frame[k]).argmin()]]
            extra.append(k)
    points = TrackPoints(points.frame, points.id, xyz, cov)
    return points.plus(TrackPoints(places.frame, of, places.xyz, places.cov).take(np.array(extra, int)))


def _groups(known: TrackPoints, pieces: _Pieces, T: float, method: Simultaneous) -> Ints:
    """(N) the identity of each piece: of its marker, and of what it is stitched to (3)."""
    n = len(pieces.track)
    group = np.arange(n)
    for number in np.unique(pieces.marker[pieces.marker >= 0]).tolist():
        own = np.flatnonzero(pieces.marker == number)
        group[own] = own[0]
    if not pieces.touched.any():
        return group
    there = np.zeros((n, int(known.frame.max(initial=0)) + 1), bool)
    there[known.id, known.frame] = True
    whole = np.zeros_like(there)
    np.logical_or.at(whole, group, there)
    meet = (whole[group].astype(np.float32) @ whole[group].astype(np.float32).T) > 0
    both = (pieces.marker[:, None] >= 0) & (pieces.marker >= 0)
    apart = meet | both | (group[:, None] == group) | ~(pieces.touched[:, None] | pieces.touched)
    apart[pieces.cut[:, 0], pieces.cut[:, 1]] = True
    links = [one for one in stitched(known, T, method, apart=apart).stitches if one.margin > CLEAR_MARGIN]
    return _joined(group, pieces.marker, whole, links)


def _joined(group: Ints, marker: Ints, there: Bools, links: list[Stitch]) -> Ints:
    """The groups after links, the clearest first; none that would be two markers, or twice in a frame."""
    number = np.full(len(group), UNSAID)
    number[group] = np.maximum(number[group], marker)
    for link in sorted(links, key=lambda one: -one.margin):
        a, b = int(group[link.before]), int(group[link.after])
        if a == b or (number[a] >= 0 and number[b] >= 0) or (there[a] & there[b]).any():
            continue
        there[a] |= there[b]
        number[a] = max(number[a], number[b])
        group[group == b] = a
    return group


def _found(
    known: TrackPoints, cloud: Cloud, left: Bools, images: Images, T: float, method: Simultaneous
) -> tuple[TrackPoints, Ints]:
    """Points that were missing, and their detections (C, N) (4)."""
    detection = cloud.detection[left].T
    extra = np.full((len(detection), len(known.id) - detection.shape[1]), -1)
    return points_between(known, np.concatenate([detection, extra], 1), images, T, method)


def _good(
    found: tuple[TrackPoints, Ints],
    touched: Bools,
    free: Bools,
    working: Working,
    detections: Detections,
    errors: ImageErrors,
    volume_margin: float | None,
    method: Simultaneous,
) -> tuple[Cloud, Ints]:
    """The points found that are good enough, and their identities; of untouched tracks those of freed images alone."""
    points, detection = found
    order = np.argsort(points.frame, kind="stable")
    detection, ids = detection[:, order], points.id[order]
    solver = solver_for(detections, np.zeros(len(free), bool), working, errors)
    new = solved(points.frame[order], detection, points.xyz[order].T, solver)
    own = ((detection >= 0) & ~working.images.merged[detection]).sum(0)
    good = usable_points(new, working.rig, margin=volume_margin) & precise_enough(new.cov, own, method)
    good &= touched[ids] | (free[detection] & (detection >= 0)).any(0)
    return new.keep(good), ids[good]


def _numbered(tracks: Tracks, cloud: Cloud, ids: Ints, new: Cloud, new_ids: Ints, left: Bools) -> Mended:
    """All points by frame, with tracks numbered as those whose most they have were."""
    frame, every = np.concatenate([cloud.frame, new.frame]), np.concatenate([ids, new_ids])
    order = np.argsort(frame, kind="stable")
    start = np.searchsorted(frame[order], np.arange(cloud.n_frames + 1))
    names = ("xyz", "cov", "residual", "detection")
    columns = (np.concatenate([getattr(cloud, name), getattr(new, name)])[order] for name in names)
    groups = np.unique(every)
    before = tracks.id[left]
    count = np.zeros((len(tracks), len(groups)), np.int64)
    np.add.at(count, (before, np.searchsorted(groups, ids)), 1)
    rank = np.argsort(np.argsort([(count[:, g].argmax() << 32) + g for g in range(len(groups))]))
    became = np.where(count.any(1), rank[count.argmax(1)] if len(groups) else -1, -1)
    number = rank[np.searchsorted(groups, every)]
    return Mended(Tracks(Cloud(cloud.rate, start, *columns), number[order]), became)
