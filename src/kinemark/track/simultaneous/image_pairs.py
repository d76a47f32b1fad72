"""Pairs of images of two cameras, and how much they speak for a rig.

Pairs of any two cameras (`epipolar_noise` (1)) are those of one marker, whose residual e is 0 but for noise, and those
that meet by chance. They are cut by time into blocks, which serve by turns for fitting and for judging. With f the
mixture (3) there as it is fitted, W its window, and v no less than LEAST_SD², as calibrations are off,

    L = Σ ln (2 W f(e)) / D    over |e| < W                                               (1)

is the evidence for a rig in the blocks that judge, 0 where all pairs meet by chance. D is the length of a clump ((8)
there), as the pairs of markers that stand come again and again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Detections
from ...data.array_types import Bools, Floats, Ints
from ...geometry import fundamental
from .candidate_points import fundamentals
from .detection_index import Images
from .epipolar_noise import HEAP, WIDER, WIDER_SHARE, WINDOW, clumps, likeliest, near_pairs, peaked

MOST_PAIRS = 30_000
"""That are looked at, about; chosen: more say the same."""
NEAR_SHARE = 0.3
"""Of the pairs of a frame, those within reach of each other's lines, about; chosen."""
BLOCKS = 8
"""Of a recording; chosen: a block is longer than most clumps, and either half has all parts of a recording."""
LEAST_SD = 0.5
"""px of (1); chosen: right files are off by some tenths of a pixel, which is no evidence."""


class Pairs(NamedTuple):
    """N pairs of images.

    Attributes:
        camera: (2, N); x: (2, N, 3) px, homogeneous; judging: (N) whether they judge, or else are for fitting.
        C: cameras; frames: those that judge.
    """

    camera: Ints
    x: Floats
    judging: Bools
    C: int
    frames: int

    @property
    def group(self) -> Ints:
        """(N) number of the two cameras."""
        return np.asarray(self.camera[0] * self.C + self.camera[1])

    def take(self, which: Bools) -> Pairs:
        """Only these."""
        return self._replace(camera=self.camera[:, which], x=self.x[:, which], judging=self.judging[which])

    def of_camera(self, c: int) -> Pairs:
        """Those with images of a camera."""
        return self.take((self.camera == c).any(0))

    def residuals(self, P: Floats) -> PairResiduals:
        """e by cameras P (C, 3, 4)."""
        e, line, group = np.zeros(self.x.shape[1]), np.zeros((2, self.x.shape[1], 2)), self.group
        for g in np.unique(group).tolist():
            own = group == g
            e[own], line[:, own] = residuals_of_two(self.x[:, own], fundamental(*P[[g // self.C, g % self.C]]))
        return PairResiduals(e, line)


class PairResiduals(NamedTuple):
    """e (N) px; its change (2, N, 2) by the images."""

    e: Floats
    line: Floats


def residuals_of_two(x: Floats, F: Floats) -> PairResiduals:
    """Of pairs x (2, N, 3) px of two cameras of one, or more, F (…, 3, 3)."""
    line, back = x[0] @ F.swapaxes(-1, -2), x[1] @ F
    squared = (line[..., :2] ** 2).sum(-1) + (back[..., :2] ** 2).sum(-1)
    root = np.sqrt(np.maximum(squared / 2, np.finfo(float).tiny))
    return PairResiduals((line * x[1]).sum(-1) / root, np.array([back[..., :2], line[..., :2]]) / root[..., None])


def read_pairs(detections: Detections, images: Images, reach: float) -> Pairs:
    """Pairs within reach px of each other's lines, in frames all over the recording."""
    counts, n = detections.keep(detections.valid).counts, detections.n_frames
    in_frame = max(float(NEAR_SHARE * (counts.sum(0) ** 2 - (counts**2).sum(0)).mean() / 2), 1.0)
    frames = np.unique(np.linspace(0, n - 1, int(np.clip(MOST_PAIRS / in_frame, 2, n))).astype(int))
    pair = near_pairs(images, fundamentals(images.P), frames.tolist(), reach)
    x = np.concatenate([images.uv[pair], np.ones((*pair.shape, 1))], -1)
    judges = _judges(frames, n)
    judging = _judges(images.frame[pair[0]], n)
    return Pairs(images.camera[pair], x, judging, len(images.P), max(int(judges.sum()), 1))


def _judges(frame: Ints, n: int) -> Bools:
    """Whether frames of n are in blocks that judge."""
    return np.asarray(frame * BLOCKS // n % 2 == 1)


def clump_lengths(pairs: Pairs, e: Floats) -> Floats:
    """(C²) D of (1), frames, of residuals e (N) px."""
    near = (np.abs(e) < WINDOW) & pairs.judging
    return clumps(e[near], pairs.group[near], pairs.C, pairs.frames, HEAP)[1]


def one_marker(e: Floats, variance: Floats | float) -> Floats:
    """(N) 1/px, density of e if pairs are one marker, by (3) of `epipolar_noise` without its chance."""
    core = (1 - WIDER_SHARE) * np.exp(e**2 / (-2 * variance))
    wider = WIDER_SHARE / WIDER * np.exp(e**2 / (-2 * WIDER**2 * variance))
    return np.asarray((core + wider) / np.sqrt(2 * np.pi * variance))


def evidence(pairs: Pairs, P: Floats, D: Floats) -> tuple[Floats, Floats]:
    """(C²) L of (1) by cameras P (C, 3, 4); and the same of the blocks for fitting."""
    e, line = pairs.residuals(P)
    near, n = np.abs(e) < WINDOW, pairs.C**2
    e, group, judging = e[near], pairs.group[near], pairs.judging[near]
    window = WINDOW * np.sqrt((line[:, near] ** 2).sum(-1).min(0))
    fitting = ~judging
    fit = likeliest(e[fitting], group[fitting], n, window[fitting])
    total = np.maximum(np.bincount(group[fitting], minlength=n), 1)
    share = np.where(peaked(fit), np.minimum(fit.number / total, 1.0), 0.0)[group]
    variance = np.maximum(fit.variance, LEAST_SD**2)[group]
    said = np.log(np.maximum(1 - share + share * 2 * window * one_marker(e, variance), np.finfo(float).tiny))
    judged, fitted = (np.bincount(group[own], said[own], n) / D for own in (judging, fitting))
    return judged, fitted
