"""The grey-weighted centroid of each group, with its covariance.

White pixels alone give a biased centroid: the threshold cuts the rim off pixel by pixel, more on one side
than on the other. So a group is widened by one pixel all round, which holds the rim, and the next pixel
all round is the background: with b its mean,

    w = I − b,   S = Σ w,   ū = Σ w x / S,   v̄ = Σ w y / S               (1)

where the sums run over the widened group. A pixel of variance σ² + g w (noise of a dark pixel; photon
noise, g = `shot_noise`) moves ū by (x − ū) / S a grey level, and b moves it by −Σ(x − ū) / S, so

    cov = Σ (σ² + g w) (x − ū)(x − ū)ᵀ / S²                              (2)
        + (σ² / m) (Σ(x − ū)) (Σ(x − ū))ᵀ / S²                           (3)
        + (e m r² / 2 / S² + FLOOR / A) 1                                (4)

with x = (x, y), m background pixels and A the number of white pixels. (4) is what would remain without
noise. Where the m pixels around differ by more than noise, their excess of variance e is the skirt of a
blurred marker, or a neighbour, cut through at radius r = √(A / π) + 1.5: it pulls as a noise of variance e on
that circle would. And pixels are squares: on sharp discs of 5, 8 and 12 px that leaves 0.0041, 0.0021 and
0.0012 px, no more than 0.02 / diameter, and half of that at a blur of half a pixel.

Pixels also sample small markers too coarsely. Light of variance s² px² along an axis, as of a Gaussian, that is sampled
once a pixel has its centroid off by 4π s² exp(−2π² s²) sin 2πφ, where φ is its place in the pixel (the first term of
Poisson's sum), which gives that axis the variance

    (4π s² exp(−2π² s²))² / 2                                            (6)

with s² from the second moments of w, and 1/(2π²) at least, where (6) is greatest. It is nothing to markers of 4 px; to
the smallest ones, and to the lines of a field, it is all.

The area is S / (peak − b) (5): a pixel at the rim counts by the share of it that is bright, so that the areas of one
marker in several images agree within a per cent, where counts of white pixels would differ by five.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .grouping import PixelGroups
from .sums import PixelSums, Sums, pixel_sums

FLOOR = 0.02**2 * np.pi / 4
"""px² · px²; 0.02 px of error for a marker of 1 px, less for larger ones; chosen, for what the model leaves out."""


class Moments(NamedTuple):
    """Centroid (G, 2) px in the group's own frame; covariance (G, 2, 2) px²; area (G) px²; peak (G) grey level."""

    uv: NDArray[np.float64]
    cov: NDArray[np.float64]
    area: NDArray[np.float64]
    peak: NDArray[np.float64]


def measure(
    images: NDArray[np.uint8 | np.uint16],
    groups: PixelGroups,
    *,
    threshold: float,
    level: NDArray[np.float64],
    variance: NDArray[np.float64],
    shot: float,
) -> Moments:
    """Centroids of groups in frames (n, H, W) whose background has this level (n) and noise variance (n).

    Where no background pixel is within the image, the frame's level stands for b in (1); b is never above
    the threshold. Where the rim is so much darker than the background that (1) leaves the group's rectangle, the
    centroid is that of the white pixels alone, uncertain by the rectangle.
    """
    sums = pixel_sums(images, groups)
    sigma2 = variance[groups.frame]
    b, excess = _background(sums, level[groups.frame], sigma2)
    b = np.minimum(b, threshold)
    w = Sums(*(of_grey - b * of_one for of_grey, of_one in zip(sums.grey, sums.ones, strict=True)))
    with np.errstate(divide="ignore", invalid="ignore"):  # S may be 0 or less: seen to below
        u, v = w.x / w.one, w.y / w.one  # (1)
        cov = _covariance(sums, groups.area, w, u, v, sigma2, excess, shot)
    wide, high = groups.right - groups.left, groups.bottom - groups.top
    wrong = ~((w.one > 0) & (u >= 0) & (v >= 0) & (u <= wide) & (v <= high))
    uv = np.stack([u + groups.left, v + (groups.top - groups.frame * images.shape[1])], -1)
    area = np.where(wrong, groups.area, w.one / np.maximum(sums.peak - b, 1.0))  # (5)
    if wrong.any():
        uv[wrong] = outline_centroids(groups, height=images.shape[1])[wrong]
        cov[wrong] = (np.stack([wide, high], -1) + 1)[wrong, :, None] ** 2 / 12 * np.eye(2)
    return Moments(uv, cov, area, sums.peak)


def _covariance(
    sums: PixelSums,
    area: NDArray[np.int64],
    w: Sums,
    u: NDArray[np.float64],
    v: NDArray[np.float64],
    sigma2: NDArray[np.float64],
    excess: NDArray[np.float64],
    shot: float,
) -> NDArray[np.float64]:
    """(G, 2, 2) px², from the elements xx, xy and yy."""
    x, y = sums.ones.x - u * sums.ones.one, sums.ones.y - v * sums.ones.one
    moved = sigma2 * sums.ones.about(u, v)
    if shot > 0:
        moved += shot * w.about(u, v)  # (2)
    moved += sigma2 / np.maximum(sums.ring, 1) * np.stack([x * x, x * y, y * y])  # (3)
    moved[::2] += excess * sums.ring * (np.sqrt(area / np.pi) + 1.5) ** 2 / 2
    cov = moved / w.one**2
    cov[::2] += FLOOR / area  # (4)
    cov[::2] += _undersampled(w.about(u, v)[::2] / w.one)
    return np.ascontiguousarray(cov[[0, 1, 1, 2]].T).reshape(-1, 2, 2)


def _undersampled(spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6) of markers whose light has these variances (2, G) px² along the axes."""
    s2 = np.maximum(spread, 1 / (2 * np.pi**2))
    return np.asarray((4 * np.pi * s2 * np.exp(-2 * np.pi**2 * s2)) ** 2 / 2)


def _background(
    sums: PixelSums, level: NDArray[np.float64], sigma2: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean grey level of the pixels around each group (G), and their variance that noise leaves open (G)."""
    m = np.maximum(sums.ring, 1)
    mean = sums.ring_grey / m
    excess = sums.ring_squares / m - mean**2 - sigma2 * (1 + np.sqrt(2 / m))
    return np.where(sums.ring > 0, mean, level), np.maximum(excess, 0.0)


def outline_centroids(groups: PixelGroups, *, height: int) -> NDArray[np.float64]:
    """(G, 2) centroid of the white pixels alone, KISS eq. 2: for groups that are no markers anyway."""
    first, last = groups.runs.first, groups.runs.last
    n = last - first + 1
    of = np.repeat(np.arange(len(groups.area)), np.diff(groups.start))
    y = groups.runs.y - groups.frame[of] * height
    u, v = (np.bincount(of, n * at, len(groups.area)) for at in ((first + last) / 2, y))
    return np.stack([u, v], -1) / groups.area[:, None]
