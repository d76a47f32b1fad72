"""The grey-weighted centroid of each group, with its covariance.

White pixels alone give a biased centroid: the threshold cuts the rim off pixel by pixel, more on one side
than on the other. So a group is widened by one pixel all round, which holds the rim, and the next pixel
all round is the background: with b its mean,

    w = I − b,   S = Σ w,   ū = Σ w x / S,   v̄ = Σ w y / S               (1)

where the sums run over the widened group. A pixel of variance σ² + g w (noise of a dark pixel; photon
noise, g = `shot`) moves ū by (x − ū) / S a grey level, and b moves it by −Σ(x − ū) / S, so

    cov = Σ (σ² + g w) (x − ū)(x − ū)ᵀ / S²                              (2)
        + (σ² / m) (Σ(x − ū)) (Σ(x − ū))ᵀ / S²                           (3)
        + (e m r² / 2 / S² + FLOOR / A) 1                                (4)

with x = (x, y), m background pixels and A the number of white pixels. (4) is what would remain without
noise. Where the m pixels around differ by more than noise, their excess of variance e is the skirt of a
blurred marker, or a neighbour, cut through at radius r = √(A / π) + 1.5: it pulls as a noise of variance e on
that circle would. And pixels are squares: on sharp discs of 5, 8 and 12 px that leaves 0.0041, 0.0021 and
0.0012 px, no more than 0.02 / diameter, and half of that at a blur of half a pixel.

Within a line a widened group is one stretch of pixels L … R (gaps inside are filled), and the sums of
1, x and x² over a stretch are polynomials of L and R (5); only Σ I and Σ I x need the pixels themselves.
Widening by one pixel takes the least L and greatest R of a line and its two neighbours, and one more (6).

The area is S / (peak − b) (7): a pixel at the rim counts by the share of it that is bright, so that the areas of one
marker in several images agree within a per cent, where counts of white pixels would differ by five.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .grouping import Groups

FLOOR = 0.02**2 * np.pi / 4
MARGIN = 2  # one line for the rim, one for the background
EMPTY = 1 << 40


class Stretches(NamedTuple):
    """Pixels left … right of `line` of the tall image, of group `of` (index); right < left where empty."""

    of: NDArray[np.int64]
    line: NDArray[np.int64]
    left: NDArray[np.int64]
    right: NDArray[np.int64]


class Sums(NamedTuple):
    """Per group (G): sums of 1, x, y, x², xy, y² over its pixels, times a weight; x from `left`, y from `top`."""

    one: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    xx: NDArray[np.float64]
    xy: NDArray[np.float64]
    yy: NDArray[np.float64]

    def about(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """(G, 2, 2) Σ (x − ū)(x − ū)ᵀ with the same weights."""
        xx = self.xx - 2 * u * self.x + u * u * self.one
        xy = self.xy - u * self.y - v * self.x + u * v * self.one
        yy = self.yy - 2 * v * self.y + v * v * self.one
        return np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2)


class Moments(NamedTuple):
    """Centroid (G, 2) px in the group's own frame; covariance (G, 2, 2) px²; area (G) px²; peak (G) grey level."""

    uv: NDArray[np.float64]
    cov: NDArray[np.float64]
    area: NDArray[np.float64]
    peak: NDArray[np.float64]


