"""Tracks through all frames, forwards and then backwards from where each began.

Where markers go from frame to frame about as far as they are apart, at SLOW rates, a new track that two frames in
succession of the PROOF after it do not show may be of images of several markers, or its marker is hidden there and is
followed back from where it is seen again. So it is set aside and its images are free again, for tracks that begin in
that frame: kept, they would leave those that are right without a beginning, frame after frame. It returns where, after
both passes, no other track has any of its images (1). One frame does not show a marker that flickers.

Where accelerations as expected bend a track from one marker to the next, the recording is *crowded*: with the median
d of the distances of the tracks that begin first to their nearest ones, LEAST_GATE a T² > d (2), a being that of people
also in a room whose scale is less (`room_scale`). There tracks begin that go to and fro between two markers, A B B A.
Each leaves those after it no three images of one marker in succession, so that they do the same. So there new tracks
are on trial at any rate, and one frame that does not show them is enough.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ....data.array_types import Bools, Floats, Ints
from ....data.progress import tell
from ....native import inverse
from ....numerics.returned_memory import return_memory
from ..detection_index import Images
from ..simultaneous_method import DEFAULT, Simultaneous
from .associate import Association, PredictedImages, associate, information, predict_images, share
from .candidate_points import CandidatePoints, fundamentals
from .initiate import LEAST_GATE, InitiatedTracks, initiate
from .kalman_states import KalmanStates, initial_states, predict, update

STRETCHES = 8
"""Stretches of the recording that are tracked side by side: NumPy's overhead is then shared by eight times as many
tracks. Chosen."""

MIN_STRETCH = 64
"""Frames of a stretch at least; each begins by initiating all its tracks; chosen (see benchmarks/tracking.py)."""

LOST_FACTOR = 2.0
"""A track that two cameras do not see is terminated where its standard deviation exceeds so many times `uncertain_sd`:
it could then take another marker's images. `stitch`, which knows what came afterwards, decides whether it goes on;
chosen."""

MIN_VARIANCE_SHARE = 0.05
"""Of an image's variance, the least that is left without the prediction's: an image that alone determines a track
agrees with itself; chosen (see benchmarks/tracking.py)."""

ROUNDS = 3
"""Images at most that are taken from a track as outliers in one frame; chosen (see benchmarks/tracking.py)."""


PROOF, UNSEEN = 4, 2
"""Frames of (1), no more than `max_coasting` has, and those in succession that do not show a track; chosen: two markers
in turn, A B B A, fit a parabola, and the points after it show it. Where it has fewer than two, as at 10 Hz, none is on
trial."""

SLOW = 0.03
"""s from frame to frame, from which new tracks are on trial; chosen: at 25 Hz it saves samples, ghosts and swaps. Seven
fresh scenes at 100 Hz and more (seeds 5302 to 5328 of benchmarks/tracking_scenes.py) have as many samples and ghosts
with it, three others (2109, 2147, 5204) 45 of 11 907 samples fewer and 25 ghosts more."""


class ActiveTracks(NamedTuple):
    """T active tracks: id, frame and alone, the frames since two cameras saw them (T) each; and their states."""

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
    """The images of tracks, S times a track in a frame.

    Attributes:
        frame, id: (S).
        detection: (C, S) index in `Images`, −1 for none, in four bytes: long recordings have many.
        shared: (C, S) whether another track has the image too.
        squared: (S) sum of the squared residuals of its unshared images, in standard deviations.
        before: (S) the standard deviation of its prediction, of all three axes together, mm.
        xyz, cov: (3, S) mm and (3, 3, S) mm², the updated position; no cov (3, 3, 0) where it has done its work.
    """

    frame: Ints
    id: Ints
    detection: Ints
    shared: Bools
    squared: Floats
    before: Floats
    xyz: Floats
    cov: Floats

    def take(self, which: NDArray[Any]) -> Associations:
        """Only these."""
        return Associations(*self.columns(which))

    @classmethod
    def of(cls, columns: list[NDArray[Any]], which: NDArray[Any]) -> Associations:
        """Only these, of columns that nobody else needs: each ends before the next one is in memory twice."""
        return cls(*(columns.pop(0)[..., which] for _ in cls._fields))

    def columns(self, which: NDArray[Any]) -> Iterator[NDArray[Any]]:
        """Each column of only these by itself, so that not all of them are in memory twice."""
        return (column[..., which] if column.size else column for column in self)


class PassFit(NamedTuple):
    """Association, the updated tracks, and their squared residuals as `Associations.squared`."""

    association: Association
    after: KalmanStates
    squared: Floats


class Run:
    """Both passes over a recording: its images, which of them are free, and the associations so far."""

    def __init__(self, images: Images, rate: float, method: Simultaneous, lasting: Floats | None = None) -> None:
        self.images, self.method, self.T, self.lasting = images, method, 1 / rate, lasting
        self.free = images.usable.copy()
        self.F = fundamentals(images.P)
        self.seen: list[Associations] = []
        self.initiated, self.crowded = self.no_tracks(), False
        self.n = 0
        self.aside: list[Associations] = []

    def whole(self) -> Associations:
        """All associations, forwards in each stretch, then backwards from where the tracks were initiated."""
        first = self.stretches()
        length = int(np.diff(first).max())
        self.go_forwards(first[:-1], length)
        aside = np.isin(self.initiated.id, [id for seen in self.aside for id in seen.id])
        self.go_backwards(self.initiated.take(~aside), length)
        self.go_backwards(self.returned(), length)
        return self.associations()

    def forwards(self, first: Ints, length: int) -> Associations:
        """Associations forwards in stretches of so many frames that begin at frames `first`."""
        self.go_forwards(first, length)
        return self.associations()

    def go_forwards(self, first: Ints, length: int) -> None:
        """Associate forwards in stretches of so many frames that begin at frames `first`."""
        stride = max(round(self.method.initiation_interval / self.T), 1)
        proof = int(min(self.method.max_coasting / self.T, PROOF))
        active, new = self.no_tracks(), deque([(0, 0)], max(proof, 1))
        for k in range(length):
            tell(k, 2 * length)
            active = active._replace(frame=active.frame + 1)
            active = self.proven(active.take(active.frame < self.images.n_frames), *new[0])
            new.append((self.n if proof >= 2 else np.iinfo(np.int64).max, len(self.seen)))  # none is on trial
            if k >= 2 and ((k - 2) % stride == 0 or k == length - 1):
                active = active.plus(self.begin([int(f) + k for f in first if f + k < self.images.n_frames]))
            if k == 2:  # all markers that are seen begin their tracks
                self.crowded = _crowded(active, self.T, self.method)

    def go_backwards(self, active: ActiveTracks, length: int) -> None:
        """Associate backwards from where tracks were initiated."""
        while len(active.id):
            tell(length, 2 * length)
            active = active._replace(frame=active.frame - 1)
            active = self.step(active.take(active.frame >= 0))

    def associations(self) -> Associations:
        """All that were made, which are then no longer kept here."""
        parts, self.seen = self.seen, []
        return _whole(parts) if parts else _nothing(len(self.images.P))

    def stretches(self) -> Ints:
        """First frames of the stretches that are tracked side by side, and the number of frames."""
        n = self.images.n_frames
        count = int(np.clip(n // MIN_STRETCH, 1, STRETCHES))
        return np.minimum(np.arange(count + 1) * -(-n // count), n)

    def no_tracks(self) -> ActiveTracks:
        """No tracks."""
        zero = np.zeros(0, np.int64)
        return ActiveTracks(zero, zero, zero, KalmanStates(np.zeros((9, 0)), np.zeros((9, 9, 0))))

    def begin(self, lasts: list[int]) -> ActiveTracks:
        """New tracks of the three frames that end with each of `lasts`, those of images that stand still first.

        Where any of these begin, others wait for the next time: a marker's images that do not stand still, as others
        come near them in some cameras, would begin a second track of it.
        """
        active = self.no_tracks()
        for lasting in (None,) if self.lasting is None else (self.lasting, None):
            for initiated in initiate(self.images, self.free, self.F, lasts, self.T, self.method, lasting):
                active = active.plus(self.taken_up(initiated))
            lasts = [last for last in lasts if last not in active.frame]
        return active

    def taken_up(self, initiated: InitiatedTracks) -> ActiveTracks:
        """New tracks, which then have their images."""
        ids = np.arange(self.n, self.n + len(initiated))
        self.n += len(initiated)
        for group in initiated.groups:
            self.free[group.detection[group.detection >= 0]] = False
            none, detection = np.zeros(group.detection.shape, bool), _short(group.detection)
            wide = np.sqrt(np.trace(group.cov))
            self.seen.append(Associations(group.frame, ids, detection, none, group.squared, wide, group.xyz, group.cov))
        self.initiated = self.initiated.plus(self.started(ids, initiated.groups[::-1]))
        return self.started(ids, initiated.groups)

    def started(self, ids: Ints, groups: tuple[CandidatePoints, ...]) -> ActiveTracks:
        """New tracks at the last of their three points, in the order given."""
        first, *others = groups
        motion = initial_states(
            first.xyz, first.cov, speed=self.method.velocity_sd, acceleration=self.method.acceleration_sd
        )
        for group in others:
            motion = predict(motion, self.T, self.method.process_noise)
            N = inverse(group.cov)
            motion = update(motion, N, np.einsum("ijt,jt->it", N, group.xyz - motion.position))
        return ActiveTracks(ids, others[-1].frame, np.zeros(len(ids), np.int64), motion)

    def proven(self, active: ActiveTracks, new: int, since: int) -> ActiveTracks:
        """The tracks one frame on; those from number `new` on that are not shown any more are set aside (1), (2). All
        that these have stands in `seen` from place `since` on."""
        after = self.step(active)
        on_trial = active.id[active.id >= new]
        if not len(on_trial) or not (self.crowded or self.T > SLOW):
            return after
        gone = np.setdiff1d(on_trial, after.id[after.alone < (1 if self.crowded else UNSEEN)])
        for k in range(since if len(gone) else len(self.seen), len(self.seen)):
            seen, theirs = self.seen[k], np.isin(self.seen[k].id, gone)
            self.free[_own(seen.take(theirs))] = True
            self.aside.append(seen.take(theirs))
            self.seen[k] = seen.take(~theirs)
        return after.take(~np.isin(after.id, gone))

    def returned(self) -> ActiveTracks:
        """Where tracks were initiated that were set aside, of those whose images are all still free, the longest first;
        they have them then."""
        if not self.aside:
            return self.no_tracks()
        seen, self.aside = _whole(self.aside), []
        order = np.argsort(seen.id, kind="stable")
        each = np.split(order, np.flatnonzero(np.diff(seen.id[order])) + 1)
        back = []
        for rows in sorted(each, key=len, reverse=True):
            images = _own(seen.take(rows))
            if self.free[images].all():
                self.free[images] = False
                back.append(rows)
        if back:
            self.seen.append(seen := seen.take(np.sort(np.concatenate(back))))
        return self.initiated.take(np.isin(self.initiated.id, seen.id if back else []))

    def step(self, active: ActiveTracks) -> ActiveTracks:
        """The tracks one frame on."""
        if not len(active.id):
            return active
        images, gate = self.images, self.method.gate
        motion = predict(active.motion, self.T, self.method.process_noise)
        expected = predict_images(images.P, motion)
        association = associate(images, self.free, active.frame, expected, gate)
        association = share(images, active.frame, expected, association, gate)
        after = update(motion, *information(images, expected, association))
        association, after, squared = without_outliers(images, gate, motion, expected, association, after)
        has = association.detection >= 0
        self.free[association.detection[has]] = False
        own, count = (has & ~association.shared).sum(0), has.sum(0)
        before = np.sqrt(np.trace(motion.cov))
        xyz, cov = after.position.copy(), after.cov.copy()  # views would keep the whole states in memory
        detection = _short(association.detection)
        self.seen.append(
            Associations(active.frame, active.id, detection, association.shared, squared, before, xyz, cov)
        )
        alone = np.where((own >= 1) & (count >= 2), 0, active.alone + 1)
        lost = np.sqrt(np.trace(after.cov)) > LOST_FACTOR * self.method.uncertain_sd
        alive = (alone <= self.method.max_coasting / self.T) & ~((alone > 0) & lost)
        active = ActiveTracks(active.id, active.frame, alone, after)
        return active if alive.all() else active.take(alive)


def without_outliers(
    images: Images,
    gate: float,
    before: KalmanStates,
    expected: PredictedImages,
    association: Association,
    after: KalmanStates,
) -> PassFit:
    """The association without images that do not fit the others of their track, and the tracks updated without them."""
    for _ in range(ROUNDS):
        has = association.detection >= 0
        seen = predict_images(images.P, after)
        off = np.where(has[:, None], images.uv[association.detection].swapaxes(1, 2) - seen.uv, 0.0)
        squared = (off * off).sum(1) / association.variance
        alone = _off_without_itself(off, association.variance, seen.S)
        loose = (alone > gate**2) & (has.sum(0) >= 2)
        if not loose.any():
            break
        wrong = (alone == alone.max(0)) | (has.sum(0) == 2)  # of two, it is not known which one it is
        wrong &= has & loose.any(0)
        detection, variance = np.where(wrong, -1, association.detection), np.where(wrong, np.inf, association.variance)
        association = association._replace(
            detection=detection, variance=variance, score=np.where(detection < 0, 0.0, association.score)
        )
        after = update(before, *information(images, expected, association))
    not_own = association.shared | images.merged[association.detection]
    return PassFit(association, after, np.where(not_own, 0.0, squared).sum(0))


def _off_without_itself(off: Floats, variance: Floats, S: Floats) -> Floats:
    """(C, T) squared distances of images from the prediction by all the others, in standard deviations.

    off (C, 2, T) px from where they are seen with their own help, which leaves of their variance (C, T) what is not in
    S (C, 3, T), the place's.
    """
    v = np.where(np.isfinite(variance), variance, 1.0)
    a, b, d = np.maximum(v - S[:, 0], MIN_VARIANCE_SHARE * v), -S[:, 1], np.maximum(v - S[:, 2], MIN_VARIANCE_SHARE * v)
    det = np.maximum(a * d - b * b, (MIN_VARIANCE_SHARE * v) ** 2)
    x, y = off.swapaxes(0, 1)
    return np.where(np.isfinite(variance), (d * x * x - 2 * b * x * y + a * y * y) / det, 0.0)


def _crowded(new: ActiveTracks, T: float, method: Simultaneous) -> bool:
    """Whether (2) holds of new tracks, each among those of its frame."""
    nearest = [np.zeros(0)]
    for frame in np.unique(new.frame):
        x = new.motion.position[:, new.frame == frame]
        apart = np.linalg.norm(x[:, :, None] - x[:, None], axis=0)
        np.fill_diagonal(apart, np.inf)
        nearest.append(apart.min(0))
    near, a = np.concatenate(nearest), method.acceleration_sd
    if method.uncertain_sd < DEFAULT.uncertain_sd:  # a room whose scale is less
        a = max(a, DEFAULT.acceleration_sd)
    return bool(len(near) and LEAST_GATE * a * T * T > np.median(near))


def _own(seen: Associations) -> Ints:
    """The images that are of one track alone."""
    return seen.detection[(seen.detection >= 0) & ~seen.shared]


def _whole(parts: list[Associations]) -> Associations:
    """All parts, which are then nowhere else."""
    columns, whole = [list(column) for column in zip(*parts, strict=True)], []
    parts.clear()
    while columns:
        whole.append(np.concatenate(columns.pop(0), -1))
        return_memory()  # of its parts, before those of the next column are in memory twice
    return Associations(*whole)


def _short(detection: Ints) -> Ints:
    """The same in four bytes."""
    return cast(Ints, detection.astype(np.int32))


def _nothing(C: int) -> Associations:
    """No images."""
    zero, none = np.zeros(0, np.int64), np.zeros(0)
    detection = _short(np.zeros((C, 0), np.int64))
    return Associations(zero, zero, detection, detection > 0, none, none, np.zeros((3, 0)), np.zeros((3, 3, 0)))


def run(images: Images, rate: float, method: Simultaneous, lasting: Floats | None = None) -> Associations:
    """All tracks of a recording; those of images that stand still are initiated first where their `lasting_variance`
    (C) px² is given."""
    return Run(images, rate, method, lasting).whole()
