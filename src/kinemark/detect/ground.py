"""Images of a camera without their static ground.

The ground g is learned from the recording (`ground_learning`); the two fields of interlaced video have one each.
With the opening o of an image I (the greatest of the least levels in squares of side `Ground.side`, which no marker
fills), it is taken to

    d = I − max(g − p, o − p, 0), no lower than 0,   p = `DEPTH` σ          (1)

so that an even ground remains, at the level p, and with it the noise that covariances are made of, that of g itself
included. What is darker than p stays as it is. By o, which is below g by some 2.5 σ of an even ground, what is wider
than a marker is taken away however bright it is just now: lamps that flicker, the sun, light that somebody hid while g
was learned; by g what is narrower, as a strip light, or what is left of a lamp that somebody hides.

A marker hides the ground behind it. So one of the level M stands out by M − g, and less before a bright ground; where
it lies on the edge of a lamp its centroid would be drawn to the dark side. So what stands out counts

    p + a (d − p),   a = (M − b) / (M − g)                                (2)

with the median b of the ground and the markers' usual level M, as if all lay before b (`ground_learning`).

Lamps flicker, and clouds pass windows. Of pixels that g lights by more than c, `AMONG` are kept in mind. Where a tenth
of them are brighter in an image than in g, by half of `UNEVEN` c, the ground of that image is a (g − p), where a tenth
are more than a times as bright (3).

Whether it is worth it: a ground is uneven where more than `SHARE` of its pixels differ from its median b by more than
`UNEVEN` (t − b), for the threshold t, and by more than p (4).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.array_types import Floats, GreyLevels, Ints
from .background_noise import background

DEPTH = 6.0  # standard deviations of noise that are left below the ground; chosen: none of it is clipped
UNEVEN = 0.35  # of the way from the ground to the threshold; chosen: markers lose a third of their rim's contrast
SHARE = 0.01  # of the pixels; chosen: strobes and their halos in a dark image are less
STRIDE = 8  # px between pixels that are looked at for that; chosen for speed
DECILE = 0.9  # of the pixels of (3); chosen: those at white get no brighter, and markers cover fewer
PARTS = 16
"""Parts of 1 in which factors (2) are kept; chosen for speed."""

FEW = slice(STRIDE // 2, None, STRIDE)
"""Lines or columns of an image, px; by definition of `STRIDE`."""


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What is taken away from a camera's images.

    Attributes:
        light: (k, H, W) grey levels, of the negative where inverted; k is 2 for the fields of interlaced video, else 1.
        level: at which an even ground remains, grey levels.
        white: grey level from which negatives count; None where markers are bright.
        lit: (2, L) lines and columns of pixels that show by how much an image is brighter; steady: grey levels by which
            they may be.
        side: of squares that no marker fills, px, odd; 0: there is no o in (1).
        times: (k, H, W) factors of (2), in `PARTS`; None: all are 1.
    """

    light: GreyLevels
    level: int
    white: int | None = None
    lit: Ints = field(default_factory=lambda: np.zeros((2, 0), np.int64))
    steady: float = np.inf
    side: int = 0
    times: NDArray[np.uint8] | None = None

    def taken_from(self, images: GreyLevels, first: int) -> GreyLevels:
        """Frames (n, H, W), of which the first has this number, without the ground; (1), (2)."""
        k, out = len(self.light), np.empty_like(images)
        for f, light in enumerate(self.light):
            own = slice((f - first) % k, None, k)
            brighter = dict(self._brighter(images[own], light))
            for n, image in enumerate(images[own]):
                most = np.iinfo(light.dtype).max
                now = np.minimum(light * brighter[n], most).astype(light.dtype) if n in brighter else light
                rest = self._without(negative(image, self.white), now, f)
                out[own][n] = rest if self.white is None else self.white - np.minimum(rest, self.white)
        return out

    def _without(self, bright: GreyLevels, light: GreyLevels, f: int) -> GreyLevels:
        """One frame (H, W) of a field, in which markers are bright, without its ground (H, W)."""
        if self.side:
            light = np.maximum(light, above(opening(bright, self.side), self.level))
        rest = above(bright, light)
        return rest if self.times is None else _as_before_dark(rest, self.level, self.times[f])

    def _brighter(self, images: GreyLevels, light: GreyLevels) -> Iterator[tuple[int, float]]:
        """The frames (n, H, W) in which the ground (H, W) is brighter, and how many times as bright; (3)."""
        if not self.lit.size or not len(images):
            return
        usual = light[*self.lit].astype(np.float64)
        more = negative(images[:, *self.lit], self.white) - (usual + self.level)
        for n in np.flatnonzero(np.quantile(more, DECILE, axis=1) > self.steady).tolist():
            yield n, 1 + float(np.quantile(more[n] / usual, DECILE))

    def under(self, images: GreyLevels, frames: NDArray[np.int64]) -> GreyLevels:
        """The same of frames (n, H, W) of these numbers (n)."""
        return np.concatenate([self.taken_from(image[None], int(f)) for image, f in zip(images, frames, strict=True)])

    def recorded(self, peak: Floats, uv: Floats, frame: Ints) -> Floats:
        """(D) grey levels of the recording, of peaks (D) at places (D, 2) px of these frames (D) without the ground."""
        column, row = np.clip(np.rint(uv).astype(np.int64).T, 0, np.array(self.light.shape[:0:-1])[:, None] - 1)
        here = frame % len(self.light), row, column
        bright = peak if self.white is None else self.white - peak
        if self.times is not None:
            out = np.maximum(bright - self.level, 0.0)
            bright = bright - out * (1 - PARTS / self.times[here])
        bright = bright + self.light[here]
        return bright if self.white is None else self.white - bright


