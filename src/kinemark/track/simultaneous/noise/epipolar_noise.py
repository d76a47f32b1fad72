"""The noise of each camera from the distances between images and epipolar lines.

Image x of camera r and image x′ of camera s in the same frame leave the residual

    e = x′ᵀ F x / √((|l|² + |l′|²) / 2),   l′ = F x,   l = Fᵀ x′   (first two components)    (1)

in px. If both are one marker, e has the variance

    v = w σ_r² + w′ σ_s²,   w = 2 |l|² / (|l|² + |l′|²),   w + w′ = 2                         (2)

with σ² the variance of an image, whatever it comes from. If they are two markers, e is anything within a window W: each
image lies within WINDOW of the other's line, which leaves |e| < W = WINDOW √min(w, w′) (6), half of it and less where a
marker is much nearer to one camera than to the other. So the residuals of two cameras are a mixture,

    p(e) = π [(1 − ε) N(e; 0, v) + ε N(e; 0, k² v)] + (1 − π) / 2W                            (3)

where the share ε of wider residuals are images that are partly hidden or run together (Tukey 1960, the contaminated
normal). v and π follow by expectation and maximisation (Dempster, Laird & Rubin 1977). A calibration that is off shifts
the residuals of two cameras together, so their v is known no better than by a factor, τ in its logarithm; and cameras
of one rig are alike, to ρ in the logarithm of their σ². So σ² = exp a minimises

    Σ D(v, w exp a_r + w′ exp a_s) / (τ² + 2/n) + Σ (a_c − ā)² / ρ²,   D(v, f) = 2 (v/f − 1 − ln v/f)      (4)

over the pairs of cameras, each with n residuals, D being the deviance of a variance: a camera whose file is off more in
some places than in others has the mean of its v, which its images need, and not the mean of their logarithms. v/f
counts up to MOST_FACTOR. No image is grouped, no camera needs another's noise first, and two cameras suffice.

With two cameras, many markers and a calibration that is off, no peak may be seen at 0. Where that is so in all pairs of
cameras, and residuals are clearly densest elsewhere, (3) is about that place, whose square is added to v (5). Where a
rig is adjusted, so is (3) of each two cameras for which that is likelier: those of others may be at 0.

Pairs of images that meet by chance lie anywhere beside each other's lines, those of one marker in a heap of the width
of their noise, beside them by what the calibration is off. Who stands, or moves slowly, leaves such pairs where they
are for many frames, so that they come in clumps: their counts in strips as wide as the heap have a variance of D times
their mean λ, the index of dispersion (Cox & Lewis 1966), which is the length of a clump. Cameras r and s are partners
where the n residuals within HEAP of some k within SLIP are more than such clumps make,

    P(N ≥ n / D) < BY_CHANCE,   N ~ Poisson(λ / D),                                       (7)

D and λ being those of strips farther off, and D that of one clump more, which is as usual in the recording (8): where
no pair meets by chance, D is not known. HEAP grows with the noise, by the tallest of the peaks of (3).

The residuals of a calibration that is off are not n errors, but one and the same n times. For association that is
enough; `calibration_field` tells them from white noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from ....data.array_types import Bools, Floats, Ints
from ..detection_index import Images
from ..following.candidate_points import batches, near_lines
from ..following.likelihood import SURE

WINDOW = 10.0
"""In px, of (6): farther from the line, no image is the one that belongs to it; chosen
(see benchmarks/tracking_scenes.py)."""

WIDER_SHARE, WIDER = 0.1, 4.0
"""ε and k of (3): one residual in ten, four times as wide; chosen (see benchmarks/tracking_scenes.py)."""

NARROW = 0.25
"""px, a standard deviation with which (3) is begun beside a quarter of WINDOW; chosen: of things that do not move the
residuals are a comb, of which a wide peak takes the most."""

ROUNDS, SETTLED = 100, 0.02
"""Of expectation and maximisation at most, a number, and the relative change of v at which no more are made; chosen."""

MIN_PAIRS = 10
"""Pairs of images, by their probabilities, from which two cameras say something; chosen
(see benchmarks/tracking_scenes.py)."""

MAX_SD = 3.0
"""px: a mixture that is wider than this has no peak; chosen (see benchmarks/tracking_scenes.py)."""

PEAK, CLEAR = 0.5, 2.0
"""Of (5): px, a third of the width in which residuals are counted, and how many times as many there are than anywhere
else, chosen: pairs of images that meet by chance stay for many frames, and make lesser peaks."""

PAIR_LOG_SD = 0.5
"""τ of (4), a natural logarithm of variances; chosen (see benchmarks/tracking_scenes.py)."""

CAMERA_LOG_SD = 1.0
"""ρ of (4), a natural logarithm of variances; chosen (see benchmarks/tracking_scenes.py)."""

MOST_FACTOR = 2.0
"""Of (4), the most that v counts as a ratio to what is expected; chosen: of a child's foot (`studies/child_foot.py`)
one wide pair of 15 makes a camera of 0.05 px one of 1.0 with 3, and of 0.5 with 2."""

STEPS = 20
"""Gauss–Newton steps to the least of (4), a number; chosen: it hardly moves after ten."""

HEAP, SLIP = 0.5, np.arange(-1.5, 1.6, 0.25)
"""px of (7); chosen: centroids are mostly noisy by a quarter of a pixel at most, calibrations off by 1 px."""

HEAP_SD, WIDEST = 1.3, 2.0
"""Of (7), the least half width of a heap in standard deviations of (3), which holds four in five, and times that HEAP
grows at most; chosen on stands before three and four cameras all round with noise of 0.1 to 0.6 px."""

STRIPS = (3.0, 9.0)
"""px from the lines, between which pairs meet by chance; chosen: beyond SLIP with its heap, and within WINDOW."""

BY_CHANCE = 1e-4
"""Of (7), a probability; chosen: of the ten and more k of all pairs of three cameras together one in a thousand. On 184
scenes of three and four cameras, mostly all round (noise 0.1 to 0.6 px, files to 1 px off), 94 % of 441 pairs of good
cameras that share a marker in four of ten frames and more are partners so, and 3 of 136 pairs with a camera that was
turned, moved or refocused by 6 px and more."""


class CameraNoise(NamedTuple):
    """Variance (C) px² of the images of each camera, and its standard error (C) px² by the number of residuals; NaN
    where nothing is known."""

    variance: Floats
    error: Floats


class Residuals(NamedTuple):
    """H pairs of images.

    Attributes:
        off: (H) residuals of (1), px.
        camera: (2, H) r and s; detection: (2, H) indices of the images.
        line: (2, H, 2) l and l′ over the root of (1): the change of the residual, px a px that the image moves.
    """

    off: Floats
    camera: Ints
    detection: Ints
    line: Floats

    @property
    def window(self) -> Floats:
        """(H) px, the W of (3) by (6)."""
        return np.asarray(WINDOW * np.sqrt((self.line**2).sum(-1).min(0)))


class Mixture(NamedTuple):
    """v (n) px² of (3), and the number (n) of residuals that are one marker's, of n groups; weight (H) of each residual
    in v, 0 where it is two markers' for certain; what they are about (n) px, whose square is in v (5)."""

    variance: Floats
    number: Floats
    weight: Floats
    about: Floats


