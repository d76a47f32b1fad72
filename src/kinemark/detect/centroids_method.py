"""The parameters of detection."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..data.method import ONE, Method, parameter
from .stage import check_areas

MOST_DISCS = 5
"""More discs on each other than this are not told apart: their fit would be a guess; chosen."""

BITS_16 = 257.0
"""How often the grey scale of 8 bits (white is 255) goes into that of 16 bits (65 535); by definition."""


class Limits(NamedTuple):
    """Threshold, grey levels of 8 bits; areas, px² of white pixels; width, px; longer side by shorter."""

    threshold: float
    min_area: int
    max_area: int
    min_width: int
    max_aspect: float


USUAL = Limits(60.0, 4, 2000, 2, 2.5)
"""Grey levels, px², px², px and a ratio, where nothing is said and no recording is there to learn from; chosen."""


@dataclass(frozen=True, slots=True)
class Centroids(Method):
    """Bright groups of pixels, each at its grey-weighted centroid.

    Source: Shafiq, Tümer and Güler 2001, section 2.

    Grey levels are those of 8-bit images, 0 … 255; in 16-bit images they count 257 times as much, so that
    white, 65 535, is 255 there too. A camera of 12 bits that leaves the upper four empty has its white at
    4095 / 257 = 15.9.
    """

    threshold: float | None = parameter(
        None, unit="grey levels", low=0, below=255,
        meaning="pixels brighter than this are white; where inverted, pixels darker than this; None: learned from each "
        "camera's recording (60 for images without one)",
    )  # fmt: skip
    min_area: int | None = parameter(
        None, unit="px²", low=1,
        meaning="markers with fewer white pixels are TOO_SMALL; None: learned from each camera's recording (else 4)",
    )  # fmt: skip
    max_area: int | None = parameter(
        None, unit="px²", low=1,
        meaning="markers with more white pixels are TOO_LARGE (strobes, lamps, windows); None: learned from each "
        "camera's recording (else 2000)",
    )  # fmt: skip
    min_width: int | None = parameter(
        None, unit="px", low=1,
        meaning="groups narrower or lower than this are noise and leave no detection, nor do lone pixels without light "
        "round them; None: learned from each camera's recording (else 2)",
    )  # fmt: skip
    max_aspect: float | None = parameter(
        None, unit=ONE, low=1, high=math.inf,
        meaning="markers longer or wider than this many times the other side are NOT_ROUND; None: learned from each "
        "camera's recording (else 2.5: a field of interlaced video halves the height of a round marker)",
    )  # fmt: skip
    noise_sd: float | None = parameter(
        None, former="noise", unit="grey levels", low=0, high=math.inf,
        meaning="standard deviation of the grey level of a dark pixel, that of rounding at least; None: measured in "
        "every frame",
    )  # fmt: skip
    shot_noise: float = parameter(
        0.0, former="shot", unit="grey levels", low=0, high=math.inf,
        meaning="variance that each grey level above the background adds (photon noise)",
    )  # fmt: skip
    inverted: bool = parameter(False, meaning="the markers are dark on bright ground")
    background: Literal["auto", "none", "subtract"] = parameter(
        "auto",
        meaning="subtract: the static ground of each camera is learned from its recording and subtracted, save small "
        "spots that may be markers, and a stated threshold counts from the ground; auto: where that is uneven, in "
        "recordings of 48 frames or more, if threshold is learned",
    )
    relative_threshold: float | None = parameter(
        None, former="relative", unit=ONE, above=0, below=1,
        meaning="instead of threshold, the share of the way from a camera's background to its bright level (its "
        "dark one where inverted), measured once from its first frames that show something; 0.5 is halfway",
    )  # fmt: skip
    aspect: float | None = parameter(
        None, unit=ONE, low=0.1, high=10,
        meaning="height of a round marker's image by its width; None: 0.5 for the fields of interlaced video, else "
        "1",
    )  # fmt: skip
    centroid: Literal["grey", "white"] = parameter(
        "grey",
        meaning="grey: every pixel counts by how bright it is; white: the mean of the white pixels, of which each "
        "counts alike (KISS eq. 2, UM²AS 3.4); what overlaps or is hidden is fitted all the same, unless max_discs is "
        "1 and correct_occlusion false",
    )
    max_discs: int = parameter(
        3, former="most_discs", unit="discs", low=1, high=MOST_DISCS,
        meaning="overlapping markers are told apart up to this many in a group; 1: not at all",
    )  # fmt: skip
    correct_occlusion: bool = parameter(
        True,
        former="hidden",
        meaning="put a disc of which a part is hidden where the centre of the whole disc is, if the fit is sure of it",
    )
    max_edge_sd: float = parameter(
        0.0, former="edge_sd", unit="px", low=0, high=math.inf,
        meaning="markers at the image's edge are valid if a fit knows their centre within this standard deviation; "
        "0: they never are",
    )  # fmt: skip

    def check_together(self) -> None:
        """Refuse areas of which the least is greater than the greatest."""
        check_areas(self.limits.min_area, self.limits.max_area)

    @property
    def limits(self) -> Limits:
        """Threshold and limits of size, `USUAL` ones for what is left open."""
        stated = {name: getattr(self, name) for name in Limits._fields}
        return USUAL._replace(**{name: value for name, value in stated.items() if value is not None})


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
