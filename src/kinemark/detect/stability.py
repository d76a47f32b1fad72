"""Which threshold parts the markers of some images from their noise.

With b the median of all pixels and σ the noise of the dark ones (`noise`), let N(c) be the number of groups of pixels
brighter than b + c, in all the images together, that are no lone pixels (`specks`) and have a pixel brighter than
b + 2 c: what noise and the texture of a background raise above a threshold is barely above it. Still, low thresholds
find folds, reflections and glows that hold several markers together, and above the dimmest markers N falls
one by one; between lies a stretch in which it hardly changes. So c runs over

    c_k = c_0 q^k,   c_0 = max(3 σ, 2 levels)                            (1)

up to half the brightest pixel, and of all stretches k₁ … k₂ with

    max N − min N ≤ 0.1 max N + 0.25 n                                   (2)

for n images, and N ≥ n / 2, the gap between noise and markers is the one with the greatest

    (√c₂ − √c₁) log(1 + N̄ / n)                                           (A)

which measures brightness so that photon noise is even, and prefers many markers to a few strobes. It is the stability
under a change of threshold by which Matas, Chum, Urban and Pajdla 2002 find regions, here of all groups at once.

The threshold is taken at 0.4 of the groups' median peak, or at half of the peak that only one in twenty is below, where
that is less: small markers are dim where they lie between two pixels (3). That is low enough to leave the rim of a
marker in its group, high enough to part it from its glow and from its neighbour. Where that lies outside the
gap, it is moved to its upper end, at which even the dimmest marker has twice the contrast, or to a tenth inside its
lower one and clear of noise: `CLEAR` σ above the median ground, and not within `CLEAR` standard deviations of the level
of any `SQUARE` of still ground, nor of what has one level in small squares of single images, as a body that moves has.
Where it is within, it is moved above that, and so on (6), but not above the dimmest marker. What is lit from a side is
so told from lamps and windows, at whose level nothing in between leads.

Compression that loses noise leaves σ no more than rounding does, and around markers remains that come and go, as many
as (2) allows. Groups then do not count in (3) that lie within BLOCK of one more than twice as bright (4): dim markers
lie anywhere. Where the ground is brighter in some images than in others, as under lamps that flicker, noise of the
bright ones is above (1), and peaks count where they stand out in the middle of the gap (5).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import native
from ..data.array_types import GreyLevels
from .background_noise import ROUNDING, background, row_medians
from .grouping import PixelGroups, group_runs
from .kiss.white import pixels_of
from .pixel_runs import Runs, find_runs
from .specks import blurred

STEPS = 36  # thresholds that are tried, evenly in their logarithm; chosen for speed
MOST_RUNS = 200_000  # in all images; a threshold with more lies in the noise; chosen
FEW = 0.05  # of the pixels, that are kept in mind; chosen for speed and memory
SHARE = 0.4  # of the peak's contrast; chosen: a little below half way, where the rim is

FLICKERS, SPARSE = 2.0, 8
"""σ by which the ground's median differs between images that flicker, and of how many lines and columns one is looked
at; chosen: lamps that flicker by 35 % change the ground by 4.5 σ, and what noise leaves of a median is far less."""

ALIKE = 128  # small squares, of about one level, whose noise is taken together; chosen: it is then known to 4 %
SQUARE, SMALL = 4, 2  # times `SPARSE`, px, a side; chosen: markers are less than half, and limbs fill small ones
CLEAR = 5.0  # standard deviations of noise that the threshold is above the ground at least; chosen
MEDIAN_SD = 1.4826 / math.sqrt(2)  # standard deviation of a pixel by the median distance of two; by definition
DIM, HALF = 5, 0.5  # per cent of the peaks that are dimmer, and the share of their contrast; chosen
BLOCK = 8  # px, to which compression spreads what it leaves of an edge; by definition of JPEG and of H.264


class LevelGap(NamedTuple):
    """Grey levels of the images' own kind.

    background: median b. noise: standard deviation σ of dark pixels. low, high: the gap's ends, NaN without one. peak:
    median peak of the groups in it. brightest: of all pixels. threshold: (3). groups: a frame, at the threshold.
    clear: noise of the ground does not reach this.
    """

    background: float
    noise: float
    low: float
    high: float
    peak: float
    brightest: float
    threshold: float
    groups: float
    clear: float


class BrightPixels(NamedTuple):
    """The pixels of some frames that are brighter than a level, so that higher levels need not look at all.

    key: (N) line (W + 1) + column, rising, with the width W, px; grey: (N) their grey levels.
    """

    level: float
    width: int
    key: NDArray[np.int64]
    grey: NDArray[np.uint8 | np.uint16]

    def runs(self, level: float) -> Runs:
        """The runs of those brighter than a level that is no lower; the first `MOST_RUNS`."""
        key = self.key[self.grey > level]
        end = np.flatnonzero(np.diff(key) != 1)
        first = key[np.concatenate([[0], end + 1])] if len(key) else key
        last = key[np.concatenate([end, [len(key) - 1]])] if len(key) else key
        y = first // (self.width + 1)
        return Runs(*(a[:MOST_RUNS] for a in (y, first - y * (self.width + 1), last - y * (self.width + 1))))


def bright_pixels(images: NDArray[np.uint8 | np.uint16], level: float) -> BrightPixels | None:
    """Those of frames (n, H, W) that are brighter than a level; None where they are too many to be worth it."""
    n, height, width = images.shape
    runs = find_runs(images.reshape(n * height, width), np.floor(level), most=MOST_RUNS)
    if len(runs.y) == MOST_RUNS or (runs.last - runs.first + 1).sum() > FEW * images.size:
        return None
    line, column = pixels_of(*(side.astype(np.int64, copy=False) for side in runs))
    grey = images.reshape(-1, width)[line, column]
    return BrightPixels(level, width, line * (width + 1) + column, grey)


def marker_gap(images: NDArray[np.uint8 | np.uint16]) -> LevelGap:
    """The gap between noise and markers of frames (n, H, W)."""
    level, variance = background(images)
    b, sigma, top = float(np.median(level)), float(np.sqrt(np.median(variance))), float(images.max())
    least = max(3 * sigma, 2.0)  # (1)
    clear = _clear_of_noise(images, b + CLEAR * sigma)
    none = LevelGap(b, sigma, np.nan, np.nan, np.nan, top, np.nan, 0.0, clear)
    if top - b <= 4 * least:
        return none
    contrasts = np.geomspace(least, (top - b) / 2, STEPS)
    found, bright = [], None
    for c in contrasts:
        bright = bright or bright_pixels(images, b + c)
        found.append(_standing_out(images, b, c, bright)[1])
    numbers = np.array([len(peaks) for peaks in found])
    stretch = _stable_stretch(contrasts, numbers, len(images))
    if stretch is None:
        return none
    low, high = contrasts[stretch[0]], contrasts[stretch[1]]
    flickers = _flicker(images) > FLICKERS * max(sigma, math.sqrt(ROUNDING))  # (5)
    peaks = found[(stretch[0] + stretch[1]) // 2 if flickers else stretch[0]] - b
    if sigma <= math.sqrt(ROUNDING) and not flickers:  # (4)
        peaks = peaks[~_remains(_standing_out(images, b, low, bright)[0], peaks)]
    clear = min(clear, b + 2 * high)  # the dimmest marker is brighter
    peak = float(np.median(peaks))
    least = max(min(1.1 * low, high), clear - b)
    c = max(min(SHARE * peak, HALF * float(np.percentile(peaks, DIM)), high), least)  # (3)
    groups = len(_standing_out(images, b, c, bright)[1]) / len(images)
    return LevelGap(b, sigma, b + low, b + high, b + peak, top, b + c, groups, clear)


def _clear_of_noise(images: NDArray[np.uint8 | np.uint16], level: float) -> float:
    """The least level above this one that noise of no ground of frames (n, H, W) crosses (6)."""
    few = images[:, SPARSE // 2 :: SPARSE, SPARSE // 2 : -1 : SPARSE]
    beside = images[:, SPARSE // 2 :: SPARSE, SPARSE // 2 + 1 :: SPARSE]
    both = np.stack([few, np.maximum(few, beside) - np.minimum(few, beside)])
    squares = _in_squares(both, SQUARE)
    still = row_medians(np.moveaxis(squares, 1, -2).reshape(2, -1, len(images) * SQUARE**2))
    moving = row_medians(_in_squares(both, SMALL)).reshape(2, -1)
    moving = moving[:, np.argsort(moving[0])]
    moving = row_medians(moving[:, moving.shape[1] % ALIKE :].reshape(2, -1, ALIKE))
    middle, spread = np.concatenate([still, moving], axis=1)
    reach = CLEAR * MEDIAN_SD * spread
    top = middle + reach
    while (across := (middle - reach < level) & (level < top)).any():
        level = float(top[across].max())
    return level


def _in_squares(few: GreyLevels, side: int) -> GreyLevels:
    """(2, n, h, w, side²) the pixels of each square of frames (2, n, H, W)."""
    h, w = few.shape[2] // side, few.shape[3] // side
    squares = few[..., : h * side, : w * side].reshape(*few.shape[:2], h, side, w, side)
    return squares.swapaxes(3, 4).reshape(*few.shape[:2], h, w, side**2)


def _flicker(images: NDArray[np.uint8 | np.uint16]) -> float:
    """Levels by which the median pixel differs between images (n, H, W), beyond rounding."""
    median = np.median(images[:, ::SPARSE, ::SPARSE], axis=(1, 2))
    return max(float(np.ptp(median)) - 1.0, 0.0)


def groups_above(
    images: NDArray[np.uint8 | np.uint16], level: float, bright: BrightPixels | None = None
) -> PixelGroups:
    """Groups of pixels brighter than `level` in frames (n, H, W), lone pixels among them; faster with `bright`."""
    n, height, width = images.shape
    if bright is not None and level >= bright.level:
        runs = bright.runs(np.floor(level))
    else:
        runs = find_runs(images.reshape(n * height, width), np.floor(level), most=MOST_RUNS)
    return group_runs(runs, height=height, width=width)


def real_groups(images: NDArray[np.uint8 | np.uint16], level: float) -> PixelGroups:
    """Groups of pixels brighter than `level` in frames (n, H, W) without lone pixels."""
    groups = groups_above(images, level)
    return groups.keep(blurred(images, groups))


def peaks_of(images: NDArray[np.uint8 | np.uint16], groups: PixelGroups) -> NDArray[np.float64]:
    """(G) the brightest pixel of each group."""
    return native.group_peaks(images, groups.start, *groups.runs)


def _standing_out(
    images: NDArray[np.uint8 | np.uint16], b: float, c: float, bright: BrightPixels | None
) -> tuple[PixelGroups, NDArray[np.float64]]:
    """Groups brighter than b + c with a pixel brighter than b + 2 c, and their peaks; none where there are too many."""
    groups = groups_above(images, b + c, bright)
    if len(groups.runs.y) > MOST_RUNS // 2:
        groups = groups.keep(np.zeros(len(groups.area), np.bool_))
    peak = peaks_of(images, groups)
    groups, peak = groups.keep(peak > b + 2 * c), peak[peak > b + 2 * c]
    real = blurred(images, groups)
    return groups.keep(real), peak[real]


def _remains(groups: PixelGroups, peak: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(G) which groups may be what compression left of a brighter one (4), by the contrast (G) of their peaks."""
    out = np.zeros(len(peak), np.bool_)
    sides = ((groups.left, groups.right), (groups.top, groups.bottom))
    for rows in np.split(np.arange(len(peak)), np.flatnonzero(np.diff(groups.frame)) + 1):
        beside = 2 * peak[rows, None] < peak[rows]
        for low, high in sides:
            beside &= (low[rows] - high[rows, None] <= BLOCK) & (low[rows, None] - high[rows] <= BLOCK)
        out[rows] = beside.any(1)
    return out


def _stable_stretch(c: NDArray[np.float64], numbers: NDArray[np.int64], n: int) -> tuple[int, int] | None:
    """First and last step of the stretch of (2) with the greatest (A)."""
    best, greatest = None, 0.0
    root, number = np.sqrt(c).tolist(), numbers.tolist()
    for first in range(len(c)):
        least = most = total = number[first]
        for last in range(first + 1, len(c)):
            least, most, total = min(least, number[last]), max(most, number[last]), total + number[last]
            if least < n / 2 or most - least > 0.1 * most + 0.25 * n:  # (2)
                break
            score = (root[last] - root[first]) * math.log1p(total / (last - first + 1) / n)  # (A)
            if score > greatest:
                best, greatest = (first, last), score
    return best
