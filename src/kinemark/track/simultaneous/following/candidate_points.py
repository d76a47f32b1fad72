"""Images of one frame that are one marker, without knowledge of other frames.

Two images of different cameras whose rays pass each other meet in a point; it takes in every other camera the likeliest
image where it is expected. A group of n images at distances d from the projections of the point that fits them best,
their noise s, has

    χ² = Σ d² / s²,   score = n w − χ²,   w = 2 ln(p / ((1 − p) 2π b s²))                (1)

where w is the score of an image by (3) of `associate`. The groups with the greatest score take their images first,
those of three and more before pairs; those that lost images are scored again without them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .... import native
from ....data.array_types import Bools, Floats, Ints
from ....geometry import fundamental
from ....numerics.runs import begins
from ..detection_index import Images
from .associate import candidates, predict_images
from .kalman_states import KalmanStates

AT_ONCE = 4000
"""Images of all frames that are paired in one go: fewer waste time on overhead, more take memory; chosen."""

MAX_IMAGES = 1500
"""Images of a frame that are looked at; more than these are noise; chosen (see benchmarks/tracking.py)."""


class CandidatePoints(NamedTuple):
    """G points: frame (G), xyz (3, G) mm, cov (3, 3, G) mm², detection (C, G) index or −1; χ² and score (G)."""

    frame: Ints
    xyz: Floats
    cov: Floats
    detection: Ints
    squared: Floats
    score: Floats

    def take(self, which: Ints | Bools) -> CandidatePoints:
        """Only these."""
        return CandidatePoints(
            self.frame[which],
            self.xyz[:, which],
            self.cov[..., which],
            self.detection[:, which],
            self.squared[which],
            self.score[which],
        )


class PlacedPoints(NamedTuple):
    """Points: xyz (3, H) mm, cov (3, 3, H) mm², squared (C, H) d²/s², −1 unseen."""

    xyz: Floats
    cov: Floats
    squared: Floats


def fundamentals(P: Floats) -> Floats:
    """(C, C, 3, 3): line in camera s = F[r, s] (u, v, 1) of camera r."""
    C = len(P)
    return np.array([[fundamental(P[r], P[s]) if r != s else np.zeros((3, 3)) for s in range(C)] for r in range(C)])


def find_candidate_points(images: Images, free: Bools, F: Floats, frames: list[int], gate: float) -> CandidatePoints:
    """The groups of the free images of some frames, sorted by frame.

    Most images belong to markers that four and more cameras see, and these are found from pairs of cameras that stand
    side by side; all pairs of cameras are only tried on what is then left, which keeps the work in step with C.
    """
    free, C = free.copy(), len(images.P)
    rows = [rows[free[rows]] for rows in images.in_frames(frames)]
    pair = np.concatenate([near_lines(images, part, F, gate) for part in batches(rows)], -1)
    between = np.abs(np.diff(images.camera[pair], axis=0)[0])
    between = np.minimum(between, C - between)
    won = [_nothing(C)]
    for most, least in ((2, (4,)), (C, (3, 2))):
        some = np.flatnonzero((between <= most) & free[pair].all(0))
        if len(some):
            detection = _completed(images, free, pair[:, some], gate)
            detection = _distinct(detection[:, (detection >= 0).sum(0) >= least[-1]])
            won += _chosen(images, free, detection, gate, least)
    groups = CandidatePoints(*(np.concatenate(columns, -1) for columns in zip(*won, strict=True)))
    return groups.take(np.argsort(groups.frame, kind="stable"))


def _nothing(C: int) -> CandidatePoints:
    """No groups."""
    zero, none = np.zeros(0, np.int64), np.zeros(0)
    return CandidatePoints(zero, np.zeros((3, 0)), np.zeros((3, 3, 0)), np.zeros((C, 0), np.int64), none, none)


def batches(rows: list[Ints]) -> list[Ints]:
    """The rows of frames of at most MOST in parts of about AT_ONCE, each frame a line (f, M) with −1 after its last."""
    rows = [own for own in rows if 2 <= len(own) <= MAX_IMAGES]
    part = np.cumsum([len(own) for own in rows]) // AT_ONCE
    return [_padded([own for own, p in zip(rows, part, strict=True) if p == k]) for k in np.unique(part)] or [
        np.zeros((0, 0), np.int64)
    ]


def _padded(rows: list[Ints]) -> Ints:
    """Lists one below the other, −1 after the last of each."""
    out = np.full((len(rows), max(len(own) for own in rows)), -1)
    for line, own in zip(out, rows, strict=True):
        line[: len(own)] = own
    return out


def near_lines(images: Images, rows: Ints, F: Floats, gate: float) -> Ints:
    """Pairs (2, H) of images, of one frame of `rows` (f, M) and of two cameras, each near the other's line."""
    camera, variance = np.where(rows >= 0, images.camera[rows], len(F)), images.variance[rows] * gate**2
    h = np.concatenate([images.uv[rows], np.ones((*rows.shape, 1))], -1)
    pairs = [np.zeros((2, 0), np.int64)]
    for c in range(1, len(F)):
        before = (camera < c).sum(1)  # in each frame these come first
        n, m = before.max(initial=0), (camera == c).sum(1).max(initial=0)
        own = np.minimum(before[:, None] + np.arange(m), rows.shape[1] - 1)
        frame = np.arange(len(rows))[:, None]
        first = np.minimum(camera[:, :n], c)
        line = np.einsum("fnij,fnj->fni", F[first, c], h[:, :n])
        square = (line @ h[frame, own].swapaxes(1, 2)) ** 2
        reach = variance[:, :n, None] + variance[frame, own][:, None]
        near = square < reach * (line[..., :2] ** 2).sum(-1, keepdims=True)
        f, i, j = np.nonzero(near & (camera[:, :n] < c)[..., None] & (camera[frame, own] == c)[:, None])
        k = own[f, j]
        other = (F[c, first[f, i], :2] * h[f, k, None]).sum(-1)  # the line of the second in the camera of the first
        good = square[f, i, j] < reach[f, i, j] * (other**2).sum(1)
        pairs.append(np.array([rows[f, i], rows[f, k]])[:, good])
    return np.concatenate(pairs, -1)


