"""What lens, sensor and infrared light make of a marker's image.

A sensor value is   round(background + light ∗ Gaussian(blur) + N(0, read_noise²)),   held between 0 and 255. It stands
for the noise of reading out, dark count and background light together (Swamidas, appendix C), none of which depends
on the signal here.

Drawing a normal deviate for each of a million pixels takes longer than everything else, so a film draws its noise once,
into a *bank* of background pixels somewhat longer than one image, and every frame starts as a piece of the bank from a
random place. Pixels that a marker lights get fresh noise of their own in every frame, so that what is measured on
markers is independent between frames.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..data.array_types import Floats, Ints

BANK_SPARE = 1 << 18
"""Pixels by which a bank is longer than an image: as many different backgrounds; chosen."""


@dataclass(frozen=True, slots=True)
class Optics:
    """How bright, how sharp and how noisy images are.

    Attributes:
        brightness: what a marker adds to the background, grey levels.
        background: grey level where there is no marker.
        read_noise: standard deviation, grey levels.
        blur_px: standard deviation of the Gaussian that lens and sensor smear a point with, px.
        limb_darkening: 0 for a flat disc, as retro-reflective tape gives; 1 for one that fades to black at its rim.
        subsamples: lines of sight along each side of a pixel.
        strobe_radius_mm: of the ring of light round an opposite camera's lens.
        strobe_brightness: what its image adds, grey levels; above 255 it saturates and spreads.
        glare: peak of the halo round a strobe, grey levels.
        glare_px: standard deviation of that halo, px.
    """

    brightness: float = 210.0
    background: float = 14.0
    read_noise: float = 2.0
    blur_px: float = 0.7
    limb_darkening: float = 0.0
    subsamples: int = 3
    strobe_radius_mm: float = 45.0
    strobe_brightness: float = 700.0
    glare: float = 70.0
    glare_px: float = 8.0

    def __post_init__(self) -> None:
        if min(self.read_noise, self.blur_px, self.glare_px) < 0 or self.subsamples < 1:
            raise ValueError("read_noise, blur_px and glare_px must not be negative and subsamples at least 1")
        if not 0 <= self.limb_darkening <= 1:
            raise ValueError(f"limb_darkening is {self.limb_darkening}, wanted 0 to 1")

    @property
    def reach(self) -> int:
        """How many pixels away the blur still carries light, px."""
        return int(4 * self.blur_px + 0.5)


def sensor(light: Floats, optics: Optics, rng: np.random.Generator | None) -> NDArray[np.uint8]:
    """Grey levels of light (…) above the background; without `rng` there is no noise."""
    level = light + optics.background
    if rng is not None and optics.read_noise > 0:
        level = level + rng.normal(0.0, optics.read_noise, level.shape)
    return np.clip(np.rint(level), 0, 255).astype(np.uint8)


def noise_bank(size: Ints, optics: Optics, rng: np.random.Generator) -> NDArray[np.uint8]:
    """(W·H + spare) background pixels, from which `background` cuts images of `size` (W, H)."""
    return sensor(np.zeros(int(size[0] * size[1]) + BANK_SPARE), optics, rng)


def background(
    size: Ints, optics: Optics, rng: np.random.Generator | None, bank: NDArray[np.uint8] | None = None
) -> NDArray[np.uint8]:
    """(H, W) an image without markers: fresh noise, or a piece of a bank, or none without `rng`."""
    width, height = int(size[0]), int(size[1])
    if rng is None or bank is None:
        return sensor(np.zeros((height, width)), optics, rng)
    first = int(rng.integers(len(bank) - width * height + 1))
    return bank[first : first + width * height].reshape(height, width).copy()


def blur(light: Floats, optics: Optics) -> Floats:
    """Light (h, w) smeared; darkness is taken outside."""
    return scipy.ndimage.gaussian_filter(light, optics.blur_px, mode="constant") if optics.blur_px > 0 else light
