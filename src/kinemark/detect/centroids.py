"""Bright groups of pixels, each at its grey-weighted centroid: the steps of KISS section 2 in their order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data import KinemarkError, Validity
from .blobs import Blobs, joined
from .grouping import Groups, group_runs
from .method import Centroids, grey_scale
from .moments import Moments, measure, outline_centroids
from .noise import background
from .runs import find_runs
from .validity import judge, remove_noise

MOST_RUNS = 1 << 18
MOST_GROUPS = 10_000


def detect_centroids(images: NDArray[np.uint8 | np.uint16], first: int, method: Centroids) -> Blobs:
    """Markers in consecutive frames (n, H, W), of which the first has this number."""
    n, height, width = images.shape
    threshold = np.floor(method.threshold * grey_scale(images.dtype))
    tall = images.reshape(n * height, width)
    runs = find_runs(tall, threshold, most=MOST_RUNS if n > 1 else None)
    if len(runs.y) == MOST_RUNS and n > 1:  # bright frames: fewer at a time, for memory's sake
        half = n // 2
        return joined(
            [detect_centroids(images[:half], first, method), detect_centroids(images[half:], first + half, method)]
        )
    groups = group_runs(runs, height=height, width=width)
    _check_number(groups, first, n, method)
    groups = remove_noise(groups, method=method)
    validity = judge(groups, height=height, width=width, method=method)
    uv, cov, area, peak = _moments(images, groups, validity, threshold, method)
    return Blobs(
        counts=np.bincount(groups.frame, minlength=n),
        uv=uv,
        cov=cov,
        area=area,
        width=(groups.right - groups.left + 1).astype(np.float64),
        height=(groups.bottom - groups.top + 1).astype(np.float64),
        peak=peak,
        validity=validity,
        merged=np.zeros(len(uv), np.bool_),
    )


def _moments(
    images: NDArray[np.uint8 | np.uint16],
    groups: Groups,
    validity: NDArray[np.uint8],
    threshold: float,
    method: Centroids,
) -> Moments:
    """Grey-weighted centroids, save for what is too large to be a marker."""
    scale = grey_scale(images.dtype)
    level, variance = background(images)
    if method.noise is not None:
        variance = np.full_like(variance, (method.noise * scale) ** 2)
    marker = validity != Validity.TOO_LARGE
    fine = measure(
        images,
        groups if marker.all() else groups.keep(marker),
        threshold=threshold,
        level=level,
        variance=variance,
        shot=method.shot * scale,
    )
    if marker.all():
        return fine
    g = len(marker)
    uv, cov = outline_centroids(groups, height=images.shape[1]), np.full((g, 2, 2), np.nan)
    area, peak = groups.area.astype(np.float64), np.full(g, np.nan)
    uv[marker], cov[marker], area[marker], peak[marker] = fine
    return Moments(uv, cov, area, peak)


def _check_number(groups: Groups, first: int, n: int, method: Centroids) -> None:
    counts = np.bincount(groups.frame, minlength=n)
    if counts.max(initial=0) > MOST_GROUPS:
        raise KinemarkError(
            f"Frame {first + counts.argmax()} of the images has {counts.max()} white groups of pixels at threshold "
            f"{method.threshold:g}, wanted at most {MOST_GROUPS}: the threshold lies in the noise. Raise it."
        )
