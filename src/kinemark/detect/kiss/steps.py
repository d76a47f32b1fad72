"""The steps of KISS section 2 in their order, from frames to detections."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...data import KinemarkError, Validity
from ...data.array_types import GreyLevels
from ..blobs import Blobs, joined
from ..centroids_method import grey_scale
from ..pixel_runs import Runs
from ..stage import DETECT
from .kiss_methods import KissNearest, KissScanning
from .long_wide import split_long_and_wide
from .neighbour_grouping import adaptive_limits, neighbour_groups, split_harshly
from .noise_removal import remove_noise
from .overlapped_markers import separate_overlapped
from .pixel_groups import KissGroups, rectangles, white_pixels
from .scanning import preliminary_groups
from .size import size_validity
from .submarkers import merge_sub_markers
from .white import pixels_of, runs_of
from .white_centroids import centroids, peaks

MOST_GROUPS = 10_000
"""Groups of a frame at most; chosen: more are the noise of a threshold set too low (see studies/kiss_detection.py)."""
MOST_PIXELS = 1 << 20  # white, of a batch; above that its frames are done in smaller batches, for memory's sake; chosen


@DETECT.method("kiss_scanning", KissScanning, source="Shafiq, Tümer and Güler 2001, 2.1 to 2.3")
def detect_scanning(images: GreyLevels, first: int, *, method: KissScanning) -> Blobs:
    """Markers in consecutive frames (n, H, W), of which the first has this number, by the present method of KISS.

    Raises:
        KinemarkError: a frame has thousands of white specks, so the threshold lies in its noise.
    """
    n, height, width = images.shape
    runs = _white_runs(images, method)
    if _too_many(runs) and n > 1:
        return _by_halves(partial(detect_scanning, method=method), images, first)
    groups = preliminary_groups(runs, near_x=method.near_x, near_y=method.near_y, height=height, width=width)
    _check_number(groups, first, n, method.threshold)
    groups = advanced_analysis(_without_noise(groups, method), method, height=height)
    validity = np.zeros(len(groups.frame), np.uint8)
    if method.check_sizes:
        validity = size_validity(groups, min_area=method.min_area, max_area=method.max_area, height=height, width=width)
    return _blobs(images, groups, validity, method.inverted)


def advanced_analysis(groups: KissGroups, method: KissScanning, *, height: int) -> KissGroups:
    """Sub-marker detection, overlapped markers and the long/wide test, as far as the method asks for them."""
    if method.sub_markers:
        groups = merge_sub_markers(
            groups, small_area=method.small_area, small_rows=method.small_rows, inside=method.min_inside, height=height
        )
    if method.overlaps:
        groups = separate_overlapped(
            groups, fill=method.overlap_fill, shift=method.overlap_shift, row_overlap=method.row_overlap
        )
    if method.long_wide:
        groups = split_long_and_wide(groups, min_ratio=method.min_ratio, max_ratio=method.max_ratio)
    return groups


@DETECT.method("kiss_nearest", KissNearest, source="Shafiq, Tümer and Güler 2001, section 2")
def detect_nearest(images: GreyLevels, first: int, *, method: KissNearest) -> Blobs:
    """Markers in consecutive frames (n, H, W), of which the first has this number, by the former method of KISS.

    Raises:
        KinemarkError: a frame has thousands of white specks, so the threshold lies in its noise.
    """
    n, height, width = images.shape
    runs = _white_runs(images, method)
    if _too_many(runs) and n > 1:
        return _by_halves(partial(detect_nearest, method=method), images, first)
    y, x = pixels_of(*runs)
    groups = neighbour_groups(y, x, neighbourhood=method.neighbourhood, height=height, width=width)
    _check_number(groups, first, n, method.threshold)
    groups = _without_noise(groups, method)
    if method.split:
        wide, high = adaptive_limits(groups, factor=method.split_factor, frames=n)
        groups = split_harshly(groups, wide=wide, high=high)
    return _blobs(images, groups, np.zeros(len(groups.frame), np.uint8), method.inverted)


def _white_runs(images: GreyLevels, method: KissScanning | KissNearest) -> Runs:
    """Runs of pixels beyond the threshold."""
    level = method.threshold * grey_scale(images.dtype)
    if not method.inverted:
        return runs_of(images, np.floor(level))
    return runs_of(np.invert(images), np.floor(np.iinfo(images.dtype).max - level))


def _without_noise(groups: KissGroups, method: KissScanning | KissNearest) -> KissGroups:
    return remove_noise(
        groups,
        min_width=method.noise_width,
        min_height=method.noise_height,
        isolated=method.isolated,
        one_wide=method.one_wide,
        one_high=method.one_high,
    )


def _blobs(images: GreyLevels, groups: KissGroups, validity: NDArray[np.uint8], inverted: bool) -> Blobs:
    """The columns of every group; where it is too large for a marker, no covariance and no peak."""
    brect = rectangles(groups)
    uv, cov = centroids(groups, height=images.shape[1])
    large = validity == Validity.TOO_LARGE
    cov[large] = np.nan
    peak = np.full(len(large), np.nan)
    peak[~large] = peaks(images, groups.keep(~large), darkest=inverted)
    return Blobs(
        counts=np.bincount(groups.frame, minlength=len(images)),
        uv=uv,
        cov=cov,
        area=white_pixels(groups).astype(np.float64),
        width=brect.width.astype(np.float64),
        height=brect.height.astype(np.float64),
        peak=peak,
        validity=validity,
        merged=groups.separated,
    )


def _by_halves(detect: Callable[[GreyLevels, int], Blobs], images: GreyLevels, first: int) -> Blobs:
    """The detections of a batch, one half after the other."""
    half = len(images) // 2
    return joined([detect(images[:half], first), detect(images[half:], first + half)])


def _too_many(runs: Runs) -> bool:
    return int((runs.last - runs.first + 1).sum()) > MOST_PIXELS


def _check_number(groups: KissGroups, first: int, n: int, threshold: float) -> None:
    counts = np.bincount(groups.frame, minlength=n)
    if counts.max(initial=0) > MOST_GROUPS:
        raise KinemarkError(
            f"Frame {first + counts.argmax()} of the images has {counts.max()} white groups of pixels at threshold "
            f"{threshold:g}, wanted at most {MOST_GROUPS}: the threshold lies in the noise. Raise it."
        )
