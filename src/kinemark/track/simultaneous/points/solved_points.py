"""Points solved from the images that are associated with them, and from their motion where images tell little.

Where two cameras look along almost one line, or markers run together, a point is known better from its motion than from
its images. Where its standard deviation exceeds UNCERTAIN times the median, the smoothed position is given instead (1).
So it is where a point of its track less than LOOK frames away is VAGUE times as well known: two cameras side by side,
or with an image of two markers, have it for some frames, and lead it far along their rays (4).
What a calibration that is off leaves is the same in all the points that it is smoothed with, so only their noise is
filtered, and as much of it as those points have added afterwards (2).

Images hardly tell where the rig stands as a whole, so that one adjusted to them (`rig_of_tracks`) may stand some
millimetres beside the given one. Positions x that are known by motion alone go over with the others, by least squares
over these, x̄ being their mean:

    x′ = x + b + B (x − x̄)                                                                (3)
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....data import Cloud, Detections, Matches, Rig
from ....data.array_types import Bools, Floats, Ints
from ....geometry.weighted_points import ImageErrors, weighted_points
from ....numerics.returned_memory import return_memory
from ..detection_index import Images
from ..noise.measurement_noise import Noise
from ..simultaneous_method import Simultaneous
from .neighbouring_points import LOOK, TrackPoints, smoothed

LEAST = 1e-6
"""px² of variance, the least that an image is given; chosen (see benchmarks/tracking.py)."""

UNCERTAIN = 5.0
"""Of the median of the standard deviations; chosen (see benchmarks/tracking.py)."""

VAGUE = 2.0
"""Of the standard deviation of the best known point of its track less than LOOK frames away (4), a ratio; chosen: of 13
scenes (of seeds 1011 to 13041 of benchmarks/tracking_scenes.py) with 402 ghosts 374 are left, with 1.5 380, with 3 379.
"""

MOST_TELLING, LEAST_SPREAD = 5000, 0.05
"""Points from which (3) is learned, chosen: more say the same; and the spread along a direction, as a share of that
along the widest, below which B leaves the direction out; chosen: points far beside a plane would go anywhere."""

LEAST_TELLING = 20
"""Points from which B is learned, a number; chosen: of four with shifts of 1 mm of noise, points beside them went 8 mm
astray in the median, of 20 1.6."""

AT_ONCE = 20_000
"""Points that are solved in one go; chosen: more would take memory and no less time."""


class Working(NamedTuple):
    """The rig by which images are associated, the images in it, and their noise."""

    rig: Rig
    images: Images
    noise: Noise


class MovedImages(NamedTuple):
    """Images (n), which rise, that are taken to lie at uv (n, 2) px, as the lens drew them, with variance (n) px²."""

    image: Ints
    uv: Floats
    variance: Floats

    def among(self, rows: Ints) -> tuple[Bools, Ints]:
        """Which of some rows (…) are of these images, and which of these those (m) are."""
        place = np.searchsorted(self.image, rows)
        of_these = np.append(self.image, -1)[place] == rows
        of_these &= rows >= 0
        return of_these, place[of_these]


class Solver(NamedTuple):
    """What positions are solved from: detections, by which rig and noise, and the images (D) that tracks share; the
    errors of images, the usual share of the variance that the calibration leaves in all frames, and images that lie
    elsewhere than detected. What follows from these is worked out for the images that are solved from: there are many.
    """

    detections: Detections
    working: Working
    shared: Bools
    errors: ImageErrors
    lasting: float = 0.0
    moved: MovedImages | None = None

    @property
    def rig(self) -> Rig:
        """The cameras."""
        return self.working.rig

    def uv(self, detection: Ints) -> Floats:
        """(P, C, 2) px of the images `detection` (P, C), as the lens drew them."""
        uv = self.detections.uv[detection]
        if self.moved is not None:
            of_these, place = self.moved.among(detection)
            uv[of_these] = self.moved.uv[place]
        return uv

    def variance(self, rows: Ints) -> Floats:
        """(…) px² of some images, those that tracks share lying anywhere in their blobs."""
        flat = rows.ravel()
        variance, shared = image_variance(flat, self.working), self.shared[flat]
        variance[shared] = np.maximum(variance[shared], self.working.images.radius(flat[shared]) ** 2 / 2)
        if self.moved is not None:
            of_these, place = self.moved.among(flat)
            variance[of_these] = self.moved.variance[place]
        return variance.reshape(rows.shape)

    def cov(self, detection: Ints) -> Floats:
        """(P, C, 2, 2) px² of the images `detection` (P, C)."""
        variance, timing = self.variance(detection)[..., None, None], self.working.images.timing
        if timing is None:
            return np.asarray(variance * np.eye(2))
        flow = timing[detection][..., None]
        across = np.maximum(variance - (flow**2).sum(-2, keepdims=True), LEAST)
        return np.asarray(across * np.eye(2) + flow * flow.swapaxes(-1, -2))


def solver_for(detections: Detections, shared: Bools, working: Working, errors: ImageErrors) -> Solver:
    """The solver for images (D) of which tracks share some."""
    solver, share = Solver(detections, working, shared, errors), np.empty(len(shared))
    for own, lasting in zip(working.images.of_cameras, working.noise.lasting, strict=True):
        share[own] = lasting / solver.variance(np.arange(own.start, own.stop))
    share = share[working.images.usable]
    usual = float(np.median(share, overwrite_input=True)) if len(share) else 0.0
    return solver._replace(lasting=usual)


def solved(frame: Ints, detection: Ints, guess: Floats, solver: Solver) -> Cloud:
    """The points of detections (C, P), one to one, with guesses (3, P) mm of their positions."""
    xyz, cov, residual = solved_columns(frame, detection, guess, solver)
    start = np.searchsorted(frame, np.arange(solver.detections.n_frames + 1))
    return Cloud(solver.detections.rate, start, xyz, cov, residual, np.ascontiguousarray(detection.T))


def solved_columns(frame: Ints, detection: Ints, guess: Floats, solver: Solver) -> list[Floats]:
    """xyz (P, 3) mm, cov (P, 3, 3) mm² and residual (P) px of the same points."""
    n, n_frames = len(frame), solver.detections.n_frames
    xyz, cov, residual = np.empty((n, 3)), np.empty((n, 3, 3)), np.empty(n)
    for first in range(0, n, AT_ONCE):
        part = slice(first, first + AT_ONCE)
        matches = Matches(frame[part], detection[:, part].T, np.zeros(len(frame[part])), n_frames)
        near = np.ascontiguousarray(guess[:, part].T)
        points = weighted_points(
            matches,
            solver.detections,
            solver.rig,
            guess=near,
            uv=solver.uv(matches.detection),
            cov=solver.cov(matches.detection),
            errors=solver.errors,
        )
        xyz[part], cov[part], residual[part] = points.xyz, points.cov, points.residual
        if first % (5 * AT_ONCE) == 0:  # not each time, as it takes some milliseconds
            return_memory()
    return [xyz, cov, residual]


Held = list[Cloud]
"""A list of one cloud, which a function takes out to make another of it. So nobody else keeps its columns, and each of
them ends as soon as the new one is there: of a long recording there is no room for two clouds."""


def kept_points(held: Held, kept: Bools) -> Held:
    """Those that are kept (P)."""
    if kept.all():
        return held
    rate, start, columns = taken_out(held)
    return [with_columns(rate, np.concatenate([[0], np.cumsum(kept)])[start], columns, kept)]


def taken_out(held: Held) -> tuple[float, Ints, list[NDArray[Any]]]:
    """Rate and offsets of a cloud, and its columns: xyz, cov, residual and detection, which nobody else then has."""
    cloud = held.pop()
    return cloud.rate, cloud.start, [cloud.xyz, cloud.cov, cloud.residual, cloud.detection]


def with_columns(rate: float, start: Ints, columns: list[NDArray[Any]], kept: Bools) -> Cloud:
    """The rows that are kept of columns, the list of which is empty afterwards."""
    xyz, cov, residual, detection = (columns.pop(0)[kept] for _ in range(4))
    return Cloud(rate, start, xyz, cov, residual, detection)


def with_points(
    held: Held, ids: Ints, new: Cloud, new_ids: Ints, *, kept: Bools | None = None, good: Bools | None = None
) -> tuple[Held, Ints]:
    """Points of tracks ids (P), those that are `kept` (P), and the `good` ones (n) of new ones; all where None."""
    cloud = held[0]
    kept = np.ones(len(cloud), bool) if kept is None else kept
    good = np.ones(len(new), bool) if good is None else good
    frame, ids = np.concatenate([cloud.frame[kept], new.frame[good]]), np.concatenate([ids[kept], new_ids[good]])
    order = np.argsort(frame, kind="stable")
    start = np.searchsorted(frame[order], np.arange(cloud.n_frames + 1))
    del cloud
    rate, _, columns = taken_out(held)
    xyz, cov, residual, detection = (
        _joined(columns.pop(0), kept, one, good, order) for one in (new.xyz, new.cov, new.residual, new.detection)
    )
    return [Cloud(rate, start, xyz, cov, residual, detection)], ids[order]


def _joined(one: NDArray[Any], kept: Bools, other: NDArray[Any], good: Bools, order: Ints) -> NDArray[Any]:
    """Some rows of one column and some of another, in an order of both; none is in memory twice."""
    old, rows = order < np.count_nonzero(kept), np.zeros(len(order), np.int64)
    rows[old] = np.flatnonzero(kept)[order[old]]
    out = one[rows] if len(one) else np.empty((len(order), *one.shape[1:]), one.dtype)
    out[~old] = other[np.flatnonzero(good)[order[~old] - np.count_nonzero(kept)]]
    return out


def with_few_smoothed(cloud: Cloud, ids: Ints, images: Images, method: Simultaneous, lasting: float) -> Cloud:
    """The points of tracks ids (P), smoothed where they have fewer than two images of their own, as merged images say
    little, or are vague by (4).

    A share `lasting` is no noise (2). It is as large as that of the nearest of the points that they are smoothed with.
    """
    own = ((cloud.detection >= 0) & ~images.merged[cloud.detection]).sum(1)
    sd = np.where(own >= 2, _sd(cloud.cov), np.inf)
    sound = (own >= 2) & (sd <= VAGUE * _least_near(cloud.frame, ids, sd))
    few, beside = _beside(cloud.frame, ids, sound)
    if not len(few):
        return cloud
    which, xyz, cov = np.zeros(len(own), bool), cloud.xyz.copy(), cloud.cov.copy()
    which[few] = True
    xyz[few], noise = smoothed(TrackPoints.of(cloud, ids), which, sound, 1 / cloud.rate, method, 1 - lasting)
    cov[few] = noise + lasting * cov[beside]
    return replace(cloud, xyz=xyz, cov=cov)


def _by_track(frame: Ints, id: Ints) -> Ints:
    """(P) numbers of points by track and frame, of different tracks LOOK apart and more."""
    return np.asarray(id * (int(frame.max(initial=0)) + 1 + LOOK) + frame)


def _least_near(frame: Ints, id: Ints, sd: Floats) -> Floats:
    """(P) the least of sd (P) of the points of the same track that are less than LOOK frames away."""
    key = _by_track(frame, id)
    order = np.argsort(key, kind="stable")
    key, sd, least = key[order], sd[order], np.empty_like(sd)
    near = sd.copy()
    for n in range(1, LOOK):  # a track has one point in a frame, so others near are near in this order too
        there = key[n:] - key[:-n] < LOOK
        for one, other in ((slice(n, None), slice(-n)), (slice(-n), slice(n, None))):
            near[one][there] = np.fmin(near[one], sd[other])[there]
    least[order] = near
    return least


def _beside(frame: Ints, id: Ints, sound: Bools) -> tuple[Ints, Ints]:
    """The points (n) of tracks id (P) that are not sound (P), to which one is less than LOOK frames away, and it."""
    key = _by_track(frame, id)
    few, others = np.flatnonzero(~sound), np.flatnonzero(sound)
    others = others[np.argsort(key[others])]
    if not len(others):
        return few[:0], few[:0]
    after = np.searchsorted(key[others], key[few])
    both = others[np.clip([after - 1, after], 0, len(others) - 1)]
    apart = np.abs(key[both] - key[few])
    near = apart.min(0) < LOOK
    return few[near], np.where(apart[0] <= apart[1], *both)[near]


def on_given_rig(cloud: Cloud, solver: Solver) -> Cloud:
    """The points solved with the rig as it was given, the solver's.

    Those of which the images say little keep their positions among the others (3).
    """
    xyz, cov, residual = solved_columns(cloud.frame, cloud.detection.T, cloud.xyz.T, solver)
    lasting = solver.lasting
    del solver  # which has much memory
    return_memory()
    sd = _sd(cov)
    known = np.isfinite(xyz).all(1) & np.isfinite(sd)
    clear = known & (sd <= UNCERTAIN * np.median(sd[known])) if known.any() else known
    vague = np.flatnonzero(~clear)
    if len(vague):
        xyz[vague], left = _gone_over(cloud.xyz, xyz, np.flatnonzero(clear), vague)
        residual[vague] = cloud.residual[vague]
        cov[vague] = cloud.cov[vague] + left + _shared_cov(sd[clear], lasting)  # (2)
    return replace(cloud, xyz=xyz, cov=cov, residual=residual)


def _gone_over(before: Floats, after: Floats, telling: Ints, rows: Ints) -> tuple[Floats, Floats]:
    """(n, 3) mm where points at `before` (P, 3) of some rows (n) are by (3), learned from how telling ones (m) went
    `after` (P, 3), and (n, 3, 3) mm² what (3) leaves of them: more far beside the telling ones."""
    telling = telling[:: max(len(telling) // MOST_TELLING, 1)]
    m, n = len(telling), len(rows)
    if not m:
        return before[rows], np.zeros((n, 3, 3))
    middle, shift = before[telling].mean(0), after[telling] - before[telling]
    beside, there = before[telling] - middle, before[rows] - middle
    U, spread, axes = np.linalg.svd(beside, full_matrices=False)
    told = (spread > LEAST_SPREAD * spread[0]) & (m >= LEAST_TELLING)
    U, along = U[:, told], there @ axes[told].T / spread[told]
    left = shift - shift.mean(0)
    gone = U.T @ left
    left = left - U @ gone
    S = left.T @ left / max(m - 1 - told.sum(), 1)
    share = 1 + 1 / m + (along**2).sum(1)
    return before[rows] + shift.mean(0) + along @ gone, share[:, None, None] * S


class Moved(NamedTuple):
    """Of n points: their rows (n), and what is known better of them, xyz (n, 3) mm and cov (n, 3, 3) mm²."""

    row: Ints
    xyz: Floats
    cov: Floats


def by_motion(
    points: TrackPoints, filtered: TrackPoints, sound: Bools, T: float, method: Simultaneous, lasting: float
) -> Moved:
    """The uncertain points that are known better by their smoothed positions (1), or by the filtered ones where these
    are better known; a share `lasting` is no noise (2)."""
    sd = _sd(points.cov)
    known = np.isfinite(points.xyz).all(1) & np.isfinite(sd)
    vague = known & (sd > UNCERTAIN * np.median(sd[known])) if known.any() else known
    if not vague.any():
        return Moved(np.arange(0), points.xyz[:0], points.cov[:0])
    smooth = smoothed(points, vague, sound & known, T, method, 1 - lasting)
    better = _sd(smooth[1]) < _sd(filtered.cov[vague])
    xyz = np.where(better[:, None], smooth[0], filtered.xyz[vague])
    cov = np.where(better[:, None, None], smooth[1], filtered.cov[vague])
    cov = cov + _shared_cov(sd[known & ~vague], lasting)  # (2)
    gains = _sd(cov) < sd[vague]
    return Moved(np.flatnonzero(vague)[gains], xyz[gains], cov[gains])


def _sd(cov: Floats) -> Floats:
    """Standard deviation (P) of all three axes together, mm."""
    return np.asarray(np.sqrt(np.trace(cov, axis1=1, axis2=2)))


def precise_enough(cov: Floats, own: Ints, method: Simultaneous) -> Bools:
    """Whether points of covariances (P, 3, 3) mm², of so many own images (P), are precise enough to be given."""
    sd = _sd(cov)
    return ((own >= 2) | (sd < method.uncertain_sd / 5)) & (sd < method.max_sd)


def _shared_cov(sd: Floats, lasting: float) -> Floats:
    """(3, 3) mm² of (2), from standard deviations (N) mm of points with this share of it."""
    return lasting * (float(np.median(sd)) ** 2 / 3 if len(sd) else 0.0) * np.eye(3)


def image_variance(rows: Ints, working: Working) -> Floats:
    """(n) px² of some images, as if no tracks shared them."""
    images, noise, camera = working.images, working.noise, working.images.camera[rows]
    alone = images.variance[rows] - images.margin(rows) - images.calibration[camera]  # `weighted_points` adds them
    return np.asarray(np.maximum(alone, np.maximum(noise.white, LEAST)[camera]) + noise.lasting[camera])
