"""Images of two markers, told by a camera that sees both apart: one of them in the track, the other in none.

Two markers are one image m in a camera, in a file that does not say so, and apart in another one, a and b. The track
has m and a, and lies beside its marker by half of what both are apart; b is left, as m can not be in two tracks. If
both are as bright, m is in the middle of both. With e_a and e_b, the residuals (1) of `epipolar_noise` of m with a and
with b,

    (e_a + e_b) / 2                                                                       (1)

is then the residual of the middle: noise about what the calibration leaves, though e_a and e_b may drift against each
other. Were m the image of one marker, that of b would be hidden in the camera of m, and its residual drift. So (2) of
`drifting_pairs`, of (1), tells: where one marker, here the middle, is CERTAIN, m is of both. What merges in one camera
is seldom far apart in the next: a and b are within REACH. Images b are followed from frame to frame as
`drifting_rivals` follows rivals. Nothing is asked while tracks are still found, as b may be of one of these.
"""

from __future__ import annotations

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .candidate_points import intersect
from .detection_index import Images
from .drifting_pairs import BLOCK, UsualResiduals, blocks, residual, scores, with_rest
from .drifting_rivals import Pieces, pieces_of, usual_of_two
from .rival_pairs import Rivals, stretches
from .simultaneous_method import Simultaneous

REACH = 2.5
"""Of a from b, in distances r below which images merge; chosen: see docs/theory/tracking-ghosts.md."""


LEAST = BLOCK // 2
"""Frames in which a and b both fit m, a number; chosen: fewer do by chance."""

CERTAIN = float(np.log(100.0))
"""One marker, in the middle, is then a hundred times likelier than two; chosen likewise."""


def of_common_images(
    frame: Ints,
    id: Ints,
    detection: Ints,
    images: Images,
    usual: UsualResiduals,
    r: float,
    T: float,
    method: Simultaneous,
) -> Bools:
    """(P) the points of tracks id (P), of detections (C, P), that have an image of two markers; frames are T s apart.

    Args:
        r: px, below which images are one; 0 where the file says which are, and nothing is asked.
    """
    out = np.zeros(len(frame), bool)
    if not r:
        return out
    usual, stretch = usual_of_two(id, detection, images, usual), stretches(frame, id, detection, LEAST)
    pieces = pieces_of(_beside(detection, stretch, images, r, method.gate), detection, stretch, images, T, method)
    common = _of_the_middle(pieces, detection, images, usual, method.gate) < -CERTAIN
    common &= np.bincount(pieces.of, minlength=len(common)) >= LEAST
    out[pieces.row[common[pieces.of]]] = True
    return with_rest(out, id, (detection >= 0).sum(0))


def _beside(detection: Ints, stretch: Ints, images: Images, r: float, gate: float) -> Rivals:
    """Pairs of an image m of a stretch and a free one b beside its other image a."""
    free = images.usable & ~images.merged
    free[detection[detection >= 0]] = False
    row = np.flatnonzero((stretch >= 0) & ~images.merged[detection].any(0, where=detection >= 0))
    pair = np.sort(detection[:, row], axis=0)[-2:]
    m, a, row = np.append(pair[0], pair[1]), np.append(pair[1], pair[0]), np.append(row, row)
    cell, reach = images.frame[a] * len(images.P) + images.camera[a], REACH * r
    query, b = images.near(cell, images.uv[a, 0], np.full(len(a), reach))
    near = free[b] & (np.hypot(*(images.uv[a[query]] - images.uv[b]).T) < reach)
    query, b = query[near], b[near]
    pair = np.stack([m[query], b])
    point = intersect(images, pair, images.camera[pair])
    rivals = Rivals(row[query], m[query], b, point.squared.sum(0), point.xyz, point.cov)
    fit = (rivals.squared < gate**2) & np.isfinite(point.xyz).all(0) & np.isfinite(point.cov).all((0, 1))
    return rivals.take(fit)


def _of_the_middle(pieces: Pieces, detection: Ints, images: Images, usual: UsualResiduals, gate: float) -> Floats:
    """(K) the sum of the scores of (1) of each piece, 0 of cameras that are not judged."""
    out, frame = np.zeros(len(pieces.stretch)), images.frame[pieces.own]
    a = detection[images.camera[pieces.image], pieces.row]
    for cameras, one in usual.of.items():
        some = (np.sort(images.camera[[pieces.own, a]], axis=0) == np.array(cameras)[:, None]).all(0)
        e_a, squared = _residual(images, usual.F[cameras], pieces.own[some], a[some])
        e_b, _ = _residual(images, usual.F[cameras], pieces.own[some], pieces.image[some])
        middle, of = (e_a + e_b) / 2 - one.median, pieces.of[some]  # (1)
        for block in blocks(frame[some], of):
            np.add.at(out, of[block[:, 0]], scores(middle[block], squared[block].mean(1) * gate**2, one))
    return out


def _residual(images: Images, F: Floats, one: Ints, other: Ints) -> tuple[Floats, Floats]:
    """`residual` of images (n) of two cameras, which may be of either first."""
    pair = np.stack([one, other])
    return residual(images, F, *np.where(images.camera[one] < images.camera[other], pair, pair[::-1]))
