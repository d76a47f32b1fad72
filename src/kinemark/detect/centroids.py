"""Bright groups of pixels, each at its grey-weighted centroid: the steps of KISS section 2 in their order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError, Validity
from .background_noise import ROUNDING, background
from .blobs import Blobs
from .centroids_method import Centroids, grey_scale
from .grouping import PixelGroups, group_runs
from .moments import Moments, measure, outline_centroids, white_moments
from .pixel_runs import find_runs
from .saturation import without_clipped
from .separate import Suspects, separated, suspects
from .specks import blurred
from .stage import DETECT
from .validity import judge, remove_noise

MOST_RUNS = 1 << 18  # white runs of a batch, above which it is halved; chosen for memory
MOST_GROUPS = 10_000  # groups of a frame at most; chosen: more are the noise of a threshold set too low


@DETECT.method("centroids", Centroids, source="Shafiq, Tümer and Güler 2001, section 2")
def detect_centroids(images: NDArray[np.uint8 | np.uint16], first: int, *, method: Centroids) -> Blobs:
    """Markers in consecutive frames (n, H, W), of which the first has this number."""
    return separated(found_suspects(images, first, method=method), method=method)


def found_suspects(images: NDArray[np.uint8 | np.uint16], first: int, *, method: Centroids) -> list[Suspects]:
    """The same before `separated`, in parts of consecutive frames."""
    if not method.inverted:
        return _bright(images, first, method)
    white = int(np.iinfo(images.dtype).max)
    bright = replace(method, inverted=False)
    found = _bright(np.invert(images), first, bright, white - method.limits.threshold * grey_scale(images.dtype))
    return [part._replace(negative=white) for part in found]


def _bright(
    images: NDArray[np.uint8 | np.uint16], first: int, method: Centroids, level: float | None = None
) -> list[Suspects]:
    """Bright markers; `level` is the threshold in the images' own grey levels where it is not the method's."""
    n, height, width = images.shape
    threshold = np.floor(method.limits.threshold * grey_scale(images.dtype) if level is None else level)
    tall = images.reshape(n * height, width)
    runs = find_runs(tall, threshold, most=MOST_RUNS if n > 1 else None)
    if len(runs.y) == MOST_RUNS and n > 1:  # bright frames: fewer at a time, for memory's sake
        half = n // 2
        return _bright(images[:half], first, method, level) + _bright(images[half:], first + half, method, level)
    groups = group_runs(runs, height=height, width=width)
    _check_number(groups, first, n, method)
    groups = remove_noise(groups, method=method)
    groups = groups.keep(blurred(images, groups))
    ground, variance = background(images)
    if method.noise_sd is not None:
        variance = np.full_like(variance, max((method.noise_sd * grey_scale(images.dtype)) ** 2, ROUNDING))
    blobs = _whole(images, groups, threshold, ground, variance, method)
    return [suspects(images, groups, blobs, threshold=threshold, variance=variance, method=method)]


def _whole(
    images: NDArray[np.uint8 | np.uint16],
    groups: PixelGroups,
    threshold: float,
    ground: NDArray[np.float64],
    variance: NDArray[np.float64],
    method: Centroids,
) -> Blobs:
    """Each group as one marker at its grey-weighted centroid, save for what is too large to be a marker."""
    n, height, width = images.shape
    validity = judge(groups, height=height, width=width, method=method)
    if method.centroid == "white":
        return _of_moments(white_moments(images, groups), groups, validity, n)
    shot = method.shot_noise * grey_scale(images.dtype)
    marker = validity != Validity.TOO_LARGE
    some = groups if marker.all() else groups.keep(marker)
    fine = measure(
        images, some, threshold=threshold, level=ground, variance=variance, shot=shot, aspect=method.aspect or 1.0
    )
    if not marker.all():
        fine = _with_large(fine, groups, marker, height)
    blobs = _of_moments(fine, groups, validity, n)
    return without_clipped(images, groups, blobs, ground=ground, variance=variance, shot=shot)


def _of_moments(moments: Moments, groups: PixelGroups, validity: NDArray[np.uint8], n: int) -> Blobs:
    """The groups of n frames, each with its moments."""
    return Blobs(
        counts=np.bincount(groups.frame, minlength=n),
        **moments._asdict(),
        width=(groups.right - groups.left + 1).astype(np.float64),
        height=(groups.bottom - groups.top + 1).astype(np.float64),
        validity=validity,
        merged=np.zeros(len(validity), np.bool_),
    )


def _with_large(fine: Moments, groups: PixelGroups, marker: NDArray[np.bool_], height: int) -> Moments:
    """The moments of markers, and of all other groups what their white pixels say."""
    g = len(marker)
    uv, cov = outline_centroids(groups, height=height), np.full((g, 2, 2), np.nan)
    area, peak = groups.area.astype(np.float64), np.full(g, np.nan)
    uv[marker], cov[marker], area[marker], peak[marker] = fine
    return Moments(uv, cov, area, peak)


def _check_number(groups: PixelGroups, first: int, n: int, method: Centroids) -> None:
    counts = np.bincount(groups.frame, minlength=n)
    if counts.max(initial=0) > MOST_GROUPS:
        raise KinemarkError(
            f"Frame {first + counts.argmax()} of the images has {counts.max()} white groups of pixels at threshold "
            f"{method.limits.threshold:g}, wanted at most {MOST_GROUPS}: the threshold lies in the noise. Raise it."
        )
