"""The parameters of the two methods of KISS section 2."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...data.method import ONE, Method, parameter
from ..stage import check_areas


@dataclass(frozen=True, slots=True)
class WhitePixels(Method):
    """Which pixels are white, in both methods."""

    threshold: float = parameter(
        60.0, unit="grey levels", low=0, below=255,
        meaning="pixels brighter than this, of 8 bits, are white; where inverted, darker ones",
    )  # fmt: skip
    inverted: bool = parameter(False, meaning="the markers are dark on bright ground")
    relative_threshold: float | None = parameter(
        None, former="relative", unit=ONE, above=0, below=1,
        meaning="instead of threshold, the share of the way from a camera's background to its bright level (its "
        "dark one where inverted), as for centroids",
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class KissScanning(WhitePixels):
    """Markers grouped during scanning by the mid-points of their runs: the method of the Kiss system.

    Source: Shafiq, Tümer and Güler 2001, 2.1 to 2.3.

    Pixels, grey levels and areas are those of `Centroids`. A field of interlaced video shows round markers half as high
    as wide: halve `min_ratio` and `max_ratio` there.
    """

    near_x: float = parameter(
        5.0,
        unit="px",
        low=0,
        high=math.inf,
        meaning="a run joins a group that has a mid-point no farther than this in x",
    )
    near_y: int = parameter(
        1, unit="px", low=1, meaning="a run joins a group that has a mid-point no farther than this in y"
    )
    noise_width: int = parameter(
        0, unit="px", low=0,
        meaning="groups narrower than this and lower than noise_height are noise (the former criterion); 0: none",
    )  # fmt: skip
    noise_height: int = parameter(
        0, unit="px", low=0, meaning="groups lower than this and narrower than noise_width are noise; 0: none"
    )
    isolated: bool = parameter(True, former="lonely", meaning="isolated pixels are noise")
    one_wide: bool = parameter(True, meaning="groups one pixel wide are noise")
    one_high: bool = parameter(True, meaning="groups one pixel high are noise")
    sub_markers: bool = parameter(
        True, meaning="small groups join the larger one in whose bounding rectangle they lie (sub-marker detection)"
    )
    small_area: float = parameter(
        30.0, unit="px²", low=0, high=math.inf,
        meaning="groups with fewer white pixels are small, if they have no more than small_rows rows",
    )  # fmt: skip
    small_rows: int = parameter(
        2, unit="rows", low=1,
        meaning="most rows of a small group (two in the paper, whose fields show markers six lines high)",
    )  # fmt: skip
    min_inside: float = parameter(
        0.6,
        former="inside",
        unit=ONE,
        above=0,
        high=1,
        meaning="share of its own rectangle with which a small group must lie in the other's",
    )
    overlaps: bool = parameter(True, meaning="overlapped markers, upper-left and upper-right, are separated")
    overlap_fill: float = parameter(
        0.75, unit=ONE, low=0, high=1,
        meaning="groups that fill less than this share of their rectangle may be overlapped; a disc fills 0.785",
    )  # fmt: skip
    overlap_shift: float = parameter(
        3.0, unit="px", low=0, high=math.inf,
        meaning="least distance of the mid-points of the top and bottom rows of overlapped markers",
    )  # fmt: skip
    row_overlap: float = parameter(
        3.0, unit="px", above=0, high=math.inf, meaning="these rows reach over each other by less than this"
    )
    long_wide: bool = parameter(True, meaning="long and wide groups are split")
    min_ratio: float = parameter(0.667, unit=ONE, above=0, meaning="height to width below which a group is wide")
    max_ratio: float = parameter(
        1.5, unit=ONE, above=0, high=math.inf, meaning="height to width above which a group is long"
    )
    check_sizes: bool = parameter(True, former="sizes", meaning="groups of a wrong size are invalid")
    min_area: int = parameter(4, unit="px²", low=1, meaning="markers with fewer white pixels are TOO_SMALL")
    max_area: int = parameter(2000, unit="px²", low=1, meaning="markers with more white pixels are TOO_LARGE")

    def check_together(self) -> None:
        """Refuse ratios that are too near to each other, and areas of which the least is greater than the greatest."""
        if not 2 * self.min_ratio <= self.max_ratio * (1 + 1e-9):
            raise ValueError(
                f"ratios are {self.min_ratio} … {self.max_ratio}, wanted the greater at least twice the smaller, "
                "or else a group could be too long for one marker and too short for two"
            )
        check_areas(self.min_area, self.max_area)


@dataclass(frozen=True, slots=True)
class KissNearest(WhitePixels):
    """Markers grouped by the neighbourhood of their pixels, large groups split harshly: KISS's former method.

    Source: Shafiq, Tümer and Güler 2001, section 2. It is here to be compared with; `KissScanning` took its place in
    2001.
    """

    neighbourhood: int = parameter(
        2, unit="px", low=1, high=16, meaning="white pixels no farther than this in x and y belong together"
    )
    noise_width: int = parameter(
        2, unit="px", low=0, meaning="groups narrower than this and lower than noise_height are noise; 0: none"
    )
    noise_height: int = parameter(
        2, unit="px", low=0, meaning="groups lower than this and narrower than noise_width are noise; 0: none"
    )
    isolated: bool = parameter(
        False, former="lonely", meaning="isolated pixels are noise (a criterion of the later method)"
    )
    one_wide: bool = parameter(False, meaning="groups one pixel wide are noise (a criterion of the later method)")
    one_high: bool = parameter(False, meaning="groups one pixel high are noise (a criterion of the later method)")
    split: bool = parameter(True, meaning="groups that are too wide or high are split")
    split_factor: float = parameter(
        1.5, unit=ONE, low=1, high=math.inf,
        meaning="too wide or high are groups of more than this many times the average width or height in their "
        "field",
    )  # fmt: skip
