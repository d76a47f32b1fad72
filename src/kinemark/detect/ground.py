"""The static ground of a camera's images, learned from the recording itself, and images without it.

The ground g is the median of each pixel over frames spread over the recording; the two fields of interlaced video have
one each. Images are taken to

    I − max(g − p, 0), no lower than 0,   p = `DEPTH` σ                   (1)

so that an even ground remains, at the level p, and with it the noise that covariances are made of, that of g itself
included. What is darker than p stays as it is.

A marker that stands still is part of g. A *spot* is a group of pixels brighter, by c / 2, than the opening of g (the
greatest of the least levels in a square of side `WIDER` √A for markers up to the area A), not larger nor longer than a
marker, as full (`sizes`), within the image, and so much brighter than all of the opening within `ROUND` pixels, too,
and than most of the pixels that far away: it is no corner of something large, nor a slope. Spots are cut out of the
ground (2), and so stay in the images.

Lamps flicker, and clouds pass windows. Of pixels that g lights by more than c, `AMONG` are kept in mind. Where a tenth
of them are brighter in an image than in g, by half of `UNEVEN` c, the ground of that image is a (g − p), where a tenth
are more than a times as bright (5).

Whether it is worth it: a ground is uneven where more than `SHARE` of its pixels differ from its median b by more than
`UNEVEN` (t − b), for the threshold t, and by more than p (3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import GreyLevels
from ..numerics.evenly import evenly
from .background_noise import background
from .grouping import PixelGroups
from .sizes import FILL
from .stability import groups_above

DEPTH = 6.0  # standard deviations of noise that are left below the ground; chosen: none of it is clipped
UNEVEN = 0.35  # of the way from the ground to the threshold; chosen: markers lose a third of their rim's contrast
SHARE = 0.01  # of the pixels; chosen: strobes and their halos in a dark image are less
STRIDE = 8  # px between pixels that are looked at for that; chosen for speed
AMONG = 400  # pixels; chosen for speed
DECILE = 0.9  # of them; chosen: those at white get no brighter, and markers cover fewer
WIDER = 1.6  # times √A; chosen: the diagonal of a marker's rectangle, and its blurred rim
ROUND = 3  # px about a spot; chosen: blurred rims of what is large
BAND = 64  # lines whose median is taken at a time; chosen for memory

_FEW = slice(STRIDE // 2, None, STRIDE)  # lines or columns of an image, px; by definition of `STRIDE`


class Spots(NamedTuple):
    """What still markers look like: contrast, grey levels of the images; greatest area, px²; longer by shorter side."""

    contrast: float
    area: float
    aspect: float


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What is taken away from a camera's images.

    Attributes:
        light: (k, H, W) grey levels, of the negative where inverted; k is 2 for the fields of interlaced video, else 1.
        level: at which an even ground remains, grey levels.
        white: grey level from which negatives count; None where markers are bright.
        lit: (2, L) lines and columns of pixels that show by how much an image is brighter; steady: grey levels by which
            they may be.
    """

    light: GreyLevels
    level: int
    white: int | None = None
    lit: NDArray[np.int64] = field(default_factory=lambda: np.zeros((2, 0), np.int64))
    steady: float = np.inf

    def taken_from(self, images: GreyLevels, first: int) -> GreyLevels:
        """Frames (n, H, W), of which the first has this number, without the ground; (1)."""
        k, out = len(self.light), np.empty_like(images)
        for f, light in enumerate(self.light):
            own = slice((f - first) % k, None, k)
            _subtract(images[own], light, self.white, out[own])
            for n, times in self._brighter(images[own], light):
                most = np.iinfo(light.dtype).max
                _subtract(images[own][n], np.minimum(light * times, most).astype(light.dtype), self.white, out[own][n])
        return out

    def _brighter(self, images: GreyLevels, light: GreyLevels) -> Iterator[tuple[int, float]]:
        """The frames (n, H, W) in which the ground (H, W) is brighter, and how many times as bright; (5)."""
        if not self.lit.size or not len(images):
            return
        usual = light[*self.lit].astype(np.float64)
        more = _negative(images[:, *self.lit], self.white) - (usual + self.level)
        for n in np.flatnonzero(np.quantile(more, DECILE, axis=1) > self.steady).tolist():
            yield n, 1 + float(np.quantile(more[n] / usual, DECILE))

    def under(self, images: GreyLevels, frames: NDArray[np.int64]) -> GreyLevels:
        """The same of frames (n, H, W) of these numbers (n)."""
        return np.concatenate([self.taken_from(image[None], int(f)) for image, f in zip(images, frames, strict=True)])

    def at(self, uv: NDArray[np.float64], frame: NDArray[np.int64]) -> NDArray[np.float64]:
        """(D) grey levels taken away at places (D, 2) px of these frames (D)."""
        column, row = np.clip(np.rint(uv).astype(np.int64).T, 0, np.array(self.light.shape[:0:-1])[:, None] - 1)
        return self.light[frame % len(self.light), row, column].astype(np.float64)


