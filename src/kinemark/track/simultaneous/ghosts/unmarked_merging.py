"""Merged images in files that do not say which are: known by the tracks.

Below some distance r two markers are one image. In a camera of which the images lie about at random, the number of
pairs of them that are x apart grows with x, but hardly any are nearer than r. With n pairs nearer than R, m of them
nearer than r, and a share ε of what would be there that is nearer than r all the same (false images, or markers that
were told apart), r has the log-likelihood

    m ln ε − n ln(1 − (1 − ε) r²/R²)                                                       (1)

over none; the likeliest is taken.

Where a track j has no image in a camera, though another track i has one at b, about as near to the place p where j is
expected as r / 2, either j is hidden there, or b is the image of both. That j has no point in that frame, but before
and after it, is the same, unless b lies within OWN standard deviations of p, as its own image would. Of both
the image of i alone would be

    b' = 2 b − p,   variance 4 s² + s_p² + (SHARE |b − p|)²                                (2)

as two markers alike have their common image in the middle. A run is such frames of the same i and j, and of the same
cameras if there are several. Either reading gives a path of i through the run, from its place in the frames before to
that in the frames after; with the innovations δ and S of the filter along it, the squared distances q of the images
from the point that fits them best, Student's t of `likelihood`, and four times as much room for each image by (2),

    score = Σ ln t(q') − ln t(q) + ln t(δ'ᵀ S'⁻¹ δ') / √|S'| − ln t(δᵀ S⁻¹ δ) / √|S| + ln 4     (3)

is the log-likelihood ratio of an image of both to a marker that is hidden. Above LEAST the images of the run count as
merged, anywhere within r / 2 of either marker. The point of i is then solved from the mean of b, of variance s², and
b', of the variance of (2), with w = TRUST / (1 + exp(−score)) the probability of the latter,

    b + w (b' − b),   variance (1 − w) s² + w v' + w (1 − w) |b' − b|² / 2                (4)

b and p are of the adjusted rig, if there is one. What the rig as given leaves open besides is added to the variance.

Other points that have an image of both are solved as those of files that mark them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data import Cloud
from ....data.array_types import Bools, Floats, Ints
from ....geometry import undistort
from ....geometry.camera import distort
from ....native import inverse
from ....numerics.returned_memory import return_memory
from ....numerics.robust import student_log_likelihood
from ....numerics.runs import equal_runs
from ..detection_index import Images
from ..following.candidate_points import intersect
from ..following.kalman_states import KalmanStates, initial_states, predict, update
from ..following.likelihood import DEGREES_OF_FREEDOM, SURE
from ..points.neighbouring_points import TrackPoints
from ..points.second_pass import expected_between
from ..points.solved_points import MovedImages, Solver
from ..simultaneous_method import Simultaneous
from .merging_in_images import merged_in_images
from .near_held import NearHeld, near_held

LARGEST = 20.0
"""R of (1), px; chosen: markers farther apart than that are told apart by any camera."""

TOLD_APART = 0.03
"""ε of (1), a share, without unit; chosen: false images that fall beside a marker's."""

SHARE = 0.1
"""Of (2): standard deviation of what an image has of one of its two markers, 0.5 in the mean; chosen: depths of one
eighth apart make as much."""

FEW_CAMERAS = range(3, 5)
"""Numbers of cameras of which one camera's images alone tell of merging; chosen: of `gait9`, seven cameras, 97.8 % of
the reference's samples are found without it, 97.4 with it; two cameras lose up to 4 % of their points, few ghosts."""

LOOK = 8
"""Frames before a run and after it, and at either end of it, that (3) is about; chosen, as in `neighbouring_points`."""

LEAST = -2.0
"""Of (3), a logarithm, without unit; chosen: on seeds 0 to 59 of benchmarks/tracking_scenes.py it finds 0.70 of the
merged images of points that have two, and marks one image in eleven wrongly; 0 finds 0.62, and one in twenty."""

