"""A second pass over what the first was not sure of, with the frames before and after known.

The run knows of a track only what was before, and looks for new ones not in every frame; so it may miss what two
cameras see for a moment, or take a wrong image. Once tracks are whole, a frame in question has known points of its
track before and after it. The motion of each side is taken on to the frame, and where both lead to, by (1) of
`neighbouring_points`, images are associated as in the first pass (`associate`), among those that no known point has. In
question are

- points of two images, known being those of SOUND and more: they are wrong where they do not lie where both sides lead
  to, or where SOUND images are associated instead (1);
- frames without a point between known points, and for a while after a track's last and before its first; these only
  where three cameras ever saw it, as a chance meeting of two images also goes on. Two associated images make a point
  (2).

What is found leads farther on, so (2) is done ITERATIONS times.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data.array_types import Bools, Ints
from ....data.progress import tell
from ....native import inverse
from ....numerics.returned_memory import return_memory
from ..detection_index import Images
from ..following.associate import associate, information, predict_images
from ..following.candidate_points import intersect
from ..following.kalman_states import KalmanStates, predict, reversed_time, update
from ..following.passes import without_outliers
from ..simultaneous_method import Simultaneous
from .neighbouring_points import LOOK, RowsByTrack, TrackPoints, between, motion_from, parts_of_frames, rows_near

ITERATIONS = 3  # times in turn; chosen: the third finds hardly anything new

SOUND = 3
"""Images of a point that is not in question; chosen (see benchmarks/tracking.py)."""

AT_ONCE = 5_000
"""Frames of tracks that are computed in one go, and the rest of the last frame; more would take memory; chosen."""


class SecondPass(NamedTuple):
    """Which of P points are kept (P), and points that were found, with their detections (C, N)."""

    kept: Bools
    found: TrackPoints
    detection: Ints


class KnownPoints(NamedTuple):
    """N points: `row` (n) of some of `points`, then all of those that were `found`; frame and id (N) of each, and
    `rows`, the place of each track in each frame. Copies of all that is known would take much memory."""

    points: TrackPoints
    row: Ints
    found: TrackPoints
    frame: Ints
    id: Ints
    rows: RowsByTrack

    @classmethod
    def of(cls, points: TrackPoints, kept: Bools, found: TrackPoints) -> KnownPoints:
        """Of the points those that are kept (P), and others."""
        frame, id = (np.concatenate([a[kept], b]) for a, b in ((points.frame, found.frame), (points.id, found.id)))
        return cls(points, np.flatnonzero(kept), found, frame, id, RowsByTrack.of(frame, id))

    def take(self, place: Ints) -> TrackPoints:
        """Those at some places (k), which rise."""
        n = len(self.row)
        old = place[: np.searchsorted(place, n)]
        return self.points.take(self.row[old]).plus(self.found.take(place[len(old) :] - n))


class FramesInQuestion(NamedTuple):
    """N frames of tracks id in question, and the known points before and after each, −1 for none; all (N)."""

    id: Ints
    frame: Ints
    before: Ints
    after: Ints

    def take(self, which: Bools | Ints) -> FramesInQuestion:
        """Only these."""
        return FramesInQuestion(*(column[which] for column in self))


def second_pass(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> SecondPass:
    """The second pass over the tracks of P points with the detections (C, P)."""
    sound = (detection >= 0).sum(0) >= SOUND
    kept = ~_wrong(points, sound, detection, images, T, method)
    return_memory()
    found, own = points_between(points, detection, images, T, method, kept=kept, seen=points.id[sound])
    return SecondPass(kept, found, own)


def points_between(
    points: TrackPoints,
    detection: Ints,
    images: Images,
    T: float,
    method: Simultaneous,
    *,
    kept: Bools | None = None,
    seen: Ints | None = None,
) -> tuple[TrackPoints, Ints]:
    """Points by (2), and their detections (C, N), of tracks of P points with detections (C, P).

    Args:
        kept: (P) which of the points are known; all where None.
        seen: tracks that three cameras ever saw; by the known points where None.
    """
    kept = np.ones(len(points.id), bool) if kept is None else kept
    seen = points.id[kept & ((detection >= 0).sum(0) >= SOUND)] if seen is None else seen
    found, own = points.take(np.zeros(0, np.int64)), detection[:, :0]
    for _ in range(ITERATIONS):
        return_memory()
        known = KnownPoints.of(points, kept, found)
        in_question = _in_question(known, images.n_frames, T, method)
        inside = (in_question.before >= 0) & (in_question.after >= 0)
        in_question = in_question.take(inside | np.isin(in_question.id, seen))
        return_memory()
        free, associated = _free(images, detection, own, kept), np.empty((len(own), len(in_question.id)), np.int64)
        for part in parts_of_frames(in_question.frame, AT_ONCE):  # the images of a frame are associated together
            tell(1, 2)
            expected = _expected(known, in_question.take(part), T, method)
            associated[:, part] = images_where_expected(images, free, in_question.frame[part], expected, method)
        place = intersect(images, associated)
        new = TrackPoints(in_question.frame, in_question.id, place.xyz.T, place.cov.transpose(2, 0, 1))
        good = ((associated >= 0).sum(0) >= 2) & np.isfinite(new.xyz).all(1) & np.isfinite(new.cov).all((1, 2))  # (2)
        if not good.any():
            break
        found, own = found.plus(new.take(good)), np.concatenate([own, associated[:, good]], 1)
    return found, own


def expected_between(points: TrackPoints, n_frames: int, T: float, method: Simultaneous) -> TrackPoints:
    """Where tracks are expected in frames without a point between two of theirs, one of which is at most LOOK away."""
    known = KnownPoints.of(points, np.ones(len(points.id), bool), points.take(np.zeros(0, np.int64)))
    gaps = _in_question(known, n_frames, T, method)
    gaps = gaps.take((gaps.before >= 0) & (gaps.after >= 0))
    away = np.minimum(gaps.frame - known.frame[gaps.before], known.frame[gaps.after] - gaps.frame)
    gaps = gaps.take(away <= LOOK)
    found = [points.take(np.zeros(0, np.int64))]
    for part in parts_of_frames(gaps.frame, AT_ONCE):
        some = gaps.take(part)
        motion = _expected(known, some, T, method)
        found.append(TrackPoints(some.frame, some.id, motion.position.T, motion.cov.transpose(2, 0, 1)))
    return TrackPoints(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _wrong(points: TrackPoints, sound: Bools, detection: Ints, images: Images, T: float, method: Simultaneous) -> Bools:
    """(P) by (1), from the sound points (P)."""
    known = KnownPoints.of(points, sound, points.take(np.zeros(0, np.int64)))
    wrong = np.zeros(len(sound), bool)
    in_question = _in_question(known, images.n_frames, T, method)
    at = RowsByTrack.of(points.frame, points.id).at(in_question.id, in_question.frame)
    in_question, at = in_question.take(at >= 0), at[at >= 0]
    return_memory()
    held = np.ones(len(sound), bool)
    held[at] = False
    free = _free(images, detection, detection[:, :0], held)
    for part in parts_of_frames(in_question.frame, AT_ONCE):
        own, expected = at[part], _expected(known, in_question.take(part), T, method)
        off = points.xyz[own].T - expected.position
        N = inverse(expected.cov + points.cov[own].transpose(1, 2, 0))
        elsewhere = (off * np.einsum("ijt,jt->it", N, off)).sum(0) > method.gate**2
        instead = images_where_expected(images, free, in_question.frame[part], expected, method)
        wrong[own] = elsewhere | ((instead >= 0).sum(0) >= SOUND)
    return wrong


def _free(images: Images, detection: Ints, more: Ints, kept: Bools) -> Bools:
    """(D) the usable images that none of the detections (C, P) of the kept points (P), nor of more (C, n), is."""
    free = images.usable.copy()
    for camera, others in zip(detection, more, strict=True):
        free[camera[kept & (camera >= 0)]] = False
        free[others[others >= 0]] = False
    return free


def _in_question(known: KnownPoints, n_frames: int, T: float, method: Simultaneous) -> FramesInQuestion:
    """The frames between known points of a track, and those soon after its last and before its first."""
    order = np.lexsort([known.frame, known.id])
    a, b = order[:-1], order[1:]
    step = known.frame[b] - known.frame[a]
    wait = round(method.max_coasting / T)
    short = (step * T <= method.max_gap) | (
        step <= 2 * wait + 1
    )  # the frames after one and before the other would meet
    near = (known.id[a] == known.id[b]) & short
    edge = np.ones(min(len(order), 1), bool)
    last, first = order[np.concatenate([~near, edge])], order[np.concatenate([edge, ~near])]
    none, near = np.full(len(last), -1), near & (step > 1)
    before, after = np.concatenate([a[near], last, none]), np.concatenate([b[near], none, first])
    left, right = np.minimum(wait, known.frame[first]), np.minimum(wait, n_frames - 1 - known.frame[last])
    count = np.concatenate([step[near] - 1, right, left])
    k = np.repeat(np.arange(len(count)), count)
    nth = np.arange(len(k)) - np.repeat(np.cumsum(count) - count, count) + 1
    own, way = np.where(before >= 0, before, after)[k], np.where(before >= 0, 1, -1)[k]
    return FramesInQuestion(known.id[own], known.frame[own] + way * nth, before[k], after[k])


def _expected(known: KnownPoints, in_question: FramesInQuestion, T: float, method: Simultaneous) -> KalmanStates:
    """What the known points on both sides, or on the only one, say of the motion in the frames in question."""
    sides = []
    for point, way in ((in_question.before, -1), (in_question.after, 1)):
        ends, which = np.unique(point, return_inverse=True)
        near = rows_near(known.rows, known.id[ends], known.frame[ends], way)
        number, local = np.unique(np.concatenate([ends, near.ravel()]), return_inverse=True)
        none = int(number[0] < 0)
        local, some = local.ravel() - none, known.take(number[none:])
        around, near = some.xyz[local[: len(ends)]].T, local[len(ends) :].reshape(near.shape)
        motion = motion_from(some, near, around, T, method).take(which)
        sides.append(predict(motion, np.abs(in_question.frame - known.frame[point]) * T, method.process_noise))
    before, after = sides[0], reversed_time(sides[1])
    both = between(before, after)
    one_sided = [in_question.after < 0, in_question.before < 0]
    return KalmanStates(*(np.select(one_sided, each[:2], each[2]) for each in zip(before, after, both, strict=True)))


def images_where_expected(
    images: Images, free: Bools, frame: Ints, expected: KalmanStates, method: Simultaneous
) -> Ints:
    """(C, N) the images associated in frames (N) that fit one another; none where the standard deviation exceeds
    `uncertain_sd`."""
    detection = np.full((len(images.P), len(frame)), -1)
    near = np.sqrt(np.trace(expected.cov)) < method.uncertain_sd
    expected = expected.take(near)
    seen = predict_images(images.P, expected)
    association = associate(images, free, frame[near], seen, method.gate)
    after = update(expected, *information(images, seen, association))
    detection[:, near] = without_outliers(images, method.gate, expected, seen, association, after).association.detection
    return detection