def pair_of(some: Residuals, C: int) -> Ints:
    """(H) the number of the two of C cameras that each residual is of, r C + s."""
    return some.camera[0] * C + some.camera[1]


def camera_noise(some: Residuals, fit: Mixture, C: int) -> CameraNoise:
    """The noise of C cameras by (4), from the mixtures (C²) that their residuals are."""
    usable = np.flatnonzero(peaked(fit))
    share = _shares(some, C)[usable]
    out = np.full((2, C), np.nan)
    known, own = np.unique(np.array(divmod(usable, C)), return_inverse=True)
    if len(known):
        out[:, known] = _by_camera(fit.variance[usable], fit.number[usable], share, own.reshape(2, -1))
    return CameraNoise(*out)


def pair_excess(some: Residuals, fit: Mixture, variance: Floats) -> Floats:
    """(C, C) v of two cameras as a ratio to w σ_r² + w′ σ_s² of variances (C) px², where it is more, up to MOST_FACTOR;
    1 where nothing is known."""
    C, share = len(variance), _shares(some, len(variance))
    r, s = np.divmod(np.arange(C * C), C)
    ratio = fit.variance / (share * variance[r] + (2 - share) * variance[s])
    out = np.where(peaked(fit), np.clip(ratio, 1.0, MOST_FACTOR), 1.0).reshape(C, C)
    return np.maximum(out, out.T)


def _shares(some: Residuals, C: int) -> Floats:
    """(C²) the mean of w of (2) of two cameras; 0 of those without residuals."""
    number = pair_of(some, C)
    return np.bincount(number, (some.line[0] ** 2).sum(-1), C * C) / np.maximum(np.bincount(number, minlength=C * C), 1)


