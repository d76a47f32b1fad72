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
that circle would; r along each axis where fields make them differ.

Pixels also sample a marker too coarsely. With G(ν) the Fourier transform along an axis of the light that a pixel at any
place would see, at ν cycles a pixel, samples one pixel apart have their centroid off by |G'(1)| / π · sin 2πφ, where φ
is its place in the pixel (the first term of Poisson's sum). The light is a disc, blurred, and summed over the pixel,

    G(ν) = D(π a ν) sinc(h ν) exp(−2π² σ² ν²),    D(x) = 2 J₁(x) / x                                  (6)

with a the diameter and σ the blur along the axis, in its own pixels, and h the share of the axis that pixels cover: 1,
and for lines that are taken from every second row of a sensor ½. So an axis has the variance

    (G'(1))² / 2π²,    G'(1) = [(cos πh − (1 + 4π² σ²) sinc h) D − 2 J₂ sinc h] exp(−2π² σ²),  x = π a   (7)

which for h = 1 is (D exp(−2π² σ²))² / 2π². Where lines are apart, h < 1, the terms between lines count across them:
for u, D² becomes D² + 2 (sinc h · D(π √(a_u² + a_v²)))², with the blur of both (8). A marker that is longer than wide
and stands aslant brings t times the error of v to u, t = Σ w x y / Σ w y² about the centroid (9).

a follows from the area, (5), the peak less what noise adds to the brightest of many, √(2 ln A) standard deviations; σ
from the second moment, s² = a²/16 + σ² + 1/12, along u where pixels are densest there, else the mean of both axes. As a
is not known to better than some per cent, (7) is a mean over it (`NODES`). All of it is nothing to blurred markers of
4 px; to the smallest, and to the lines of a field, it is most of the error.

The area is S / (peak − b) (5): a pixel at the rim counts by the share of it that is bright, so that the areas of one
marker in several images agree within a per cent, where counts of white pixels would differ by five.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats
from .grouping import PixelGroups
from .sums import PixelSums, Sums, pixel_sums

FLOOR = 0.01**2 * np.pi / 4
"""px² · px²; 0.01 px of error for a marker of 1 px, less for larger ones; chosen, for what the model leaves out."""


NODES, WEIGHTS = 1 + 0.04 * np.sqrt(3) * np.array([-1.0, 0.0, 1.0]), np.array([1.0, 4.0, 1.0]) / 6
"""Of Gauss and Hermite's mean over a diameter that is known to 4 % (7); chosen: spheres seen at 25° are 9 % longer than
wide."""


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
    aspect: float = 1.0,
) -> Moments:
    """Centroids of groups in frames (n, H, W) whose background has this level (n) and noise variance (n).

    Where no background pixel is within the image, the frame's level stands for b in (1); b is never above
    the threshold. Where the rim is so much darker than the background that (1) leaves the group's rectangle, the
    centroid is that of the white pixels alone, uncertain by the rectangle. `aspect` is the height of a round marker's
    image by its width: ½ for lines that are every second row of the sensor.
    """
    sums = pixel_sums(images, groups)
    sigma2 = variance[groups.frame]
    b, excess = _background(sums, level[groups.frame], sigma2)
    b = np.minimum(b, threshold)
    w = Sums(*(of_grey - b * of_one for of_grey, of_one in zip(sums.grey, sums.ones, strict=True)))
    with np.errstate(divide="ignore", invalid="ignore"):  # S may be 0 or less: seen to below
        u, v = w.x / w.one, w.y / w.one  # (1)
        cov = _covariance(sums, groups.area, w, u, v, sigma2, excess, shot, aspect)
        cov += _undersampled(w.about(u, v) / w.one, w.one / _plateau(sums, b, sigma2), aspect)
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
    aspect: float,
) -> NDArray[np.float64]:
    """(G, 2, 2) px², from the elements xx, xy and yy."""
    x, y = sums.ones.x - u * sums.ones.one, sums.ones.y - v * sums.ones.one
    moved = sigma2 * sums.ones.about(u, v)
    if shot > 0:
        moved += shot * w.about(u, v)  # (2)
    moved += sigma2 / np.maximum(sums.ring, 1) * np.stack([x * x, x * y, y * y])  # (3)
    for axis, longer in ((0, 1 / aspect), (2, aspect)):
        moved[axis] += excess * sums.ring * (np.sqrt(area * longer / np.pi) + 1.5) ** 2 / 2
    cov = moved / w.one**2
    cov[::2] += FLOOR / area  # (4)
    return np.ascontiguousarray(cov[[0, 1, 1, 2]].T).reshape(-1, 2, 2)


