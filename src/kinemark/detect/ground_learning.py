"""The static ground of a camera's images, learned from frames spread over its recording.

First it is the median g of each pixel. Markers stand still, and people stand, in many frames; so when the size of what
moves is known, it is the sum of two (1): of what is wider than a marker, the opening (`ground`), the level that `OFTEN`
of the frames are below, as people hide light and do not shine; of the narrower rest, the median.

A marker that stands still is part of that rest. A *spot* is a group of pixels brighter, by c / 2, than the opening of g
with a side of `WIDER` √A, for markers up to the area A; not larger nor longer than a marker, as full (`sizes`), within
the image, and so much brighter than all of the opening within `ROUND` pixels, too, and than most of the pixels that far
away: it is no corner of something large, nor a slope. Markers touch what is dimmer, as a limb. So groups brighter by c,
2 c, 4 c … are spots as well, if all pixels that far away are less than half as bright (2). Spots are cut out of the
ground, and so stay in the images.

Before a ground of g grey levels a marker of the usual level M counts (M − b) / (M − g) times, for the median b, if that
leaves the noise σ of the ground `CLEAR` times below c (3), and where narrow light changes, what the image is brighter
than g in one of seven frames, `LIVELY` times. Glare and light on a window pane are added to a marker's instead, which
hides nothing: its level rises with g, and none counts more. So that is only done where the median level of markers
before ground that is brighter by c / 2, or the brightest, is nearer to that of others than what they stand out by is
(4).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import GreyLevels, Ints
from ..numerics.evenly import evenly
from .background_noise import background
from .ground import DEPTH, FEW, PARTS, STRIDE, UNEVEN, Ground, above, negative, opening
from .grouping import PixelGroups
from .sizes import FILL
from .stability import groups_above, peaks_of, real_groups

OFTEN = 0.85  # of the frames; chosen: people hide a place in three of four, and do not shine
AMONG = 400  # pixels whose light is compared; chosen for speed
WIDER = 1.6  # times √A; chosen: the diagonal of a marker's rectangle, and its blurred rim
ROUND = 3  # px about a spot; chosen: blurred rims of what is large
CLEAR = 9.0  # standard deviations of noise; chosen: 6 that are left, and the noise of g
SELDOM, LIVELY = 0.85, 2.5  # share of the frames, and a factor; chosen: markers are in fewer, lamps vary by more
MOST = 8.0  # times that a marker counts at most; chosen
BAND = 64  # lines whose median is taken at a time; chosen for speed: they stay in the cache


class Spots(NamedTuple):
    """What markers look like.

    contrast: from the ground to the threshold, peak: above an image's black where the ground is taken away, grey levels
    of the images; area: the greatest, px²; aspect: longer by shorter side.
    """

    contrast: float
    area: float
    aspect: float
    peak: float

    @property
    def side(self) -> int:
        """Of a square that no marker fills, px, odd."""
        return int(np.ceil(WIDER * np.sqrt(self.area))) | 1


def static_ground(images: GreyLevels, field: Ints, *, white: int | None = None) -> Ground:
    """All that stands still in frames (n, H, W) of these fields (n), 0 or 1; `white` where markers are dark."""
    bright = negative(images, white)
    level = int(np.ceil(DEPTH * np.sqrt(np.median(background(images)[1]))))
    light = np.stack([_quantile(bright[field == k], 0.5) for k in range(int(field.max()) + 1)])
    return Ground(above(light, level), level, white)


def uncovered(ground: Ground, images: GreyLevels, field: Ints, spots: Spots) -> Ground:
    """The ground also where it is hidden in most of the frames (n, H, W) of these fields (n), without spots; (1)."""
    bright, light = negative(images, ground.white), []
    for k in range(len(ground.light)):
        stack = bright[field == k]
        opened = np.stack([opening(image, spots.side) for image in stack])
        wide = _quantile(opened, OFTEN)
        narrow = np.minimum(_quantile(stack - opened, 0.5), np.iinfo(wide.dtype).max - wide)
        light.append(above(wide + narrow, ground.level))
    return without_spots(replace(ground, light=np.stack(light), side=spots.side), spots)


def without_spots(ground: Ground, spots: Spots) -> Ground:
    """The ground without what may be markers that stand still; (2)."""
    return replace(ground, light=np.stack([_cut_out(light, spots) for light in ground.light]))


def hides_ground(ground: Ground, images: GreyLevels, field: Ints, spots: Spots) -> bool:
    """Whether markers before bright ground have the levels of others, by frames without it; (4)."""
    bright = negative(images, ground.white)
    groups = real_groups(bright, ground.level + spots.contrast)
    row, column = (groups.top + groups.bottom) // 2 - groups.frame * bright.shape[1], (groups.left + groups.right) // 2
    light = ground.light[field[groups.frame], row, column].astype(np.float64)
    out = peaks_of(bright, groups)
    if not len(light):
        return True
    dark = light <= np.median(light)
    usual = float(np.median(light[dark]))
    lit = light > usual + min(spots.contrast, light.max() - usual) / 2
    if not lit.any():
        return True
    out_by, level_by = (abs(float(np.median(x[lit]) - np.median(x[dark]))) for x in (out, out + light))
    return level_by < out_by


def before_dark(ground: Ground, images: GreyLevels, field: Ints, spots: Spots) -> Ground:
    """How many times what stands out before the ground counts, by frames (n, H, W) of these fields (n); (3)."""
    bright, noise = negative(images, ground.white), float(np.sqrt(np.median(background(images)[1])))
    b = float(np.median(ground.light))
    usual = spots.peak - ground.level  # M − b
    times = []
    for k, light in enumerate(ground.light):
        narrow = above(light, opening(light, spots.side))  # what is wide is taken away as bright as it is just now
        more = _quantile(bright[field == k], SELDOM) - (light.astype(float) + ground.level)
        more = np.where(narrow > spots.contrast / 2, more, 0)
        unsteady = scipy.ndimage.maximum_filter(np.maximum(CLEAR * noise, LIVELY * more), 3)
        hidden = usual / np.maximum(usual + b - light, 1e-9)
        times.append(np.clip(np.minimum(hidden, spots.contrast / unsteady), 1, MOST))
    return replace(ground, times=np.rint(PARTS * np.stack(times)).astype(np.uint8))


def that_flickers(ground: Ground, contrast: float) -> Ground:
    """The ground, with some pixels that it lights by more than `contrast`, for (3) of `ground`."""
    lit = np.flatnonzero((ground.light[:, FEW, FEW] > contrast).all(0))
    row, column = np.divmod(lit[evenly(len(lit), AMONG)], len(range(ground.light.shape[2])[FEW]))
    return replace(ground, lit=np.stack([row, column]) * STRIDE + STRIDE // 2, steady=UNEVEN * contrast / 2)


def _quantile(stack: GreyLevels, share: float) -> GreyLevels:
    """(H, W) of each pixel of frames (n, H, W), the lower of two."""
    rank = int((len(stack) - 1) * share)
    bands = range(0, stack.shape[1], BAND)
    return np.concatenate([_ranked(list(stack[:, y : y + BAND]), rank) for y in bands])


def _ranked(images: list[GreyLevels], rank: int) -> GreyLevels:
    """(h, W) the level of each pixel that so many images are below: the brightest go to the end, again and again.

    For a dozen images that is 15 times as fast as `np.partition` along the first axis, which looks at pixels singly.
    """
    for end in range(len(images) - 1, rank - 1, -1):
        for i in range(end):
            images[i], images[i + 1] = np.minimum(images[i], images[i + 1]), np.maximum(images[i], images[i + 1])
    return images[rank]


def _cut_out(light: GreyLevels, spots: Spots) -> GreyLevels:
    """One ground (H, W) without its spots."""
    opened = opening(light, spots.side)
    out = light - opened
    kept, level = light.copy(), spots.contrast / 2
    for box in _spot_boxes(out, level, spots):
        if float(light[box].max()) - _beside(light[box], opened[box]) >= level:
            kept[box] = opened[box]
    while (level := 2 * level) < out.max():  # what touches something dimmer
        for box in _spot_boxes(out, level, spots):
            if _border(out[box]).max() <= out[box].max() / 2:
                kept[box] = opened[box]
    return kept


def _spot_boxes(out: GreyLevels, level: float, spots: Spots) -> Iterator[tuple[slice, slice]]:
    """Lines and columns of what is like a marker among what is brighter than a level, and `ROUND` beyond."""
    groups = groups_above(out[None], level)
    groups = groups.keep(_like_markers(groups, out.shape, spots))
    for left, right, top, bottom in zip(groups.left, groups.right, groups.top, groups.bottom, strict=True):
        yield slice(max(top - ROUND, 0), bottom + ROUND + 1), slice(max(left - ROUND, 0), right + ROUND + 1)


def _border(box: GreyLevels) -> GreyLevels:
    """The outermost pixels of a box (h, w)."""
    return np.concatenate([box[0], box[-1], box[:, 0], box[:, -1]])


def _beside(light: GreyLevels, opened: GreyLevels) -> float:
    """How bright it is beside the spot in a box (h, w): its border mostly, and all of it in what is large."""
    return max(float(np.median(_border(light))), float(opened.max()))


def _like_markers(groups: PixelGroups, shape: tuple[int, ...], spots: Spots) -> NDArray[np.bool_]:
    """(G) which groups of an image (H, W) have a marker's size and form, and lie within it."""
    w, h = groups.right - groups.left + 1, groups.bottom - groups.top + 1
    good = (groups.area <= spots.area) & (np.maximum(w, h) <= spots.aspect * np.minimum(w, h))
    good &= groups.area + np.sqrt(groups.area) >= FILL * w * h
    return good & (groups.left > 0) & (groups.right < shape[1] - 1) & (groups.top > 0) & (groups.bottom < shape[0] - 1)
