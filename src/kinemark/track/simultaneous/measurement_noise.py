"""How noisy the cameras really are, learned from the recording.

The noise that detections state, and the covariance of a calibration, say nothing of a camera that was knocked since, of
a lens that its model does not fit, of strobes out of step; and many files state no noise at all. In some frames of the
recording, images are grouped (`candidate_points`) as if each camera had START_SD more noise than it states. Where three
and more agree, each camera c is compared with what the others say without it: with d the distance of its nearest image
from where they expect one, whose variance is s² in each axis, and σ² that of the image,

    |d|² / 2 ~ (σ² + s² + a²) Exp(1),   a² = median(|d|² / 2) / ln 2 − σ² − s²            (1)

is the variance that is missing. It is added to all images of the camera where the median of n distances is higher than
chance makes it, the standard error of the median being 1 / (ln 2 √n) of it (2). Where a source states no noise at all,
a² is all there is, and it should hold for the worse images as well: it then follows from the quantile OUTER_QUANTILE in
the same way, if that is more (3), and no camera is taken to be better than the median of all. A camera of which hardly
any image is where one is expected is `Noise.inconsistent`: its calibration does not hold.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data.array_types import Floats, Ints
from .associate import predict_images
from .candidate_points import CandidatePoints, find_candidate_points, intersect
from .detection_index import LEAST_SD, Images
from .kalman_states import KalmanStates

START_SD = 0.4
"""px of noise that a camera is given before its own is known; chosen (see benchmarks/tracking.py)."""

MAX_DISTANCE = 10.0
"""px; no image that lies farther off is the one that is expected; chosen (see benchmarks/tracking.py)."""

ROUNDS = 3
"""Of (1), in which the others' a² becomes known as well; chosen (see benchmarks/tracking.py)."""

MIN_MISSING_SHARE = 0.5
"""Variance of this share of what is stated is missing before any is added; chosen (see benchmarks/tracking.py)."""

MIN_FOUND_SHARE = 0.15
"""Share of the places expected in a camera's image at which it must have an image; occlusion leaves 0.3 and more.
Chosen (see benchmarks/tracking.py)."""

OUTER_QUANTILE = 0.8
"""Quantile of (3): as far out as images of other markers hardly reach; chosen (see benchmarks/tracking.py)."""

SAMPLED_IMAGES = 1500
"""Images that are looked at, about, in two frames at least and at most in one of FRAME_STEP.
Chosen (see benchmarks/tracking.py)."""

FRAME_STEP = 50
"""Frames of which one is looked at at most: what is learned takes no more than a tenth of the time; chosen."""

MIN_PLACES = 20
"""Places from which something can be said of a camera; chosen (see benchmarks/tracking.py)."""


class Noise(NamedTuple):
    """What was learned of each of C cameras.

    Attributes:
        added: (C) a of (1), px.
        found: (C) share of expected places with an image; NaN where not known.
    """

    added: Floats
    found: Floats

    @property
    def inconsistent(self) -> Ints:
        """Inconsistent cameras: their images fit nothing."""
        return np.flatnonzero(self.found < MIN_FOUND_SHARE)


class Offsets(NamedTuple):
    """Images of one camera near n places where one is expected: off (n, 2) px, NaN where none is; variance (n) px²."""

    off: Floats
    variance: Floats


def learn_noise(images: Images, F: Floats, gate: float) -> tuple[Images, Noise]:
    """The images with the noise that their cameras really have, and that noise."""
    C, n = len(images.P), images.n_frames
    if not n:
        return images, Noise(np.zeros(C), np.full(C, np.nan))
    n_frames_read = int(np.clip(SAMPLED_IMAGES * n // max(len(images.by_cell.order), 1), 2, max(n // FRAME_STEP, 2)))
    frames = np.unique(np.linspace(0, n - 1, n_frames_read + 2)[1:-1].astype(int)).tolist()
    stated = images if images.stated else images.noisier(np.full(C, LEAST_SD**2) - images.usual)
    loose = stated.noisier(np.full(C, START_SD**2))
    groups = find_candidate_points(loose, images.usable, F, frames, gate)
    groups = groups.take((groups.row >= 0).sum(0) >= 3)
    added = np.full(C, START_SD**2)
    for _ in range(ROUNDS):
        noisy = stated.noisier(added)
        offsets = [_offsets(noisy, groups, c, gate) for c in range(C)]
        added = np.array([_missing(one, added[c], images.stated) for c, one in enumerate(offsets)])
    known = np.array([len(one.off) >= MIN_PLACES for one in offsets])
    if not images.stated and known.any():
        added = np.maximum(added, np.median(added[known]))
    noise = Noise(
        np.sqrt(np.where(known, added, 0.0)),
        np.array([np.isfinite(one.off[:, 0]).mean() if ok else np.nan for one, ok in zip(offsets, known, strict=True)]),
    )
    if not known.any():
        return images, noise
    return stated.noisier(np.where(known, added, np.median(added[known]))), noise


def _offsets(images: Images, groups: CandidatePoints, c: int, gate: float) -> Offsets:
    """What camera c has where groups of three and more without it expect an image."""
    view = groups.row.copy()
    view[c] = -1
    enough = (view >= 0).sum(0) >= 2
    view, frame = view[:, enough], groups.frame[enough]
    point = intersect(images, view)
    expected = predict_images(images.P[c : c + 1], KalmanStates(point.xyz, point.cov))
    uv = expected.uv[0].T
    inside = np.isfinite(uv).all(1) & ((uv >= 0) & (uv < images.size[c])).all(1)
    uv, frame = uv[inside], frame[inside]
    own, row = images.near(frame * len(images.P) + c, uv[:, 0], np.full(len(uv), MAX_DISTANCE))
    far = np.linalg.norm(images.uv[row] - uv[own], axis=1)
    order = np.argsort(-far, kind="stable")
    order = order[far[order] < MAX_DISTANCE]
    off, variance = np.full(uv.shape, np.nan), expected.S[0][::2].mean(0)[inside]
    order = order[~images.merged[row[order]]]  # markers that run together are no measure
    off[own[order]] = (images.uv[row] - uv[own])[order]  # of several, the nearest is written last
    variance[own[order]] += images.variance[row[order]]
    return Offsets(off, variance)


def _missing(offsets: Offsets, added: float, stated: bool) -> float:
    """a² of (1), px², where `added` is in the variance already."""
    far = np.hypot(offsets.off[:, 0], offsets.off[:, 1])
    there = far < MAX_DISTANCE
    if 2 * (far < MAX_DISTANCE / 4).sum() > there.sum():
        there = far < MAX_DISTANCE / 2  # beyond lie images of other markers
    n = int(there.sum())
    if n < MIN_PLACES / 2:
        return added
    squared, least = (offsets.off[there] ** 2).sum(1) / 2, float(np.median(offsets.variance[there])) - added
    usual = float(np.median(squared) / np.log(2))
    if stated:
        return usual - least if usual > least * (1 + 3 / (np.log(2) * np.sqrt(n)) + MIN_MISSING_SHARE) else 0.0  # (2)
    outer = float(np.quantile(squared, OUTER_QUANTILE) / -np.log(1 - OUTER_QUANTILE))
    return max(usual - least, outer - least, 0.0)  # (3)
