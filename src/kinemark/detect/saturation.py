"""Pixels at the sensor's white have no noise, so the covariance of a centroid must not count it.

Of a marker brighter than the sensor can tell only the rim has noise: from (2) of `moments`

    cov − Σ σ² (x − ū)(x − ū)ᵀ / S²   over the pixels at white            (1)

The photon noise of such pixels goes with it. White is the highest level that the type of the images holds, or, in
video, the highest level of a frame where at least `SHARED` groups have it as their peak and most of their pixels near
it have it exactly: with noise on a plateau few would (2). The centroid itself needs no correction, as clipping is the
same on all sides; nor does the area S / (peak − b), only that a clipped disc is larger by what its blurred rim is.

But the rim is sharper where it is clipped, and its 2π r pixels show less of where it crosses them. When each is off by
a share e of the brightness, e² Σ x² / S² = e² 2π r (r²/2) / (π r²)² gives each axis the variance

    e² / (π r)                                                           (3)

In simulated discs of 5 to 20 px that are 1.5, 2 and 4 times too bright, e is 0.02, 0.04 and 0.07 at a blur of half a
pixel; `SHARP` stands for all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import native
from ..numerics.runs import equal_runs
from .blobs import Blobs
from .grouping import PixelGroups

SHARED = 3  # groups with one peak level, from which on it is white; chosen: two may share it by chance
SHARP = 0.04  # px² a pixel of rim, of sharp images at white; chosen to stand for all blurs


def without_clipped(
    images: NDArray[np.uint8 | np.uint16],
    groups: PixelGroups,
    blobs: Blobs,
    *,
    ground: NDArray[np.float64],
    variance: NDArray[np.float64],
    shot: float,
) -> Blobs:
    """The blobs of these groups in frames (n, H, W) with the covariance of (1); ground and noise variance are (n)."""
    at_white = np.flatnonzero(_maybe(blobs.peak, groups.frame, images.dtype))
    if not len(at_white):
        return blobs
    peak = blobs.peak[at_white]
    dark = ground[groups.frame[at_white]]
    sigma = np.sqrt(variance[groups.frame[at_white]])
    mask = np.zeros(len(groups.area), np.bool_)
    mask[at_white] = True
    some = groups.keep(mask)
    near = peak - np.maximum(3 * sigma, 1.0)
    at, above, xx, xy, yy = native.sum_peaks(images, some.start, *some.runs, peak, near, blobs.uv[at_white])
    sure = at > 0.5 * above  # (2)
    S = blobs.area[at_white] * np.maximum(peak - dark, 1.0)
    noise = sigma**2 + shot * np.maximum(peak - dark, 0.0)
    less = np.stack([xx, xy, xy, yy], -1).reshape(-1, 2, 2) * (noise / S**2 * sure)[:, None, None]
    cov = blobs.cov.copy()
    cov[at_white] -= less * _share(cov[at_white], less)[:, None, None]  # (1)
    r = np.sqrt(np.maximum(blobs.area[at_white], 1.0) / np.pi)
    cov[at_white] += (sure * SHARP**2 / (np.pi * r))[:, None, None] * np.eye(2)  # (3)
    return blobs._replace(cov=cov)


def _maybe(
    peak: NDArray[np.float64], frame: NDArray[np.int64], dtype: np.dtype[np.uint8 | np.uint16]
) -> NDArray[np.bool_]:
    """(G) whether a group's peak may be white."""
    ends = equal_runs(frame)  # of each frame that has groups, which are sorted by frame
    first, number = ends[:-1], np.diff(ends)
    if not len(first):
        return np.zeros(0, np.bool_)
    highest = np.fmax.reduceat(peak, first)
    top = peak == np.repeat(highest, number)
    shared = np.add.reduceat(top, first, dtype=np.int64) >= SHARED
    return np.asarray((peak == np.iinfo(dtype).max) | (top & np.repeat(shared, number)))


def _share(cov: NDArray[np.float64], less: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n) how much of `less` may go so that every variance keeps at least a tenth, as rounding could take more."""
    diagonal = np.einsum("nii->ni", cov), np.einsum("nii->ni", less)
    return np.asarray(np.minimum(1.0, (0.9 * diagonal[0] / np.maximum(diagonal[1], 1e-300)).min(1)))