def is_uneven(images: GreyLevels, threshold: float) -> bool:
    """Whether the static ground of frames (n, H, W) is uneven by (3), for a threshold in their own grey levels."""
    few = np.sort(images[:, _FEW, _FEW].reshape(len(images), -1), axis=0)
    if not few.size:
        return False
    still = few[(len(few) - 1) // 2].astype(np.float64)
    b = float(np.median(still))
    least = max(UNEVEN * abs(threshold - b), DEPTH * float(np.sqrt(np.median(background(images)[1]))))
    return bool((np.abs(still - b) > least).mean() > SHARE)


def static_ground(images: GreyLevels, field: NDArray[np.int64], *, white: int | None = None) -> Ground:
    """All that stands still in frames (n, H, W) of these fields (n), 0 or 1; `white` where markers are dark."""
    bright = _negative(images, white)
    level = int(np.ceil(DEPTH * np.sqrt(np.median(background(images)[1]))))
    stacks = [bright[field == k] for k in range(int(field.max()) + 1)]
    light = np.stack([_median(stack) for stack in stacks])
    return Ground(np.maximum(light, level) - np.array(level, light.dtype), level, white)


def without_spots(ground: Ground, spots: Spots) -> Ground:
    """The ground without what may be markers that stand still; (2)."""
    return replace(ground, light=np.stack([_cut_out(light, spots) for light in ground.light]))


def that_flickers(ground: Ground, contrast: float) -> Ground:
    """The ground, with some of the pixels that it lights by more than `contrast`, which show how bright it is; (5)."""
    lit = np.flatnonzero((ground.light[:, _FEW, _FEW] > contrast).all(0))
    row, column = np.divmod(lit[evenly(len(lit), AMONG)], len(range(ground.light.shape[2])[_FEW]))
    return replace(ground, lit=np.stack([row, column]) * STRIDE + STRIDE // 2, steady=UNEVEN * contrast / 2)


def _subtract(images: GreyLevels, light: GreyLevels, white: int | None, out: GreyLevels) -> None:
    """Frames (…, H, W) without the ground (H, W), into `out`; (1)."""
    if white is None:
        np.maximum(images, light, out=out)
        np.subtract(out, light, out=out)
    else:  # the same of the negative
        np.minimum(images, white - light, out=out)
        np.add(out, light, out=out)


def _negative(images: GreyLevels, white: int | None) -> GreyLevels:
    """Frames in which markers are bright."""
    return images if white is None else np.subtract(white, np.minimum(images, white)).astype(images.dtype)


def _median(stack: GreyLevels) -> GreyLevels:
    """(H, W) the lower median of each pixel of frames (n, H, W)."""
    middle = (len(stack) - 1) // 2
    bands = range(0, stack.shape[1], BAND)
    return np.concatenate([np.partition(stack[:, y : y + BAND], middle, axis=0)[middle] for y in bands])


def _cut_out(light: GreyLevels, spots: Spots) -> GreyLevels:
    """One ground (H, W) without its spots."""
    side = int(np.ceil(WIDER * np.sqrt(spots.area))) | 1
    opened = scipy.ndimage.grey_opening(light, size=(side, side), mode="nearest")
    above = light - opened
    groups = groups_above(above[None], spots.contrast / 2)
    groups = groups.keep(_like_markers(groups, light.shape, spots))
    kept = light.copy()
    for left, right, top, bottom in zip(groups.left, groups.right, groups.top, groups.bottom, strict=True):
        box = slice(max(top - ROUND, 0), bottom + ROUND + 1), slice(max(left - ROUND, 0), right + ROUND + 1)
        if float(light[box].max()) - _beside(light[box], opened[box]) >= spots.contrast / 2:
            kept[box] = opened[box]
    return kept


def _beside(light: GreyLevels, opened: GreyLevels) -> float:
    """How bright it is beside the spot in a box (h, w): its border mostly, and all of it in what is large."""
    border = np.concatenate([light[0], light[-1], light[:, 0], light[:, -1]])
    return max(float(np.median(border)), float(opened.max()))


def _like_markers(groups: PixelGroups, shape: tuple[int, ...], spots: Spots) -> NDArray[np.bool_]:
    """(G) which groups of an image (H, W) have a marker's size and form, and lie within it."""
    w, h = groups.right - groups.left + 1, groups.bottom - groups.top + 1
    good = (groups.area <= spots.area) & (np.maximum(w, h) <= spots.aspect * np.minimum(w, h))
    good &= groups.area + np.sqrt(groups.area) >= FILL * w * h
    return good & (groups.left > 0) & (groups.right < shape[1] - 1) & (groups.top > 0) & (groups.bottom < shape[0] - 1)