def _plateau(sums: PixelSums, b: Floats, sigma2: Floats) -> Floats:
    """(G) grey levels of each marker above its background, the peak less what noise adds to it."""
    peak = np.maximum(sums.peak - b, 1.0)
    return np.maximum(peak - np.sqrt(2 * np.log(np.maximum(sums.grey.one / sums.peak, 1.0)) * sigma2), peak / 2)


def _undersampled(spread: Floats, area: Floats, aspect: float) -> Floats:
    """(G, 2, 2) px² by (7) to (9), of light of these second moments (3, G) px² and area (G) px²."""
    h, wide = min(aspect, 1.0), spread[0] if aspect < 1 else (spread[0] + spread[2] / aspect**2) / 2
    wide = np.maximum(wide - 1 / 12, 1e-3)
    square = np.minimum(4 / (np.pi * aspect) * np.maximum(area, 0.0), 16 * wide)  # a_u²
    blur = wide - square / 16  # σ²
    fade_u, fade_v = np.exp(-4 * np.pi**2 * blur), np.exp(-4 * np.pi**2 * aspect**2 * blur)
    a = np.sqrt(square) * NODES[:, None]
    along = _disc(np.pi * a)
    if aspect == 1:  # both axes are alike, and nothing is between lines
        return (fade_u * (WEIGHTS @ along**2) / (2 * np.pi**2))[:, None, None] * np.eye(2)
    between = _disc(np.pi * a * np.hypot(1, aspect))
    x, sinc = np.pi * a * aspect, np.sinc(h)
    disc = _disc(x)
    across = (np.cos(np.pi * h) - (1 + 4 * np.pi**2 * aspect**2 * blur) * sinc) * disc
    across -= 2 * sinc * (disc - scipy.special.j0(x))  # J₂ = 2 J₁ / x − J₀
    u = fade_u * (WEIGHTS @ along**2 + 2 * fade_v * sinc**2 * (WEIGHTS @ between**2))
    v = fade_v * (WEIGHTS @ across**2)
    shear = spread[1] / np.maximum(spread[2], 1e-3) if h < 1 else np.zeros_like(wide)  # (9)
    return np.ascontiguousarray(np.stack([u + shear**2 * v, shear * v, shear * v, v]).T).reshape(-1, 2, 2) / (
        2 * np.pi**2
    )


def _disc(x: Floats) -> Floats:
    """D of (6)."""
    return np.asarray(2 * scipy.special.j1(x) / x)


def _background(
    sums: PixelSums, level: NDArray[np.float64], sigma2: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean grey level of the pixels around each group (G), and their variance that noise leaves open (G)."""
    m = np.maximum(sums.ring, 1)
    mean = sums.ring_grey / m
    excess = sums.ring_squares / m - mean**2 - sigma2 * (1 + np.sqrt(2 / m))
    return np.where(sums.ring > 0, mean, level), np.maximum(excess, 0.0)


def white_moments(images: NDArray[np.uint8 | np.uint16], groups: PixelGroups) -> Moments:
    """Means, numbers and brightest of the white pixels of groups in frames (n, H, W), where grey levels do not count.

    The covariance is that of an ellipse whose outline crosses each line somewhere in a pixel: 4 / (9 π² h) along u and
    4 / (9 π² w) along v, for a marker w px wide and h px high; `kiss.white_centroids` derives it.
    """
    wide, high = groups.right - groups.left + 1, groups.bottom - groups.top + 1
    cov = 4 / (9 * np.pi**2) / np.stack([high, wide], -1)[:, :, None] * np.eye(2)
    uv = outline_centroids(groups, height=images.shape[1])
    return Moments(uv, cov, groups.area.astype(np.float64), pixel_sums(images, groups).peak)


def outline_centroids(groups: PixelGroups, *, height: int) -> NDArray[np.float64]:
    """(G, 2) centroid of the white pixels alone, KISS eq. 2."""
    first, last = groups.runs.first, groups.runs.last
    n = last - first + 1
    of = np.repeat(np.arange(len(groups.area)), np.diff(groups.start))
    y = groups.runs.y - groups.frame[of] * height
    u, v = (np.bincount(of, n * at, len(groups.area)) for at in ((first + last) / 2, y))
    return np.stack([u, v], -1) / groups.area[:, None]