def _chosen(which: Bools, group: Ints, some: Mixture, others: Mixture) -> Mixture:
    """The mixtures of `which` (n) groups, and the others; (H) the group of each residual."""
    columns = (which, which, which[group], which)
    return Mixture(*(np.where(*each) for each in zip(columns, some, others, strict=True)))


def peaked(fit: Mixture) -> Bools:
    """(n) whether a group has residuals of single markers enough, and so near that they are seen among the others."""
    return (fit.number >= MIN_PAIRS) & (fit.variance - fit.about**2 < MAX_SD**2)


def peak_height(fit: Mixture, n: int) -> float:
    """How many times as dense the peaks of (3) are as what else there is of n residuals."""
    ok = peaked(fit)
    height = (fit.number[ok] / np.sqrt(2 * np.pi * fit.variance[ok])).sum()
    return float(height * 2 * WINDOW / max(n - fit.number[ok].sum(), 1.0))


def residuals(images: Images, F: Floats, frames: list[int]) -> Residuals:
    """(1) of all pairs of images that lie within WINDOW of each other's lines."""
    rows = [own[~images.merged[own]] for own in images.in_frames(frames)]
    wide = images._replace(variance=np.broadcast_to(WINDOW**2 / 2, len(images.uv)))
    i, j = np.concatenate([near_lines(wide, part, F, 1.0) for part in batches(rows)], -1)
    r, s = images.camera[i], images.camera[j]
    x, other = (np.column_stack([images.uv[detection], np.ones(len(detection))]) for detection in (i, j))
    line = np.einsum("hij,hj->hi", F[r, s], x)
    back = np.einsum("hij,hi->hj", F[r, s], other)
    size, back_size = (line[:, :2] ** 2).sum(1), (back[:, :2] ** 2).sum(1)
    both = np.maximum((size + back_size) / 2, np.finfo(float).tiny)
    lines = np.array([back[:, :2], line[:, :2]]) / np.sqrt(both)[:, None]
    return Residuals((line * other).sum(1) / np.sqrt(both), np.array([r, s]), np.array([i, j]), lines)  # (1)


def partners(some: Residuals, C: int, frames: int) -> Bools:
    """(C, C) whether two cameras see the same markers where both are calibrated to (7).

    Args:
        some: residuals of so many cameras and frames.
    """
    pair, half = pair_of(some, C), HEAP * _heap_scale(some, C)
    near = np.abs(some.off - SLIP[:, None]) < half
    heap = np.max([np.bincount(pair[own], minlength=C * C) for own in near], axis=0)
    each = int((STRIPS[1] - STRIPS[0]) / (2 * half))  # strips on a side
    strip = np.floor((np.abs(some.off) - STRIPS[0]) / (2 * half)).astype(np.int64)
    own = (strip >= 0) & (strip < each)
    cell = (pair * 2 * each + strip + each * (some.off > 0))[own]
    count = np.bincount(cell, minlength=C * C * 2 * each).reshape(C * C, 2 * each)
    n, mean, squared = 2 * each, count.mean(1), count.var(1) * 2 * each
    usual = np.clip((squared.sum() + frames) / (mean.sum() * (n - 1) + 1), 1, frames)
    D = np.clip((squared + usual**2) / (mean * (n - 1) + usual), 1, frames)  # (8)
    found = scipy.special.gammainc(np.maximum(heap, 0.5) / D, mean / D + 0.5 / n) < BY_CHANCE
    found = found.reshape(C, C)
    return np.asarray(found | found.T)


def _heap_scale(some: Residuals, C: int) -> float:
    """How many times as wide as usual the heaps of (7) are, by the noise."""
    fit = mixture(some.off, pair_of(some, C), C * C, some.window)
    if not (ok := peaked(fit)).any():
        return 1.0
    sd = np.sqrt(fit.variance[ok])
    return float(np.clip(HEAP_SD * sd[(fit.number[ok] / sd).argmax()] / HEAP, 1.0, WIDEST))


def mixture(off: Floats, group: Ints, n: int, window: Floats, *, each: bool = False) -> Mixture:
    """(3) of residuals (H) px in n groups (H), each within its window (H) px; where none has a peak at 0, about those
    that they have elsewhere; with `each`, each that is SURE likelier so, whatever others have (5)."""
    usual, said = _likeliest(off, group, n, window)
    none = not peaked(usual).any()
    if not (none or each) or not (aside := _peak_aside(off, group, n)).any():
        return usual
    other, other_said = _mixture(off - aside[group], group, window, aside, PEAK**2)
    return _chosen((aside != 0) & (none | (other_said > said + SURE)), group, other, usual)


