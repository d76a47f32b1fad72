"""Which track has which images, in all cameras of one frame.

A track expected at X with covariance V is expected in a camera at its projection u, with the covariance of the
difference from a centroid of variance s²

    S = J V Jᵀ + s² I,   J = ∂u/∂X                                       (1)
    d² = (image − u)ᵀ S⁻¹ (image − u)                                    (2)

An image that lies beyond d = gate is none of its own. Among the others, claiming is worth how much likelier the image
is as the track's than as one of the b images per px² that come from anything else, where a track is seen with
probability p:

    worth = 2 ln(p / ((1 − p) 2π b)) − ln |S| − d²                       (3)

and in each camera the claims of all tracks together are those of the greatest worth. So a track that is sure of its
place takes an image before one that could be anywhere.

Where markers run together, a track that finds nothing shares the image of another that covers the place where it is
expected. The outermost of n equal discs that touch in a row lies (n − 1)/√n of the blob's radius r = √(area / π) from
its middle: 0.71 r for two, 1.15 r for three, which is as far as is looked. The image then says of either only that it
is somewhere in the blob, and for two discs in a row that is r²/2 along the row (4).

As in `kalman_states`, the T tracks stand along the last axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ... import native
from ...data.array_types import Bools, Floats, Ints
from ...numerics.runs import equal_runs
from .detection_index import Images
from .kalman_states import KalmanStates

IN_ROW = 1.15
"""(n − 1)/√n for three discs in a row; by definition."""


class PredictedImages(NamedTuple):
    """Tracks in the cameras: uv (C, 2, T) px, NaN behind; J (C, 2, 3, T) px/mm; S (C, 3, T) px², its xx, xy and yy,
    the centroid's variance not yet in it."""

    uv: Floats
    J: Floats
    S: Floats


class Association(NamedTuple):
    """Images of tracks: row (C, T) of `Images`, −1 for none; variance (C, T) px², inf for none; worth (C, T) of (3);
    shared (C, T) whether another track has it too."""

    row: Ints
    variance: Floats
    worth: Floats
    shared: Bools


class TrackImagePairs(NamedTuple):
    """Places own = c T + t of track t in camera c and rows of images that may belong together; (2), and ln |S|."""

    own: Ints
    row: Ints
    squared: Floats
    log_det: Floats


def predict_images(P: Floats, motion: KalmanStates) -> PredictedImages:
    """Where the cameras P (C, 3, 4) are expected to see the tracks."""
    return PredictedImages(*native.project(P, motion.position, motion.cov))


def candidates(images: Images, free: Bools, frame: Ints, expected: PredictedImages, gate: float) -> TrackImagePairs:
    """The free images within the gate of tracks in frames (T)."""
    u, v = expected.uv.swapaxes(0, 1).reshape(2, -1)
    a, b, d = expected.S.swapaxes(0, 1).reshape(3, -1)
    C = len(expected.uv)
    cell = (frame * C + np.arange(C)[:, None]).ravel()
    reach = gate * np.sqrt(a + images.widest[cell])
    own, row, squared, det = native.candidates(
        images.by_cell, images.variance, free, cell, np.stack([u, v]), np.stack([a, b, d]), reach, gate=gate**2
    )
    return TrackImagePairs(own, row, squared, np.log(det))


