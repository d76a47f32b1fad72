"""Association: which track has which images, in all cameras of one frame.

A track predicted at X with covariance V is predicted in a camera at its projection u. The innovation, the centroid of
variance s² less u, has the covariance

    S = J V Jᵀ + s² I,   J = ∂u/∂X                                       (1)
    d² = (image − u)ᵀ S⁻¹ (image − u)                                    (2)

An image beyond the gate, d > gate, is not associated. The score of any other is twice the log-likelihood ratio of two
hypotheses: the image is the track's, or it is one of the b images per px² that come from anything else, where a track
is seen with probability p:

    score = 2 ln(p / ((1 − p) 2π b)) − ln |S| − d²                       (3)

and in each camera the tracks are assigned to images so that the sum of the scores is greatest. So a track with a small
covariance takes an image before one with a large covariance.

Where markers run together, a track that finds nothing shares the image of another that covers the place where it is
expected. The outermost of n equal discs that touch in a row lies (n − 1)/√n of the blob's radius r = √(area / π) from
its centre: 0.71 r for two, 1.15 r for three, which is as far as is looked. The image then says of either only that it
is somewhere in the blob, and for two discs in a row that is r²/2 along the row (4).

As in `kalman_states`, the T tracks stand along the last axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from .... import native
from ....data.array_types import Bools, Floats, Ints
from ....numerics.runs import equal_runs
from ..detection_index import Images
from .kalman_states import KalmanStates

AT_ONCE = 1 << 14
"""Points that are projected into one camera together; chosen for memory."""

IN_ROW = 1.15
"""(n − 1)/√n for three discs in a row; by definition."""


class PredictedImages(NamedTuple):
    """Predictions of tracks in the cameras: uv (C, 2, T) px, NaN behind; J (C, 2, 3, T) px/mm; S (C, 3, T) px², its xx,
    xy and yy, the centroid's variance not yet in it."""

    uv: Floats
    J: Floats
    S: Floats


class Association(NamedTuple):
    """Images of tracks: detection (C, T) index, −1 for none; variance (C, T) px², inf for none; score (C, T)
    of (3); shared (C, T) whether another track has it too."""

    detection: Ints
    variance: Floats
    score: Floats
    shared: Bools


class TrackImagePairs(NamedTuple):
    """Places own = c T + t of track t in camera c and detections that may belong together; (2), and ln |S|."""

    own: Ints
    detection: Ints
    squared: Floats
    log_det: Floats


def predict_images(P: Floats, motion: KalmanStates) -> PredictedImages:
    """Where the cameras P (C, 3, 4) are expected to see the tracks."""
    return PredictedImages(*native.project(P, motion.position, motion.cov))