def measure(
    images: NDArray[np.uint8 | np.uint16],
    groups: Groups,
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
    if len(groups.area) == 0:
        return Moments(np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0), np.zeros(0))
    rim, around = _widened(groups, *images.shape[1:])
    ones = _geometry(rim, groups)
    grey, peak = _grey(images, rim, groups, squares=shot > 0)
    sigma2 = variance[groups.frame]
    b, m, excess = _background(images, around, level[groups.frame], sigma2)
    b = np.minimum(b, threshold)
    w = Sums(*(of_grey - b * of_one for of_grey, of_one in zip(grey, ones, strict=True)))
    with np.errstate(divide="ignore", invalid="ignore"):  # S may be 0 or less: seen to below
        u, v = w.x / w.one, w.y / w.one  # (1)
        lever = np.stack([ones.x - u * ones.one, ones.y - v * ones.one], -1)
        moved = sigma2[:, None, None] * ones.about(u, v) + (shot * w.about(u, v) if shot > 0 else 0.0)  # (2)
        moved += (sigma2 / np.maximum(m, 1))[:, None, None] * lever[:, :, None] * lever[:, None, :]  # (3)
        moved += (excess * m * (np.sqrt(groups.area / np.pi) + 1.5) ** 2 / 2)[:, None, None] * np.eye(2)
        cov = moved / (w.one**2)[:, None, None] + (FLOOR / groups.area)[:, None, None] * np.eye(2)  # (4)
    wide, high = groups.right - groups.left, groups.bottom - groups.top
    wrong = ~((w.one > 0) & (u >= 0) & (v >= 0) & (u <= wide) & (v <= high))
    uv = np.stack([u + groups.left, v + (groups.top - groups.frame * images.shape[1])], -1)
    area = np.where(wrong, groups.area, w.one / np.maximum(peak - b, 1.0))  # (7)
    if wrong.any():
        uv[wrong] = outline_centroids(groups, height=images.shape[1])[wrong]
        cov[wrong] = (np.stack([wide, high], -1) + 1)[wrong, :, None] ** 2 / 12 * np.eye(2)
    return Moments(uv, cov, area, peak)


def outline_centroids(groups: Groups, *, height: int) -> NDArray[np.float64]:
    """(G, 2) centroid of the white pixels alone, KISS eq. 2: for groups that are no markers anyway."""
    first, last = groups.runs.first, groups.runs.last
    n = last - first + 1
    of = np.repeat(np.arange(len(groups.area)), np.diff(groups.start))
    y = groups.runs.y - groups.frame[of] * height
    u, v = (np.bincount(of, n * at, len(groups.area)) for at in ((first + last) / 2, y))
    return np.stack([u, v], -1) / groups.area[:, None]


def _widened(groups: Groups, height: int, width: int) -> tuple[Stretches, Stretches]:
    """The stretches of each group with its rim, and the background's left and right of it, within the image."""
    lines = groups.bottom - groups.top + 1 + 2 * MARGIN
    begin = np.cumsum(lines) - lines
    of = np.repeat(np.arange(len(lines)), lines)
    line = np.arange(len(of)) + np.repeat(groups.top - MARGIN - begin, lines)
    left, right = np.full(len(of), EMPTY), np.full(len(of), -EMPTY)
    y, first, last = groups.runs
    row = y + np.repeat(begin + MARGIN - groups.top, np.diff(groups.start))
    fresh = np.concatenate([[True], row[1:] != row[:-1]])
    left[row[fresh]] = first[fresh]
    right[row] = last  # of several runs in one line the last stays
    inside = line // height == groups.frame[of]
    rim_left, rim_right = _wider(left, right)
    out_left, out_right = _wider(rim_left, rim_right)
    dark = rim_right < rim_left  # lines above and below the rim are background all along
    rim = _clipped(of, line, rim_left, rim_right, width, inside)
    before = _clipped(of, line, out_left, np.where(dark, out_right, rim_left - 1), width, inside)
    after = _clipped(of, line, np.where(dark, EMPTY, rim_right + 1), out_right, width, inside)
    return rim, Stretches(*(np.concatenate(pair) for pair in zip(before, after, strict=True)))