OWN = 3.0
"""Standard deviations of an image from where a track without a point is expected, within which it may be its own;
chosen: of the 359 ghosts of eight scenes (of seeds 137000 to 141129 of benchmarks/tracking_scenes.py) 22 are gone with
3, 28 with 2, which finds 47 samples fewer, and 7 with 5."""

CLEAR = float(np.log(10_000.0))
"""Of (3), a logarithm, without unit; chosen (seeds 0 to 149 of benchmarks/tracking_scenes.py): of the points with one
image of their own that are known to 2 to 10 mm, 81 of 89 are then a marker's; by ln 100, 112 of 129."""

TRUST = 0.85
"""Of (4), a probability; chosen: of images of the highest scores so many are nearer to the middle of both markers than
to the one that has them (seeds 0 to 60 of benchmarks/tracking_scenes.py; 0.81 to 0.85 for (3) above 2)."""

NOWHERE = 100_000.0
"""mm of standard deviation, of a place of which nothing is known; chosen: no laboratory is so wide, and an update of
what is known a thousand times worse has no correct digit left."""
AT_ONCE = 20_000
"""Points and images that are looked at in one go; more would take memory and no less time; chosen."""
RUNS_AT_ONCE = 2_000
"""Runs of which the paths are gone along in one go; chosen likewise."""


class Claims(NamedTuple):
    """K claims that images of a point are of another track too: row of the point and id of the track (K), which cameras
    (C, K), and what would be the image of the point alone there, uv (C, K, 2) px of variance (C, K) px²."""

    row: Ints
    other: Ints
    camera: Bools
    uv: Floats
    variance: Floats

    def take(self, which: Bools | Ints) -> Claims:
        """Only these."""
        return Claims(
            self.row[which], self.other[which], self.camera[:, which], self.uv[:, which], self.variance[:, which]
        )


class Merging(NamedTuple):
    """Images (n) that are of two markers, and the variance in px² that they have as such, (r / 4)².

    Attributes:
        track: (n) that holds each. clear: (n) whether (3) is above CLEAR.
        beside: (n, 2) px, where (4) is from the image; own_variance: (n) px², that of (4), of which s² is `usual`.
    """

    image: Ints
    variance: float
    track: Ints
    clear: Bools
    beside: Floats
    own_variance: Floats
    usual: Floats

    @property
    def resolution(self) -> float:
        """r px; 0 where none are merged, or the file says which."""
        return 4 * float(np.sqrt(self.variance))

    def marked(self, images: Images) -> Images:
        """The images with these marked."""
        if not len(self.image):
            return images
        merged, variance = images.merged.copy(), images.variance.copy()
        merged[self.image] = True
        variance[self.image] += self.variance
        return images._replace(merged=merged, variance=variance)

    def told_apart(self, cloud: Cloud, ids: Ints, solver: Solver) -> Solver:
        """The solver with (4) in place of the images that the points of the same tracks ids (P) still have.

        What the solver's rig leaves open, over s² of the rig by which (4) was found, moves the image as a whole, and
        not b − p: it is added once.
        """
        if not len(self.image):
            return solver
        holder = np.full(len(solver.detections), -1, np.int32)
        for camera in cloud.detection.T:
            holder[camera[camera >= 0]] = ids[camera >= 0]
        still = holder[self.image] == self.track
        image, beside, usual = self.image[still], self.beside[still], self.usual[still]
        uv, camera = solver.detections.uv[image], solver.detections.camera[image]
        for c, one in enumerate(solver.rig):
            uv[camera == c] = distort(one, undistort(one, uv[camera == c]) + beside[camera == c])
        more = solver.variance(image) - self.variance - usual
        return solver._replace(moved=MovedImages(image, uv, self.own_variance[still] + np.maximum(more, 0.0)))


class _Reading(NamedTuple):
    """Points of K claims by one reading: xyz (3, K) mm, cov (3, 3, K) mm², said (K) log-likelihood of the images."""

    xyz: Floats
    cov: Floats
    said: Floats