def places_in_image(P: Floats, xyz: Floats) -> Floats:
    """(N, 2) px of points (N, 3) mm in the camera P (3, 4), some at once: what else is predicted takes memory."""
    parts = np.array_split(xyz, -(-len(xyz) // AT_ONCE) or 1)
    none = np.zeros((3, 3, len(parts[0])))
    return np.concatenate(
        [predict_images(P[None], KalmanStates(part.T, none[..., : len(part)])).uv[0].T for part in parts]
    )


def candidates(images: Images, free: Bools, frame: Ints, expected: PredictedImages, gate: float) -> TrackImagePairs:
    """The free images within the gate of tracks in frames (T)."""
    u, v = expected.uv.swapaxes(0, 1).reshape(2, -1)
    a, b, d = expected.S.swapaxes(0, 1).reshape(3, -1)
    C = len(expected.uv)
    cell = (frame * C + np.arange(C)[:, None]).ravel()
    reach = gate * np.sqrt(a + images.widest[cell])
    own, detection, squared, det = native.candidates(
        images.by_cell, images.variance, free, cell, np.stack([u, v]), np.stack([a, b, d]), reach, gate=gate**2
    )
    return TrackImagePairs(own, detection, squared, np.log(det))


def associate(images: Images, free: Bools, frame: Ints, expected: PredictedImages, gate: float) -> Association:
    """The association of T tracks in frames (T) with the free images there."""
    C, n = expected.uv.shape[::2]
    pairs = candidates(images, free, frame, expected, gate)
    score = images.prior[pairs.own // n] - pairs.log_det - pairs.squared  # (3)
    good = np.flatnonzero(score > 0)
    own, image, score = pairs.own[good], pairs.detection[good], score[good]
    best = _best_pairs(own, image, score, frame[own % n] * C + own // n)
    detection, gain = np.full(C * n, -1), np.zeros(C * n)
    detection[own[best]], gain[own[best]] = image[best], score[best]
    detection = detection.reshape(C, n)
    variance = np.where(detection >= 0, images.variance[detection], np.inf)
    return Association(detection, variance, gain.reshape(C, n), np.zeros((C, n), bool))


def _best_pairs(own: Ints, image: Ints, score: Floats, cell: Ints) -> Ints:
    """Which pairs are associated: in each cell those of the greatest sum of scores, no track and no image twice."""
    _, image = np.unique(image, return_inverse=True)
    rest = np.arange(len(own))
    won = []
    while len(rest):
        simple, left = _simple(own[rest], image[rest], score[rest])
        won.append(rest[simple])
        rest = rest[left]
        if not simple.any():
            rest = rest[np.argsort(cell[rest], kind="stable")]
            cuts = equal_runs(cell[rest])[1:-1]
            won += [_assigned(own[part], image[part], score[part], part) for part in np.split(rest, cuts)]
            break
    return np.concatenate([np.zeros(0, np.int64), *won])


def _simple(own: Ints, image: Ints, score: Floats) -> tuple[Bools, Bools]:
    """Pairs that are certainly among the best, and those that have then nothing to do with them.

    Where a pair is the best of both its track and its image, and one of these has no other pair, an assignment with
    this pair is never worse than one without it.
    """
    order = np.argsort(score, kind="stable")
    best, only = np.ones(len(own), bool), np.zeros(len(own), bool)
    for i in (own, image):
        top = np.empty(int(i.max()) + 1, np.int64)
        top[i[order]] = order
        best &= top[i] == np.arange(len(own))
        only |= np.bincount(i)[i] == 1
    simple = best & only
    gone = np.zeros(len(own), bool)
    for i in (own, image):
        gone |= np.bincount(i, simple)[i] > 0
    return simple, ~gone


def _assigned(own: Ints, image: Ints, score: Floats, pair: Ints) -> Ints:
    """Of `pair` those of the greatest sum of scores."""
    tracks = {t: i for i, t in enumerate(dict.fromkeys(own.tolist()))}
    rows = {r: j for j, r in enumerate(dict.fromkeys(image.tolist()))}
    i, j = [tracks[t] for t in own.tolist()], [rows[r] for r in image.tolist()]
    gain, which = np.zeros((len(tracks), len(rows))), np.full((len(tracks), len(rows)), -1)
    gain[i, j], which[i, j] = score, pair
    chosen = which[scipy.optimize.linear_sum_assignment(gain, maximize=True)]
    return np.asarray(chosen[chosen >= 0])


def share(images: Images, frame: Ints, expected: PredictedImages, association: Association, gate: float) -> Association:
    """The association, in which tracks without an image share merged images of others that cover their prediction."""
    has = association.detection >= 0
    holder_c, holder = np.nonzero(has & images.merged[association.detection])
    h, t = np.nonzero((frame[holder, None] == frame) & ~has[holder_c])
    c, holder = holder_c[h], holder[h]
    detection = association.detection[c, holder]
    far = np.hypot(images.uv[detection, 0] - expected.uv[c, 0, t], images.uv[detection, 1] - expected.uv[c, 1, t])
    sd = gate * np.sqrt(np.maximum(expected.S[c, 0, t], expected.S[c, 2, t]))
    beyond = far / (IN_ROW * images.radius(detection) + sd)
    near = np.flatnonzero(beyond < 1)
    near = near[np.argsort(-beyond[near], kind="stable")]  # of several, the nearest is written last
    return _shared(images, association, c[near], t[near], holder[near], detection[near])


def _shared(images: Images, association: Association, c: Ints, t: Ints, holder: Ints, detection: Ints) -> Association:
    """The association in which tracks t in cameras c share the images `detection`."""
    if not len(t):
        return association
    rows, variance, shared = association.detection.copy(), association.variance.copy(), association.shared.copy()
    rows[c, t] = detection
    for track in (t, holder):
        variance[c, track] = np.maximum(images.variance[detection], images.radius(detection) ** 2 / 2)  # (4)
        shared[c, track] = True
    return Association(rows, variance, association.score, shared)


def information(images: Images, expected: PredictedImages, association: Association) -> tuple[Floats, Floats]:
    """Information of the associated images on the positions: N (3, 3, T) 1/mm² and g (3, T) 1/mm of
    `kalman_states.update`."""
    return native.information(expected.uv, expected.J, association.detection, association.variance, images.uv)