def is_uneven(images: GreyLevels, threshold: float) -> bool:
    """Whether the static ground of frames (n, H, W) is uneven by (4), for a threshold in their own grey levels."""
    few = np.sort(images[:, FEW, FEW].reshape(len(images), -1), axis=0)
    if not few.size:
        return False
    still = few[(len(few) - 1) // 2].astype(np.float64)
    b = float(np.median(still))
    least = max(UNEVEN * abs(threshold - b), DEPTH * float(np.sqrt(np.median(background(images)[1]))))
    return bool((np.abs(still - b) > least).mean() > SHARE)


def opening(image: GreyLevels, side: int) -> GreyLevels:
    """The greatest of the least levels in squares of this odd side, px, that hold a pixel of an image (H, W)."""
    for best, outside in ((np.minimum, np.iinfo(image.dtype).max), (np.maximum, 0)):
        image = _along_lines(best, image, side, outside)
        image = _along_lines(best, image.T, side, outside).T
    return image


def above(light: GreyLevels, level: GreyLevels | int) -> GreyLevels:
    """By how much light (…) is above a level, grey levels; 0 where it is not."""
    low = _in_lines(level, light) if isinstance(level, int) else level
    return np.maximum(light, low) - low


def negative(images: GreyLevels, white: int | None) -> GreyLevels:
    """Frames in which markers are bright."""
    return images if white is None else np.subtract(white, np.minimum(images, white)).astype(images.dtype)


def _along_lines(best: Any, image: GreyLevels, side: int, outside: int) -> GreyLevels:
    """Least or greatest level of so many lines about each pixel (H, W): of 2, 4, 8 … lines, then of all."""
    lines, near = len(image), 1
    image = np.pad(image, ((side // 2, side // 2), (0, 0)), constant_values=outside)
    while 2 * near <= side:
        image = best(image[:-near], image[near:])
        near *= 2
    return np.asarray(best(image[:lines], image[side - near : side - near + lines]))


def _as_before_dark(image: GreyLevels, level: int, times: NDArray[np.uint8]) -> GreyLevels:
    """An image (H, W) in which what is above this level counts so many times, in `PARTS`; (2)."""
    wide = np.uint16 if image.itemsize == 1 else np.uint32
    more: NDArray[Any] = above(image, level).astype(wide) * times.astype(wide)
    more = more // PARTS + np.minimum(image, _in_lines(level, image))
    return np.minimum(more, _in_lines(np.iinfo(image.dtype).max, more)).astype(image.dtype)


def _in_lines(level: int, images: NDArray[Any]) -> NDArray[Any]:
    """(W) the same level for a line of images (…, W): NumPy compares arrays ten times as fast as one with a number."""
    return np.full(images.shape[-1], level, images.dtype)
