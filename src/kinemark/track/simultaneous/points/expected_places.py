"""Points of tracks that the tracker missed, looked for where something else expects them.

Whoever knows more of a scene than the tracker, as by the body that the markers are on, says where a track should be in
frames in which it has no point: places with covariances. The motion of the track before and after, as far as there are
points within `max_gap`, and the place are independent, so the motion is updated with the place by the information
filter: N = B⁻¹, g = N (b − x) (1). Images that are free are associated there as in `second_pass`, and two of them make
a point. What is found tells more of the motion, so it is done ITERATIONS times. Points that their images
alone do not know to `uncertain_sd`, as those of two cameras that face each other, are no measurement of the place (2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....data import Cloud, Detections, Rig, Tracks
from ....data.array_types import Bools, Ints
from ....geometry.weighted_points import DEFAULT_ERRORS, ImageErrors, usable_points
from ....native import inverse
from ..facts import tracked_images
from ..following.candidate_points import intersect
from ..following.kalman_states import KalmanStates, initial_states, predict, reversed_time, update
from ..simultaneous_method import DEFAULT, Simultaneous
from ..simultaneous_tracking import VOLUME_MARGIN
from .neighbouring_points import RowsByTrack, TrackPoints, between, motion_from, rows_near
from .second_pass import images_where_expected
from .solved_points import Working, precise_enough, solved, solver_for

ITERATIONS = 2
"""Times in turn; chosen: the third finds hardly anything new."""


class Looked(NamedTuple):
    """Points that were found, and the track (P) of each."""

    cloud: Cloud
    id: Ints


class Searched(NamedTuple):
    """What is looked at: the images, those that are free (D), how a track moves, and s from frame to frame."""

    working: Working
    detections: Detections
    free: Bools
    method: Simultaneous


def searched(
    detections: Detections, rig: Rig, tracks: Tracks, held: Bools, *, method: Simultaneous = DEFAULT
) -> Searched:
    """The images of a recording, those free that no point (P) of its tracks holds."""
    timed, working, method = tracked_images(detections, rig, tracks, method)
    free = working.images.usable.copy()
    taken = tracks.cloud.detection[held]
    free[taken[taken >= 0]] = False
    return Searched(working, timed, free, method)


def points_where_expected(
    at: Searched,
    known: TrackPoints,
    expected: TrackPoints,
    *,
    errors: ImageErrors = DEFAULT_ERRORS,
    volume_margin: float | None = VOLUME_MARGIN,
) -> Looked:
    """The points that free images make in expected places.

    Args:
        known: points of the tracks, in no frame in which they are expected. expected: where they should be.
        errors, volume_margin: as `track_simultaneously` has them.
    """
    images, T = at.working.images, 1 / at.detections.rate
    free, new = at.free.copy(), np.zeros((len(images.P), 0), np.int64)
    rows, left = np.arange(0), np.arange(len(expected.id))
    points = known
    for _ in range(ITERATIONS):
        motion = _motion(points, expected.take(left), T, at.method)
        detection = images_where_expected(images, free, expected.frame[left], motion, at.method)
        place = intersect(images, detection)
        xyz, cov = place.xyz.T, place.cov.transpose(2, 0, 1)
        good = ((detection >= 0).sum(0) >= 2) & np.isfinite(xyz).all(1) & np.isfinite(cov).all((1, 2))
        if not good.any():
            break
        points = points.plus(TrackPoints(expected.frame[left], expected.id[left], xyz, cov).take(good))
        new, rows = np.concatenate([new, detection[:, good]], 1), np.concatenate([rows, left[good]])
        used = detection[:, good]
        free[used[used >= 0]] = False
        left = left[~good]
    of = expected.take(rows)._replace(xyz=points.xyz[len(known.id) :])
    return _solved(at, of, new, errors, volume_margin)


def _solved(at: Searched, of: TrackPoints, detection: Ints, errors: ImageErrors, volume_margin: float | None) -> Looked:
    """The points solved from their detections (C, N), those that are good enough."""
    images = at.working.images
    order = np.argsort(of.frame, kind="stable")
    detection, of = detection[:, order], of.take(order)
    solver = solver_for(at.detections, np.zeros(len(at.free), bool), at.working, errors)
    cloud = solved(of.frame, detection, of.xyz.T, solver)
    own = ((detection >= 0) & ~images.merged[detection]).sum(0)
    good = usable_points(cloud, at.working.rig, margin=volume_margin) & precise_enough(cloud.cov, own, at.method)
    good &= np.trace(cloud.cov, axis1=1, axis2=2) < at.method.uncertain_sd**2  # (2)
    return Looked(cloud.keep(good), of.id[good])


def _motion(known: TrackPoints, expected: TrackPoints, T: float, method: Simultaneous) -> KalmanStates:
    """What the known points before and after, and the expected places (n), say of the motion there (1)."""
    before, after = _beside(known, expected, round(method.max_gap / T))
    wide = initial_states(
        expected.xyz.T, expected.cov.transpose(1, 2, 0), speed=method.velocity_sd, acceleration=method.acceleration_sd
    )
    x, V = wide.x.copy(), wide.V.copy()
    one, other = (_from(known, expected.frame, point, way, T, method) for point, way in ((before, -1), (after, 1)))
    other = reversed_time(other)
    for which, motion in (
        ((before >= 0) & (after < 0), one),
        ((before < 0) & (after >= 0), other),
        ((before >= 0) & (after >= 0), between(one, other)),
    ):
        some = motion.take(which)
        N = inverse(expected.cov[which].transpose(1, 2, 0))
        g = np.einsum("ijt,jt->it", N, expected.xyz[which].T - some.position)
        done = update(some, N, g)
        x[:, which], V[:, :, which] = done.x, done.V
    return KalmanStates(x, V)


def _beside(known: TrackPoints, expected: TrackPoints, reach: int) -> tuple[Ints, Ints]:
    """(n) rows of the known points of the same track next before and after, −1 where none is within `reach` frames."""
    order = np.lexsort([known.frame, known.id])
    width = int(max(known.frame.max(initial=0), expected.frame.max(initial=0))) + 1
    at = known.id[order] * width + known.frame[order]
    right = np.searchsorted(at, expected.id * width + expected.frame)
    out = []
    for k in (right - 1, right):
        inside = (k >= 0) & (k < len(order))
        row = order[np.where(inside, k, 0)] if len(order) else np.zeros(len(k), np.int64)
        same = inside & (len(order) > 0)
        if len(order):
            same &= (known.id[row] == expected.id) & (np.abs(known.frame[row] - expected.frame) <= reach)
        out.append(np.where(same, row, -1))
    return out[0], out[1]


def _from(known: TrackPoints, frame: Ints, point: Ints, way: int, T: float, method: Simultaneous) -> KalmanStates:
    """The motion in frames (n) from the known points (n) on one side; of −1 whatever."""
    ends, which = np.unique(point, return_inverse=True)
    if not len(known.id):
        n = len(frame)
        return initial_states(np.zeros((3, n)), np.tile(np.eye(3)[..., None], n), speed=1.0, acceleration=1.0)
    near = rows_near(RowsByTrack.of(known.frame, known.id), known.id[ends], known.frame[ends], way)
    motion = motion_from(known, near, known.xyz[ends].T, T, method).take(which)
    return predict(motion, np.where(point >= 0, np.abs(frame - known.frame[point]), 0) * T, method.process_noise)
