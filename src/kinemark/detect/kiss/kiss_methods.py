"""The parameters of the two methods of KISS section 2."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class KissScanning:
    """Markers grouped during scanning by the mid-points of their runs (Shafiq, Tümer and Güler 2001, 2.1 to 2.3).

    Pixels, grey levels and areas are those of `Centroids`. A field of interlaced video shows round markers half as high
    as wide: halve `min_ratio` and `max_ratio` there.

    Attributes:
        threshold: pixels brighter than this are white, grey levels of 8 bits; where `inverted`, darker ones.
        inverted: the markers are dark on bright ground.
        relative: instead of `threshold`, the share of the way from a camera's background to its bright level (its dark
            one where `inverted`), as for `Centroids`.
        near_x, near_y: a run joins a group that has a mid-point no farther than this, px.
        noise_width, noise_height: groups narrower and lower than these are noise (the former criterion), px; 0: none.
        lonely: whether lonely pixels are noise.
        one_wide, one_high: whether groups one pixel wide, and one pixel high, are noise.
        sub_markers: whether small groups join the larger one in whose bounding rectangle they lie.
        small_area: groups with fewer white pixels are small, px², if they have no more than
        small_rows: rows (two in the paper, whose fields show markers six lines high).
        inside: share of its own rectangle with which a small group must lie in the other's.
        overlaps: whether overlapped markers, upper-left and upper-right, are separated.
        overlap_fill: groups that fill less than this share of their rectangle may be overlapped; a disc fills 0.785.
        overlap_shift: least distance of the mid-points of their top and bottom rows, px.
        row_overlap: these rows reach over each other by less than this, px.
        long_wide: whether long and wide groups are split.
        min_ratio, max_ratio: height to width below which a group is wide, and above which it is long.
        sizes: whether groups of a wrong size are invalid.
        min_area: markers with fewer white pixels are TOO_SMALL, px².
        max_area: markers with more are TOO_LARGE, px².
    """

    threshold: float = 60.0
    inverted: bool = False
    relative: float | None = None
    near_x: float = 5.0
    near_y: int = 1
    noise_width: int = 0
    noise_height: int = 0
    lonely: bool = True
    one_wide: bool = True
    one_high: bool = True
    sub_markers: bool = True
    small_area: float = 30.0
    small_rows: int = 2
    inside: float = 0.6
    overlaps: bool = True
    overlap_fill: float = 0.75
    overlap_shift: float = 3.0
    row_overlap: float = 3.0
    long_wide: bool = True
    min_ratio: float = 0.667
    max_ratio: float = 1.5
    sizes: bool = True
    min_area: int = 4
    max_area: int = 2000

    def __post_init__(self) -> None:
        _check_threshold_and_noise(self)
        if not self.near_x >= 0 or self.near_y < 1:
            raise ValueError(f"near_x and near_y are {self.near_x} and {self.near_y}, wanted 0 or more and 1 or more")
        if not self.small_area >= 0 or self.small_rows < 1 or not 0 < self.inside <= 1:
            raise ValueError(
                f"small_area, small_rows and inside are {self.small_area}, {self.small_rows} and {self.inside}, "
                "wanted 0 or more, 1 or more, and above 0 to 1"
            )
        if not 0 <= self.overlap_fill <= 1 or not self.overlap_shift >= 0 or not self.row_overlap > 0:
            raise ValueError(
                f"overlap_fill, overlap_shift and row_overlap are {self.overlap_fill}, {self.overlap_shift} and "
                f"{self.row_overlap}, wanted a share from 0 to 1, 0 or more, and more than 0"
            )
        if not 0 < 2 * self.min_ratio <= self.max_ratio * (1 + 1e-9):
            raise ValueError(
                f"ratios are {self.min_ratio} … {self.max_ratio}, wanted the greater at least twice the smaller, "
                "or else a group could be too long for one marker and too short for two"
            )
        if not 1 <= self.min_area <= self.max_area:
            raise ValueError(f"areas are {self.min_area} … {self.max_area}, wanted 1 ≤ min_area ≤ max_area")


@dataclass(frozen=True, slots=True)
class KissNearest:
    """Markers grouped by the neighbourhood of their pixels, large groups split harshly: KISS's former method.

    It is here to be compared with; `KissScanning` took its place in 2001. Shafiq, Tümer and Güler 2001, section 2.

    Attributes:
        threshold: pixels brighter than this are white, grey levels of 8 bits; where `inverted`, darker ones.
        inverted: the markers are dark on bright ground.
        relative: instead of `threshold`, the share of the way from a camera's background to its bright level (its dark
            one where `inverted`), as for `Centroids`.
        neighbourhood: white pixels no farther than this in x and y belong together, px.
        noise_width, noise_height: groups narrower and lower than these are noise, px; 0: none.
        lonely: whether lonely pixels are noise.
        one_wide, one_high: whether groups one pixel wide, and one pixel high, are noise (criteria of the later method).
        split: whether groups are split that are too wide or high.
        split_factor: times the average width and height of all groups of the field that is.
    """

    threshold: float = 60.0
    inverted: bool = False
    relative: float | None = None
    neighbourhood: int = 2
    noise_width: int = 2
    noise_height: int = 2
    lonely: bool = False
    one_wide: bool = False
    one_high: bool = False
    split: bool = True
    split_factor: float = 1.5

    def __post_init__(self) -> None:
        _check_threshold_and_noise(self)
        if not 1 <= self.neighbourhood <= 16:
            raise ValueError(f"neighbourhood is {self.neighbourhood}, wanted 1 to 16 px")
        if not self.split_factor >= 1:
            raise ValueError(f"split_factor is {self.split_factor}, wanted at least 1")


def _check_threshold_and_noise(method: KissScanning | KissNearest) -> None:
    if not 0 <= method.threshold < 255:
        raise ValueError(f"threshold is {method.threshold}, wanted a grey level from 0 to below 255")
    if not (method.relative is None or 0 < method.relative < 1):
        raise ValueError(f"relative is {method.relative}, wanted a share above 0 and below 1, or None")
    if min(method.noise_width, method.noise_height) < 0:
        raise ValueError(
            f"noise_width and noise_height are {method.noise_width} and {method.noise_height}, wanted 0 px or more"
        )