def inferred_merging(points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous) -> Merging:
    """The images that points of detections (C, P) show to be of two tracks; none where the file marks any."""
    none = np.zeros(0, np.int64)
    r = 0.0 if images.merged.any() and not images.common else resolution(images)
    if not r or len(points.id) < 2:
        return Merging(none, 0.0, none, none > 0, np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    claims = possible_claims(points, detection, images, r, expected_between(points, images.n_frames, T, method))
    return_memory()
    score = scores(claims, points, detection, images, T, method)
    camera, k = np.nonzero(claims.camera & (score > LEAST))
    order = np.argsort(-score[k], kind="stable")  # of several claims on an image the likeliest
    image, first = np.unique(detection[camera, claims.row[k]][order], return_index=True)
    camera, k = camera[order][first], k[order][first]
    beside, w = claims.uv[camera, k] - images.uv[image], TRUST / (1 + np.exp(-score[k]))
    apart = w * (1 - w) * (beside**2).sum(1) / 2
    usual = images.variance[image]
    variance = (1 - w) * usual + w * claims.variance[camera, k] + apart  # (4)
    return Merging(image, r * r / 16, points.id[claims.row[k]], score[k] > CLEAR, w[:, None] * beside, variance, usual)


def with_merging_in_images(images: Images) -> Images:
    """The images of three or four cameras with those marked that one camera alone shows to be of two. They are the
    same where the file marks any, with more cameras, where a point's other images tell as much, and with two, where
    each point needs both of its images."""
    r = 0.0 if images.merged.any() or len(images.P) not in FEW_CAMERAS else resolution(images)
    merged = merged_in_images(images, r) if r else images.merged
    return images.with_merged(merged, r * r / 16) if merged.any() and r else images


def resolution(images: Images) -> float:
    """r of (1) in px, 0 where images are as near to each other as it comes."""
    order = images.by_cell.order
    r = np.arange(1.0, LARGEST / 2 + 0.5, 0.5)
    m, n = np.zeros(len(r), np.int64), 0
    for begin in range(0, len(order), AT_ONCE):
        some = order[begin : begin + AT_ONCE]
        cell = images.frame[some] * len(images.P) + images.camera[some]
        near, second = images.near(cell, images.uv[some, 0], np.full(len(some), LARGEST))
        first = some[near]
        apart = np.hypot(*(images.uv[first] - images.uv[second]).T)
        apart = np.sort(apart[(first < second) & (apart < LARGEST)])
        m, n = m + np.searchsorted(apart, r), n + len(apart)
    likely = m * np.log(TOLD_APART) - n * np.log(1 - (1 - TOLD_APART) * (r / LARGEST) ** 2)  # (1)
    best = int(likely.argmax())
    return float(r[best]) if likely[best] > SURE else 0.0


def possible_claims(
    points: TrackPoints, detection: Ints, images: Images, r: float, unseen: TrackPoints | None = None
) -> Claims:
    """Claims on images that lie where another track, which lacks one, is expected; of several others by the nearest.

    Others are also tracks without a point, expected at `unseen`, but for images that may be their own. Claims on
    several cameras at once are followed by one for each.
    """
    id = points.id if unseen is None else np.concatenate([points.id, unseen.id])
    parts = [_nearest(near, images) for near in near_held(points, detection, images, r, unseen)]
    near = _nearest(NearHeld(*(np.concatenate(column, axis=-1) for column in zip(*parts, strict=True))), images)
    off = np.hypot(*(near.uv - images.uv[near.image].T))
    own = (near.other >= len(points.id)) & (off**2 < OWN**2 * (images.variance[near.image] + near.variance))
    near, off = near.take(~own), off[~own]
    spread = 4 * images.variance[near.image] + near.variance + (SHARE * off) ** 2
    alone = 2 * images.uv[near.image] - near.uv.T  # (2)
    return _tabled(near.holder, id[near.other], near.camera, alone, spread, len(images.P))


def _nearest(near: NearHeld, images: Images) -> NearHeld:
    """Of several places near an image the nearest."""
    apart = np.hypot(*(near.uv - images.uv[near.image].T))
    order = np.lexsort([apart, near.image])
    return near.take(order[np.diff(near.image[order], prepend=-1) > 0])


def _tabled(row: Ints, other: Ints, c: Ints, uv: Floats, variance: Floats, C: int) -> Claims:
    """Claims of single images (n) as those of each point on another track, and of each of their cameras alone."""
    pair, which = np.unique(np.stack([row, other]), axis=1, return_inverse=True)
    which = which.ravel()
    both = Claims(
        pair[0],
        pair[1],
        np.zeros((C, pair.shape[1]), bool),
        np.zeros((C, pair.shape[1], 2)),
        np.ones((C, pair.shape[1])),
    )
    both.camera[c, which], both.uv[c, which], both.variance[c, which] = True, uv, variance
    several = both.camera.sum(0) > 1
    c, k = np.nonzero(both.camera & several)
    single = both.take(k)
    alone = np.zeros_like(single.camera)
    alone[c, np.arange(len(c))] = True
    single = single._replace(camera=alone)
    one, other_ones = both, single
    return Claims(*(np.concatenate(pair, axis=int(pair[0].ndim > 1)) for pair in zip(one, other_ones, strict=True)))


def scores(
    claims: Claims, points: TrackPoints, detection: Ints, images: Images, T: float, method: Simultaneous
) -> Floats:
    """(K) of each claim, (3) of its run."""
    if not len(claims.row):
        return np.zeros(0)
    frame, code = points.frame[claims.row], np.packbits(claims.camera, axis=0)
    order = np.lexsort([frame, *code, claims.other, points.id[claims.row]])
    claims, frame, code = claims.take(order), frame[order], code[:, order]
    run = np.cumsum(np.diff(frame, prepend=frame[0]) > LOOK)
    start = equal_runs(points.id[claims.row], claims.other, *code, run)
    run = np.repeat(np.arange(len(start) - 1), np.diff(start))
    return_memory()
    table, score, number = _steps(claims, points, start), np.zeros(len(start) - 1), claims.camera.sum(0)
    readings = [(sign, _read(claims, detection, images, moved=sign > 0)) for sign in (1.0, -1.0)]
    for first in range(0, len(score), RUNS_AT_ONCE):
        some = slice(first, first + RUNS_AT_ONCE)
        steps, inside = table[:, some], table[:, some] < -1
        k = np.where(inside, -2 - steps, 0)
        score[some] = np.where(inside, number[k] * np.log(4.0), 0.0).sum(0)
        for sign, reading in readings:
            score[some] += sign * _path(reading, steps, points, T, method, frame)
            score[some] += sign * np.where(inside, reading.said[k], 0.0).sum(0)
    out = np.empty(len(order))
    out[order] = score[run]
    return out


def _read(claims: Claims, detection: Ints, images: Images, *, moved: bool) -> _Reading:
    """The points of claims with their images as they are, or by (2)."""
    parts = np.split(np.arange(len(claims.row)), range(AT_ONCE, len(claims.row), AT_ONCE))
    found = [_read_part(claims.take(part), detection, images, moved) for part in parts]
    return _Reading(*(np.concatenate(column, -1) for column in zip(*found, strict=True)))


def _read_part(claims: Claims, detection: Ints, images: Images, moved: bool) -> _Reading:
    """The same of some claims."""
    own = detection[:, claims.row]
    has, uv, variance = own >= 0, images.uv[own], images.variance[own]
    if moved:
        has, uv[claims.camera] = has | claims.camera, claims.uv[claims.camera]
        variance[claims.camera] = claims.variance[claims.camera]
    these = images._replace(uv=uv.reshape(-1, 2), variance=variance.reshape(-1))
    point = intersect(these, np.where(has, np.arange(own.size).reshape(own.shape), -1))
    squared = np.nan_to_num(np.where(has, point.squared, 0.0).sum(0), nan=np.inf, posinf=1e6)
    said = student_log_likelihood(squared, DEGREES_OF_FREEDOM, 2.0 * has.sum(0) - 3)
    known = np.isfinite(point.cov).all((0, 1))
    room = np.linalg.slogdet(np.where(known, point.cov, np.eye(3)[..., None]).transpose(2, 0, 1))[1] / 2
    return _Reading(point.xyz, point.cov, said + room - np.where(has, np.log(variance), 0.0).sum(0))


def _steps(claims: Claims, points: TrackPoints, start: Ints) -> NDArray[np.int32]:
    """(4 LOOK, R) what the path of each run leads through, in order: rows of points without claims before it, −2 − k of
    claims k at its begin and its end, rows after it; −1 for none."""
    free = np.ones(len(points.id), bool)
    free[claims.row] = False
    order = np.lexsort([points.frame, points.id])
    rows = np.append(order[free[order]], 0)
    key = (points.id * (int(points.frame.max()) + 1) + points.frame)[rows[:-1]]
    first, last = start[:-1], start[1:] - 1
    table = np.full((4 * LOOK, len(first)), -1, np.int32)
    for edge, way, to in ((first, -1, LOOK - 1), (last, 1, 3 * LOOK)):
        row = claims.row[edge]
        at = np.searchsorted(key, points.id[row] * (int(points.frame.max()) + 1) + points.frame[row])
        for n in range(LOOK):
            place = np.clip(at + way * n - (way < 0), -1, len(key))
            near = rows[place]
            there = (place >= 0) & (place < len(key)) & (points.id[near] == points.id[row])
            there &= np.abs(points.frame[near] - points.frame[row]) <= 2 * LOOK
            table[to + way * n] = np.where(there, near, -1)
    for n in range(LOOK):
        table[LOOK + n] = np.where(first + n <= last, -2 - (first + n), -1)
        late = last - LOOK + 1 + n
        table[2 * LOOK + n] = np.where(late >= first + LOOK, -2 - late, -1)
    return table


def _path(
    reading: _Reading, table: NDArray[np.int32], points: TrackPoints, T: float, method: Simultaneous, frame: Ints
) -> Floats:
    """(R) what the innovations along the path of each run add to (3).

    Long runs leave out what is between their ends; where the place is then not known to NOWHERE, the path begins anew.
    """
    R = table.shape[1]
    total, begun, last = np.zeros(R), np.zeros(R, bool), np.zeros(R, np.int64)
    motion = KalmanStates(np.zeros((9, R)), np.broadcast_to(np.eye(9)[..., None], (9, 9, R)).copy())
    for row in table:
        inside, there = row < -1, row != -1
        k, s = np.where(inside, -2 - row, 0), np.maximum(row, 0)
        z = np.where(inside, reading.xyz[:, k], points.xyz[s].T)
        C = np.where(inside, reading.cov[..., k], points.cov[s].transpose(1, 2, 0))
        there &= np.isfinite(z).all(0) & np.isfinite(C).all((0, 1))
        at, z = np.where(inside, frame[k], points.frame[s]), np.where(there, z, 0.0)
        C = np.where(there, C, np.eye(3)[..., None])
        ahead = predict(motion, np.where(there & begun, (at - last) * T, 0.0), method.process_noise)
        begun = begun & (np.trace(ahead.cov) < NOWHERE**2)
        S, delta = ahead.cov + C, z - ahead.position
        squared = np.einsum("it,ijt,jt->t", delta, inverse(S), delta)
        said = student_log_likelihood(squared, DEGREES_OF_FREEDOM, np.full(R, 3.0))
        said -= np.linalg.slogdet(S.transpose(2, 0, 1))[1] / 2
        total += np.where(there & begun, said, 0.0)
        N = inverse(C)
        after = update(ahead, N, np.einsum("ijt,jt->it", N, delta))
        new = initial_states(z, C, speed=method.velocity_sd, acceleration=method.acceleration_sd)
        which = [there & begun, there & ~begun]
        motion = KalmanStates(*(np.select(which, each[:2], each[2]) for each in zip(after, new, motion, strict=True)))
        begun, last = begun | there, np.where(there, at, last)
    return total
