"""Tracks through all frames, forwards and then backwards from where each began."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.array_types import Bools, Floats, Ints
from ...data.progress import tell
from ...native import inverse
from .associate import Association, PredictedImages, associate, information, predict_images, share
from .candidate_points import CandidatePoints, fundamentals
from .detection_index import Images
from .initiate import initiate
from .kalman_states import KalmanStates, at_rest, predict, update
from .simultaneous_method import Simultaneous

LANES = 8
"""Stretches that are gone through side by side: NumPy's overhead is then shared by eight times as many tracks.
Chosen."""

LANE = 64
"""Frames of a stretch at least; each begins with all its tracks to be born; chosen (see benchmarks/tracking.py)."""

LOST = 2.0
"""A track of which two cameras see nothing ends where its place is known no better than to this many times `max_sd`: it
could then be taken up by another marker's images, and whether it goes on is for `joins` to decide, which knows what
came afterwards; chosen."""

LEFT = 0.05
"""Of an image's variance, the least that is left beside the place's: an image that alone says where a track is agrees
with itself; chosen (see benchmarks/tracking.py)."""

ROUNDS = 3
"""Images at most that a track gives back in one frame; chosen (see benchmarks/tracking.py)."""


class ActiveTracks(NamedTuple):
    """T tracks that go on: id, frame and alone, the frames since two cameras saw them (T) each; and their motion."""

    id: Ints
    frame: Ints
    alone: Ints
    motion: KalmanStates

    def take(self, which: Bools) -> ActiveTracks:
        """Only these."""
        return ActiveTracks(self.id[which], self.frame[which], self.alone[which], self.motion.take(which))

    def plus(self, other: ActiveTracks) -> ActiveTracks:
        """These and others after them."""
        old, new = self[:3], other[:3]
        id, frame, alone = (np.concatenate(pair) for pair in zip(old, new, strict=True))
        return ActiveTracks(id, frame, alone, self.motion.plus(other.motion))


class Associations(NamedTuple):
    """S times that a track was looked for.

    Attributes:
        frame, id: (S).
        row: (C, S) of `Images`, −1 for none; shared: (C, S) whether another track has the image too.
        squared: (S) how far its own images are off in all, in standard deviations, squared.
        before: (S) the standard deviation of where it was expected, of all three axes together, mm.
        xyz, cov: (3, S) mm and (3, 3, S) mm², where it is then thought to be.
    """

    frame: Ints
    id: Ints
    row: Ints
    shared: Bools
    squared: Floats
    before: Floats
    xyz: Floats
    cov: Floats

    def take(self, which: NDArray[Any]) -> Associations:
        """Only these."""
        return Associations(
            self.frame[which],
            self.id[which],
            self.row[:, which],
            self.shared[:, which],
            self.squared[which],
            self.before[which],
            self.xyz[:, which],
            self.cov[..., which],
        )


class PassFit(NamedTuple):
    """Association, the tracks with them, and how far the images of each are off, as `Associations.squared`."""

    claims: Association
    after: KalmanStates
    squared: Floats


class Run:
    """A run over a recording: its images, which of them are free, and what was seen."""

    def __init__(self, images: Images, rate: float, method: Simultaneous) -> None:
        self.images, self.method, self.T = images, method, 1 / rate
        self.free = images.usable.copy()
        self.F = fundamentals(images.P)
        self.seen: list[Associations] = []
        self.born = self.nobody()
        self.n = 0

    def whole(self) -> Associations:
        """All tracks, forwards in each stretch, then backwards from where they began."""
        stride = max(round(self.method.initiation_interval / self.T), 1)
        first = self.stretches()
        length = int(np.diff(first).max())
        active = self.nobody()
        for k in range(length):
            tell(k, 2 * length)
            active = active._replace(frame=active.frame + 1)
            active = self.step(active.take(active.frame < self.images.n_frames))
            if k >= 2 and ((k - 2) % stride == 0 or k == length - 1):
                active = active.plus(self.begin([int(f) + k for f in first[:-1] if f + k < self.images.n_frames]))
        active = self.born
        while len(active.id):
            tell(length, 2 * length)
            active = active._replace(frame=active.frame - 1)
            active = self.step(active.take(active.frame >= 0))
        if not self.seen:
            return _nothing(len(self.images.P))
        return Associations(*(np.concatenate(column, -1) for column in zip(*self.seen, strict=True)))

    def stretches(self) -> Ints:
        """Frames at which the stretches begin that are gone through side by side, and the number of frames."""
        n = self.images.n_frames
        count = int(np.clip(n // LANE, 1, LANES))
        return np.minimum(np.arange(count + 1) * -(-n // count), n)

    def nobody(self) -> ActiveTracks:
        """No tracks."""
        zero = np.zeros(0, np.int64)
        return ActiveTracks(zero, zero, zero, KalmanStates(np.zeros((9, 0)), np.zeros((9, 9, 0))))

    def begin(self, lasts: list[int]) -> ActiveTracks:
        """New tracks of the three frames that end with each of `lasts`."""
        active = self.nobody()
        for born in initiate(self.images, self.free, self.F, lasts, self.T, self.method):
            ids = np.arange(self.n, self.n + len(born))
            self.n += len(born)
            for group in born.groups:
                self.free[group.row[group.row >= 0]] = False
                none = np.zeros(group.row.shape, bool)
                wide = np.sqrt(np.trace(group.cov))
                self.seen.append(
                    Associations(group.frame, ids, group.row, none, group.squared, wide, group.xyz, group.cov)
                )
            self.born = self.born.plus(self.started(ids, born.groups[::-1]))
            active = active.plus(self.started(ids, born.groups))
        return active

    def started(self, ids: Ints, groups: tuple[CandidatePoints, ...]) -> ActiveTracks:
        """New tracks at the last of their three points, in the order given."""
        first, *others = groups
        motion = at_rest(first.xyz, first.cov, speed=self.method.velocity_sd, acceleration=self.method.acceleration_sd)
        for group in others:
            motion = predict(motion, self.T, self.method.process_noise)
            N = inverse(group.cov)
            motion = update(motion, N, np.einsum("ijt,jt->it", N, group.xyz - motion.position))
        return ActiveTracks(ids, others[-1].frame, np.zeros(len(ids), np.int64), motion)

    def step(self, active: ActiveTracks) -> ActiveTracks:
        """The tracks one frame on."""
        if not len(active.id):
            return active
        images, gate = self.images, self.method.gate
        motion = predict(active.motion, self.T, self.method.process_noise)
        expected = predict_images(images.P, motion)
        claims = associate(images, self.free, active.frame, expected, gate)
        claims = share(images, active.frame, expected, claims, gate)
        after = update(motion, *information(images, expected, claims))
        claims, after, squared = without_loose(images, gate, motion, expected, claims, after)
        has = claims.row >= 0
        self.free[claims.row[has]] = False
        own, count = (has & ~claims.shared).sum(0), has.sum(0)
        before = np.sqrt(np.trace(motion.cov))
        self.seen.append(
            Associations(active.frame, active.id, claims.row, claims.shared, squared, before, after.position, after.cov)
        )
        alone = np.where((own >= 1) & (count >= 2), 0, active.alone + 1)
        lost = np.sqrt(np.trace(after.cov)) > LOST * self.method.max_sd
        alive = (alone <= self.method.max_coasting / self.T) & ~((alone > 0) & lost)
        active = ActiveTracks(active.id, active.frame, alone, after)
        return active if alive.all() else active.take(alive)


def without_loose(
    images: Images,
    gate: float,
    before: KalmanStates,
    expected: PredictedImages,
    claims: Association,
    after: KalmanStates,
) -> PassFit:
    """The claims without images that do not fit the others of their track, and the tracks without them."""
    for _ in range(ROUNDS):
        has = claims.row >= 0
        seen = predict_images(images.P, after)
        off = np.where(has[:, None], images.uv[claims.row].swapaxes(1, 2) - seen.uv, 0.0)
        squared = (off * off).sum(1) / claims.variance
        alone = _without_itself(off, claims.variance, seen.S)
        loose = (alone > gate**2) & (has.sum(0) >= 2)
        if not loose.any():
            break
        wrong = (alone == alone.max(0)) | (has.sum(0) == 2)  # of two, nobody knows which it is
        wrong &= has & loose.any(0)
        row, variance = np.where(wrong, -1, claims.row), np.where(wrong, np.inf, claims.variance)
        claims = claims._replace(row=row, variance=variance, worth=np.where(row < 0, 0.0, claims.worth))
        after = update(before, *information(images, expected, claims))
    not_own = claims.shared | images.merged[claims.row]
    return PassFit(claims, after, np.where(not_own, 0.0, squared).sum(0))


def _without_itself(off: Floats, variance: Floats, S: Floats) -> Floats:
    """(C, T) how far images are off what all the others say, squared, in standard deviations.

    off (C, 2, T) px from where they are seen with their own help, which leaves of their variance (C, T) what is not in
    S (C, 3, T), the place's.
    """
    v = np.where(np.isfinite(variance), variance, 1.0)
    a, b, d = np.maximum(v - S[:, 0], LEFT * v), -S[:, 1], np.maximum(v - S[:, 2], LEFT * v)
    det = np.maximum(a * d - b * b, (LEFT * v) ** 2)
    x, y = off.swapaxes(0, 1)
    return np.where(np.isfinite(variance), (d * x * x - 2 * b * x * y + a * y * y) / det, 0.0)


def _nothing(C: int) -> Associations:
    """No images."""
    zero, none = np.zeros(0, np.int64), np.zeros(0)
    row = np.zeros((C, 0), np.int64)
    return Associations(zero, zero, row, row > 0, none, none, np.zeros((3, 0)), np.zeros((3, 3, 0)))


def run(images: Images, rate: float, method: Simultaneous) -> Associations:
    """All tracks of a recording."""
    return Run(images, rate, method).whole()