def _completed(images: Images, free: Bools, pair: Ints, gate: float) -> Ints:
    """The detections (C, H) of pairs (2, H), with the likeliest images where their points are expected elsewhere."""
    camera, n = images.camera[pair], np.arange(pair.shape[1])
    point = intersect(images, pair, camera)
    expected = predict_images(images.P, KalmanStates(point.xyz, point.cov))
    expected.uv[camera, :, n] = np.nan
    pairs = candidates(images, free, images.frame[pair[0]], expected, gate)
    order = np.argsort(-pairs.squared, kind="stable")  # of several, the nearest is written last
    detection = np.full((len(images.P), len(n)), -1)
    detection.reshape(-1)[pairs.own[order]] = pairs.detection[order]
    detection[camera, n] = pair
    return detection


def _distinct(detection: Ints) -> Ints:
    """Without repetition."""
    order = np.lexsort(detection)
    return detection[:, np.sort(order[begins(*detection[:, order])])]


def _chosen(
    images: Images, free: Bools, detection: Ints, gate: float, leasts: tuple[int, ...]
) -> list[CandidatePoints]:
    """The groups that win their images, by their scores (1), those of more images first; theirs are free no longer."""
    left = _scored(images, detection, gate)
    won = []
    for least in leasts:
        left = left.take(np.argsort(-left.score, kind="stable"))
        kept, displaced = _assign_images(left, free, least)
        won.append(left.take(kept))
        if least != leasts[-1]:
            detection = np.where(free[left.detection[:, displaced]], left.detection[:, displaced], -1)
            left = _scored(images, _distinct(detection[:, (detection >= 0).sum(0) >= 2]), gate)
    return won


def _assign_images(groups: CandidatePoints, free: Bools, least: int) -> tuple[Ints, Ints]:
    """Places of the groups of `least` and more images, all free, which they are then no longer; and of the others."""
    kept, displaced = [], []
    for g, own in enumerate(groups.detection.T.tolist()):
        own = [detection for detection in own if detection >= 0]
        if len(own) >= least and free[own].all():
            free[own] = False
            kept.append(g)
        else:
            displaced.append(g)
    return np.array(kept, int), np.array(displaced, int)


def _scored(images: Images, detection: Ints, gate: float) -> CandidatePoints:
    """Points of detections (C, H), without outliers, and their scores."""
    point = intersect(images, detection)
    while (bad := point.squared.max(0, initial=0.0) > gate**2).any():
        which = np.flatnonzero(bad)
        detection = detection.copy()
        detection[point.squared[:, which].argmax(0), which] = -1
        detection = detection[:, (detection >= 0).sum(0) >= 2]
        point = intersect(images, detection)
    has = detection >= 0
    image_score = images.prior[:, None] - 2 * np.log(images.variance[detection])
    squared = np.where(has, point.squared, 0.0).sum(0)
    score = np.where(has, image_score, 0.0).sum(0) - squared
    sure = np.flatnonzero(np.isfinite(point.xyz).all(0) & np.isfinite(point.cov).all((0, 1)))
    return CandidatePoints(
        images.frame[detection.max(0, initial=0)], point.xyz, point.cov, detection, squared, score
    ).take(sure)


def intersect(images: Images, detection: Ints, camera: Ints | None = None) -> PlacedPoints:
    """Where the rays of detections meet.

    Args:
        detection: (k, H) indices in `Images`, −1 for none.
        camera: (k, H) that they are of; None: k = C, one line for each camera.
    """
    camera = np.arange(len(detection))[:, None] if camera is None else camera
    camera = np.broadcast_to(camera, detection.shape)
    return PlacedPoints(*native.intersect(images.P, images.uv, images.variance, detection, camera))