def associate(images: Images, free: Bools, frame: Ints, expected: PredictedImages, gate: float) -> Association:
    """The claims of T tracks in frames (T) on the free images there."""
    C, n = expected.uv.shape[::2]
    pairs = candidates(images, free, frame, expected, gate)
    worth = images.prior[pairs.own // n] - pairs.log_det - pairs.squared  # (3)
    good = np.flatnonzero(worth > 0)
    own, image, worth = pairs.own[good], pairs.row[good], worth[good]
    best = _best(own, image, worth, frame[own % n] * C + own // n)
    row, gain = np.full(C * n, -1), np.zeros(C * n)
    row[own[best]], gain[own[best]] = image[best], worth[best]
    row = row.reshape(C, n)
    variance = np.where(row >= 0, images.variance[row], np.inf)
    return Association(row, variance, gain.reshape(C, n), np.zeros((C, n), bool))


def _best(own: Ints, image: Ints, worth: Floats, cell: Ints) -> Ints:
    """Which pairs are claims: in each cell those of the greatest worth together, nobody and no image twice."""
    _, image = np.unique(image, return_inverse=True)
    rest = np.arange(len(own))
    won = []
    while len(rest):
        simple, left = _simple(own[rest], image[rest], worth[rest])
        won.append(rest[simple])
        rest = rest[left]
        if not simple.any():
            rest = rest[np.argsort(cell[rest], kind="stable")]
            cuts = equal_runs(cell[rest])[1:-1]
            won += [_assigned(own[part], image[part], worth[part], part) for part in np.split(rest, cuts)]
            break
    return np.concatenate([np.zeros(0, np.int64), *won])


def _simple(own: Ints, image: Ints, worth: Floats) -> tuple[Bools, Bools]:
    """Pairs that are certainly among the best, and those that have then nothing to do with them.

    Where a pair is the best of both its track and its image, and one of these has no other pair, then whatever else the
    best claims were, changing them for this pair would lose nothing.
    """
    order = np.argsort(worth, kind="stable")
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


def _assigned(own: Ints, image: Ints, worth: Floats, pair: Ints) -> Ints:
    """Of `pair` those of the greatest worth together."""
    tracks = {t: i for i, t in enumerate(dict.fromkeys(own.tolist()))}
    rows = {r: j for j, r in enumerate(dict.fromkeys(image.tolist()))}
    i, j = [tracks[t] for t in own.tolist()], [rows[r] for r in image.tolist()]
    gain, which = np.zeros((len(tracks), len(rows))), np.full((len(tracks), len(rows)), -1)
    gain[i, j], which[i, j] = worth, pair
    chosen = which[scipy.optimize.linear_sum_assignment(gain, maximize=True)]
    return np.asarray(chosen[chosen >= 0])


def share(images: Images, frame: Ints, expected: PredictedImages, claims: Association, gate: float) -> Association:
    """The claims, and those of tracks that find nothing on merged images of others that cover their place."""
    has = claims.row >= 0
    holder_c, holder = np.nonzero(has & images.merged[claims.row])
    h, t = np.nonzero((frame[holder, None] == frame) & ~has[holder_c])
    c, holder = holder_c[h], holder[h]
    row = claims.row[c, holder]
    far = np.hypot(images.uv[row, 0] - expected.uv[c, 0, t], images.uv[row, 1] - expected.uv[c, 1, t])
    sd = gate * np.sqrt(np.maximum(expected.S[c, 0, t], expected.S[c, 2, t]))
    beyond = far / (IN_ROW * images.radius[row] + sd)
    near = np.flatnonzero(beyond < 1)
    near = near[np.argsort(-beyond[near], kind="stable")]  # of several, the nearest is written last
    return _shared(images, claims, c[near], t[near], holder[near], row[near])


def _shared(images: Images, claims: Association, c: Ints, t: Ints, holder: Ints, row: Ints) -> Association:
    """The claims with rows also had by tracks t in cameras c."""
    if not len(t):
        return claims
    rows, variance, shared = claims.row.copy(), claims.variance.copy(), claims.shared.copy()
    rows[c, t] = row
    for track in (t, holder):
        variance[c, track] = np.maximum(images.variance[row], images.radius[row] ** 2 / 2)  # (4)
        shared[c, track] = True
    return Association(rows, variance, claims.worth, shared)


def information(images: Images, expected: PredictedImages, claims: Association) -> tuple[Floats, Floats]:
    """What the claimed images say of the positions: N (3, 3, T) 1/mm² and g (3, T) 1/mm of `kalman_states.update`."""
    return native.information(expected.uv, expected.J, claims.row, claims.variance, images.uv)
