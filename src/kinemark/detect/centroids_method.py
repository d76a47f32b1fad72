"""The parameters of detection."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

MOST_DISCS = 5
"""More discs on each other than this are not told apart: their fit would be a guess."""

BITS_16 = 257.0
"""How often the grey scale of 8 bits (white is 255) goes into that of 16 bits (65 535)."""


@dataclass(frozen=True, slots=True)
class Centroids:
    """Bright groups of pixels, each at its grey-weighted centroid (Shafiq, Tümer and Güler 2001, section 2).

    Grey levels are those of 8-bit images, 0 … 255; in 16-bit images they count 257 times as much, so that
    white, 65 535, is 255 there too. A camera of 12 bits that leaves the upper four empty has its white at
    4095 / 257 = 15.9.

    Attributes:
        threshold: pixels brighter than this are white, grey levels; where `inverted`, pixels darker than this.
        inverted: the markers are dark on bright ground.
        relative: instead of `threshold`, the share of the way from a camera's background to its bright level (its dark
            one where `inverted`), measured once from the camera's first frames that show something; 0.5 is halfway.
        min_area: markers with fewer white pixels are TOO_SMALL, px².
        max_area: markers with more are TOO_LARGE (strobes, lamps, windows), px².
        min_width: groups narrower or lower than this are noise and leave no detection, px.
        max_aspect: markers longer or wider than this many times the other side are NOT_ROUND. A field of
            interlaced video halves the height of a round marker, hence the room.
        noise: standard deviation of the grey level of a dark pixel; None: measured in every frame.
        shot: variance that each grey level above the background adds (photon noise), grey levels.
        aspect: height of a round marker's image by its width; None: 0.5 for the fields of interlaced video, else 1.
        most_discs: overlapping markers are told apart up to this many in a group; 1: not at all.
        hidden: put a disc of which a part is hidden where the centre of the whole disc is, if the fit is sure of it.
        edge_sd: markers at the image's edge are valid if a fit knows their centre within this standard deviation, px;
            0: they never are.
    """

    threshold: float = 60.0
    min_area: int = 4
    max_area: int = 2000
    min_width: int = 2
    max_aspect: float = 2.5
    noise: float | None = None
    shot: float = 0.0
    inverted: bool = False
    relative: float | None = None
    aspect: float | None = None
    most_discs: int = 3
    hidden: bool = True
    edge_sd: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.threshold < 255:
            raise ValueError(f"threshold is {self.threshold}, wanted a grey level from 0 to below 255")
        if not 1 <= self.min_area <= self.max_area:
            raise ValueError(f"areas are {self.min_area} … {self.max_area}, wanted 1 ≤ min_area ≤ max_area")
        if self.min_width < 1:
            raise ValueError(f"min_width is {self.min_width}, wanted at least 1 px")
        if not self.max_aspect >= 1:
            raise ValueError(f"max_aspect is {self.max_aspect}, wanted at least 1")
        if not self.shot >= 0 or not (self.noise is None or self.noise >= 0):
            raise ValueError(f"noise and shot are {self.noise} and {self.shot}, wanted 0 or more")
        if not (self.relative is None or 0 < self.relative < 1):
            raise ValueError(f"relative is {self.relative}, wanted a share above 0 and below 1, or None")
        if not (self.aspect is None or 0.1 <= self.aspect <= 10):
            raise ValueError(f"aspect is {self.aspect}, wanted 0.1 to 10, or None")
        if not 1 <= self.most_discs <= MOST_DISCS:
            raise ValueError(f"most_discs is {self.most_discs}, wanted 1 to {MOST_DISCS}")
        if not self.edge_sd >= 0:
            raise ValueError(f"edge_sd is {self.edge_sd}, wanted 0 px or more")


def grey_scale(dtype: DTypeLike) -> float:
    """What one grey level of `Centroids` counts in images of this type."""
    return BITS_16 if np.dtype(dtype) == np.uint16 else 1.0


def check_images(images: NDArray[np.uint8 | np.uint16]) -> None:
    """Refuse what is no stack of grey images.

    Raises:
        ValueError: not three axes, no pixels, or neither uint8 nor uint16.
    """
    if images.ndim != 3 or 0 in images.shape[1:]:
        raise ValueError(f"images have shape {images.shape}, wanted (frames, rows, columns)")
    if images.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"images are {images.dtype}, wanted uint8 or uint16 grey levels")