def _peak_aside(off: Floats, group: Ints, n: int) -> Floats:
    """(n) px, where the residuals (H) of each group are densest, 0 where they are not CLEAR times as dense there as
    anywhere else."""
    edges = np.linspace(-WINDOW, WINDOW, round(2 * WINDOW / PEAK) + 1)
    out = np.zeros(n)
    for g in np.unique(group).tolist():
        count = np.convolve(np.histogram(off[group == g], edges)[0], np.ones(3), "same")
        best = int(count.argmax())
        elsewhere = np.abs(np.arange(len(count)) - best) > 3
        if count[best] > max(CLEAR * count[elsewhere].max(), MIN_PAIRS):
            out[g] = (edges[best] + edges[best + 1]) / 2
    return out


def _likeliest(off: Floats, group: Ints, n: int, window: Floats) -> tuple[Mixture, Floats]:
    """(3) about 0, begun with a wide v, and with a narrow one where it became wider and that is likelier; ln L (n)."""
    begin = (WINDOW / 4) ** 2
    usual, said = _mixture(off, group, window, np.zeros(n), begin)
    if not (wider := usual.variance > begin).any():
        return usual, said
    narrow, narrow_said = _mixture(off, group, window, np.zeros(n), NARROW**2)
    better = wider & (narrow_said > said + SURE)
    return _chosen(better, group, narrow, usual), np.where(better, narrow_said, said)


def _mixture(off: Floats, group: Ints, window: Floats, about: Floats, begin: Floats | float) -> tuple[Mixture, Floats]:
    """(3) of residuals (H) px less what they are about (n) px, v being `begin` (n) px² at first; ln L (n)."""
    n = len(about)
    total = np.maximum(np.bincount(group, minlength=n), 1)
    variance, share, count = np.zeros(n) + begin, np.full(n, 0.5), np.zeros(n)
    squared = off * off
    for _ in range(ROUNDS):
        v, p = variance[group], share[group]
        exponent, height = squared / (-2 * v), p / np.sqrt(2 * np.pi * v)
        core = height * (1 - WIDER_SHARE) * np.exp(exponent)
        wider = height * WIDER_SHARE / WIDER * np.exp(exponent / WIDER**2)
        whole = core + wider + (1 - p) / (2 * window)
        core, wider = core / whole, wider / whole
        count = np.asarray(np.bincount(group, core + wider, n), np.float64)
        moment = np.bincount(group, (core + wider / WIDER**2) * squared, n)
        before, variance = variance, np.maximum(moment / np.maximum(count, 1e-9), 1e-6)
        share = count / total
        if (np.abs(variance - before) <= SETTLED * before)[count > MIN_PAIRS].all():
            break
    said = np.asarray(np.bincount(group, np.log(whole), n), np.float64)
    return Mixture(variance + about**2, count, core + wider / WIDER**2, about), said


def _by_camera(variance: Floats, count: Floats, share: Floats, pair: Ints) -> tuple[Floats, Floats]:
    """(n) px² by (4) and their standard errors, from v, n and w (K) of pairs of n cameras (2, K)."""
    a = _solved(variance, PAIR_LOG_SD**2 + 2 / count, share, pair)
    return np.exp(a), np.exp(a) * np.sqrt(4 / np.bincount(pair.ravel(), np.tile(count, 2)))


def _solved(v: Floats, log_variance: Floats, share: Floats, pair: Ints) -> Floats:
    """a (n) of (4), from v (K) of pairs of n cameras (2, K), the variance (K) of its logarithm, and w (K)."""
    (r, s), k, n = pair, np.arange(len(v)), int(pair.max()) + 1
    certain = 1 / np.sqrt(log_variance)
    alike = (np.eye(n) - 1 / n) / CAMERA_LOG_SD
    a = np.full(n, np.log(np.median(v) / 2))
    for _ in range(STEPS):
        parts = np.array([share * np.exp(a[r]), (2 - share) * np.exp(a[s])])
        J = np.zeros((len(k), n))
        J[k, r], J[k, s] = parts / parts.sum(0)
        missing = np.minimum(v / parts.sum(0), MOST_FACTOR) - 1
        A = np.vstack([J * certain[:, None], alike])
        a = a + np.linalg.lstsq(A, np.concatenate([missing * certain, -alike @ a]), rcond=None)[0]
    return a