def _wider(left: NDArray[np.int64], right: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """One pixel more all round; empty lines between groups keep them apart."""
    low, high = left.copy(), right.copy()
    np.minimum(low[1:], left[:-1], out=low[1:])
    np.minimum(low[:-1], left[1:], out=low[:-1])
    np.maximum(high[1:], right[:-1], out=high[1:])
    np.maximum(high[:-1], right[1:], out=high[:-1])
    return low - 1, high + 1  # (6)


def _clipped(
    of: NDArray[np.int64],
    line: NDArray[np.int64],
    left: NDArray[np.int64],
    right: NDArray[np.int64],
    width: int,
    inside: NDArray[np.bool_],
) -> Stretches:
    """The part of the stretches within the image, without empty ones."""
    left, right = np.maximum(left, 0), np.minimum(right, width - 1)
    kept = inside & (left <= right)
    return Stretches(of[kept], line[kept], left[kept], right[kept])


def _pixels(stretches: Stretches, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Flat index (N) of every pixel, and where each stretch starts among them (stretches)."""
    n = stretches.right - stretches.left + 1
    start = np.cumsum(n) - n
    return np.arange(n.sum()) + np.repeat(stretches.line * width + stretches.left - start, n), start


def _background(
    images: NDArray[np.uint8 | np.uint16],
    around: Stretches,
    level: NDArray[np.float64],
    sigma2: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Of the pixels around each group: mean grey level (G), number (G), and variance that noise leaves open (G)."""
    pixel, start = _pixels(around, images.shape[2])
    if len(pixel) == 0:
        return level, np.zeros(len(level)), np.zeros(len(level))
    grey = images.reshape(-1)[pixel].astype(np.int64)
    number = np.bincount(around.of, around.right - around.left + 1, len(level)).astype(np.float64)
    m = np.maximum(number, 1)
    total, squares = (
        np.bincount(around.of, np.add.reduceat(column, start), len(level)) for column in (grey, grey * grey)
    )
    b = np.where(number > 0, total / m, level)
    excess = squares / m - (total / m) ** 2 - sigma2 * (1 + np.sqrt(2 / m))
    return b, number, np.maximum(excess, 0.0)


def _geometry(rim: Stretches, groups: Groups) -> Sums:
    """`Sums` of pixels that all weigh 1."""
    left, right = (side - groups.left[rim.of] for side in (rim.left, rim.right))
    n = right - left + 1
    x = n * (left + right) / 2
    xx = (right * (right + 1) * (2 * right + 1) - (left - 1) * left * (2 * left - 1)) / 6  # (5)
    return _by_group(rim, groups, n, x, xx)


def _grey(
    images: NDArray[np.uint8 | np.uint16], rim: Stretches, groups: Groups, *, squares: bool
) -> tuple[Sums, NDArray[np.float64]]:
    """`Sums` of pixels that weigh their grey level, and the greatest level (G); Σ x² only where `squares`."""
    pixel, start = _pixels(rim, images.shape[2])
    raw = images.reshape(-1)[pixel]
    grey = raw.astype(np.int64)
    total = np.add.reduceat(grey, start)
    zero = rim.line * images.shape[2] + groups.left[rim.of]  # pixel of x = 0
    x = np.add.reduceat(grey * pixel, start) - zero * total
    xx = np.zeros(len(start))
    if squares:
        local = pixel - np.repeat(zero, rim.right - rim.left + 1)
        xx = np.add.reduceat(grey * local * local, start).astype(np.float64)
    peak = np.maximum.reduceat(raw, start[_heads(rim, groups)])
    return _by_group(rim, groups, total, x, xx), peak.astype(np.float64)


def _by_group(rim: Stretches, groups: Groups, one: NDArray[Any], x: NDArray[Any], xx: NDArray[Any]) -> Sums:
    """`Sums` (G) from Σ, Σ x and Σ x² of every stretch."""
    y = rim.line - groups.top[rim.of]
    columns = np.stack([one, x, y * one, xx, y * x, y * y * one]).astype(np.float64)
    return Sums(*np.add.reduceat(columns, _heads(rim, groups), axis=1))


def _heads(rim: Stretches, groups: Groups) -> NDArray[np.int64]:
    """(G) the first stretch of each group; every group has one."""
    return np.searchsorted(rim.of, np.arange(len(groups.area)))
