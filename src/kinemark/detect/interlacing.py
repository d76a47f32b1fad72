"""Whether images are two fields woven into one, and which field was taken first.

Where something moves, a row of an interlaced image resembles the rows of its own field, two away, more than the rows
beside it, which show another time. With e1 the sum of the squared errors of rows predicted as the mean of their
neighbours, and e2 that of rows predicted from those two away, over moving pixels,

    e1 / e2 > 1   woven fields          e1 / e2 near to 1/16   whole frames of smooth images             (1)

since the mean of two rows that lie d away misses a curve by d²/2 of its second derivative: (1/4)² = 1/16. Noise and
markers of a pixel are not smooth, and have e1 / e2 near to 1 too, but among columns as well: so woven fields have a
ratio clearly above that of columns (3). The bottom
field b_t lies in time halfway between the top fields t_t and t_(t+1) where the top one comes first, else between
t_(t-1) and t_t, so that

    |b_t - t_(t+1)| < |b_t - t_(t-1)|   top field first                                                   (2)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MOVED = 0.15  # of the range of grey levels; more is a motion, not noise; chosen
WOVEN = 0.4  # e1 / e2 above which fields are woven; chosen: simulated slow walks show 0.65 or more
WHOLE = 0.25  # e1 / e2 below which frames are whole; chosen: simulated and filmed markers show 0.1 to 0.15
CLEARER = 1.25  # times that of columns which e1 / e2 of fields is (3); chosen: whole frames of discs and noise have
# 0.7 to 1.2, woven ones that move by a pixel and more 1.3 to 18
FEWEST = 200  # moving pixels, below which nothing is said; chosen: some images of markers


class Interlacing(NamedTuple):
    """Which field was taken first: "top", "bottom", "" for whole frames, None where nothing moved enough to see.

    ratio: e1 / e2 of (1); pixels: how many moved.
    """

    first: str | None
    ratio: float
    pixels: int


def interlacing(frames: NDArray[np.uint8] | NDArray[np.uint16]) -> Interlacing:
    """What moving things in frames (F, H, W) of one camera show; F of at least 3, grey levels.

    Raises:
        ValueError: there are fewer frames than three or fewer rows than five.
    """
    if frames.ndim != 3 or frames.shape[0] < 3 or frames.shape[1] < 5:
        raise ValueError(f"frames have shape {frames.shape}, wanted (at least 3, at least 5 rows, columns)")
    grey = frames.astype(np.float32)
    moving = np.abs(np.diff(grey, axis=0)) > MOVED * float(np.ptp(grey))
    pixels = int(moving[:, 2:-2].sum())
    if pixels < FEWEST:
        return Interlacing(None, float("nan"), pixels)
    ratio = _ratio(grey, moving)  # (1)
    if ratio < WHOLE:
        return Interlacing("", ratio, pixels)
    woven = ratio > max(WOVEN, CLEARER * _ratio(grey.swapaxes(1, 2), moving.swapaxes(1, 2)))  # (3)
    return Interlacing(_first(grey) if woven else None, ratio, pixels)


def _ratio(grey: NDArray[np.float32], moving: NDArray[np.bool_]) -> float:
    """e1 / e2 of rows, over the moving pixels (F - 1, H, W) of frames (F, H, W) that lie within."""
    row, inside = grey[1:, 2:-2], moving[:, 2:-2]
    near = float(np.square(row - (grey[1:, 1:-3] + grey[1:, 3:-1]) / 2)[inside].sum())
    far = float(np.square(row - (grey[1:, :-4] + grey[1:, 4:]) / 2)[inside].sum())
    return near / far if far else float("inf")


def _first(grey: NDArray[np.float32]) -> str:
    """The field that was taken first, by (2)."""
    even = grey[:, : grey.shape[1] // 2 * 2]
    top, bottom = even[:, 0::2], even[:, 1::2]
    here = (bottom[1:-1, :-1] + bottom[1:-1, 1:]) / 2  # at the rows 1, 2, … of the top field
    after = float(np.square(here - top[2:, 1:]).sum())
    before = float(np.square(here - top[:-2, 1:]).sum())
    return "top" if after < before else "bottom"
