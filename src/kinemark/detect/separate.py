"""Detections of which each is one marker: overlapped ones told apart, partly hidden ones put where their centre is.

Suspected groups (`suspicion`) are cut out (`patches`) and explained (`overlap`); all others pass untouched. A group of
k discs becomes k detections with `merged` set, each with the covariance of its own centre and judged by its own size.
One that cannot be told apart keeps its centroid, with `merged` set and the larger covariance. A disc of which a part is
hidden gets the centre, the covariance and the area of the whole disc, so that later stages take it for one in full
sight. A disc at the image's edge likewise, but it stays AT_EDGE unless its centre is known within
`Centroids.max_edge_sd`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..data import Validity
from .blobs import Blobs
from .centroids_method import Centroids, grey_scale
from .grouping import PixelGroups
from .overlap import CUT, ONE, UNCLEAR, ObservedGroup, explain
from .patches import MARGIN, cut_out
from .suspicion import suspicious

PIXELS = 12_000  # fitted in one go: enough to share what NumPy costs a call, little enough for the cache; chosen


def separated(
    images: NDArray[np.uint8 | np.uint16],
    groups: PixelGroups,
    blobs: Blobs,
    *,
    threshold: float,
    variance: NDArray[np.float64],
    method: Centroids,
) -> Blobs:
    """The blobs of these groups in frames (n, H, W) of noise variance (n), with their markers told apart."""
    if method.max_discs < 2 and not method.correct_occlusion:
        return blobs
    aspect = method.aspect or 1.0
    some = suspicious(groups, blobs.validity, aspect=aspect)
    if not len(some):
        return blobs
    n, most = len(blobs.uv), method.max_discs + 1
    seen = ObservedGroup(
        np.ones(n, np.int64),
        np.full((n, most, 3), np.nan),
        np.full((n, most, 2, 2), np.nan),
        np.zeros((n, 2, 2)),
    )
    for part in _portions(groups, some):
        mask = np.zeros(n, np.bool_)
        mask[part] = True
        shot = method.shot_noise * grey_scale(images.dtype)
        cut = cut_out(images, groups.keep(mask), threshold=threshold, variance=variance, shot=shot, aspect=aspect)
        at_edge = blobs.validity[part] == Validity.AT_EDGE
        found = explain(cut, most=method.max_discs, hidden=method.correct_occlusion, at_edge=at_edge)
        k = found.circles.shape[1]
        order = np.argsort(found.circles[:, :, 1], axis=1)[:, :, None]  # from above, whatever the fit began with
        circles = np.take_along_axis(found.circles, order, 1)
        seen.kind[part], seen.spread[part] = found.kind, _stretched(found.spread, aspect)
        seen.circles[part, :k] = circles
        seen.circles[part, :k, :2] = circles[..., :2] * [1, aspect] + cut.origin[:, None]
        seen.cov[part, :k] = _stretched(np.take_along_axis(found.cov, order[..., None], 1), aspect)
    return _rows(blobs, seen, images.shape[1:], method)


def _portions(groups: PixelGroups, some: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Groups of like size that together have no more than `PIXELS`, each in rising order."""
    wide, high = groups.right[some] - groups.left[some], groups.bottom[some] - groups.top[some]
    pixels = (wide + 2 * MARGIN + 1) * (high + 2 * MARGIN + 1)
    order = np.argsort(-pixels, kind="stable")
    begin = 0
    while begin < len(order):
        number = max(1, int(PIXELS // pixels[order[begin]]))
        yield np.sort(some[order[begin : begin + number]])
        begin += number


def _stretched(cov: NDArray[np.float64], aspect: float) -> NDArray[np.float64]:
    """Covariances (…, 2, 2) of places whose v was divided by the aspect."""
    scale = np.array([1.0, aspect])
    return np.asarray(cov * scale[:, None] * scale)


def _rows(blobs: Blobs, seen: ObservedGroup, shape: tuple[int, ...], method: Centroids) -> Blobs:
    """The blobs with a row for each marker."""
    rows = np.where(seen.kind > ONE, seen.kind, 1)
    group = np.repeat(np.arange(len(rows)), rows)
    which = np.arange(len(group)) - np.repeat(np.cumsum(rows) - rows, rows)
    frame = np.repeat(np.arange(len(blobs.counts)), blobs.counts)[group]
    counts = np.bincount(frame, minlength=len(blobs.counts))
    new = Blobs(counts=counts, **{k: v[group] for k, v in blobs._asdict().items() if k != "counts"})
    kind, aspect = seen.kind[group], method.aspect or 1.0
    fitted = np.flatnonzero((kind > ONE) | (kind == CUT))
    centre, radius = seen.circles[group, which][fitted, :2], seen.circles[group, which][fitted, 2]
    new.uv[fitted], new.cov[fitted] = centre, seen.cov[group, which][fitted]
    new.area[fitted] = np.pi * radius**2 * aspect
    new.width[fitted], new.height[fitted] = 2 * radius, 2 * radius * aspect
    new.merged[:] |= (kind > ONE) | (kind == UNCLEAR)
    new.cov[:] += seen.spread[group]
    new.validity[fitted] = _judged(new, fitted, shape, method)
    return new


def _judged(blobs: Blobs, rows: NDArray[np.int64], shape: tuple[int, ...], method: Centroids) -> NDArray[np.uint8]:
    """Validity of fitted discs."""
    reach = np.stack([blobs.width[rows], blobs.height[rows]], -1) / 2
    low, high = blobs.uv[rows] - reach, blobs.uv[rows] + reach
    beyond = (low < -0.5).any(1) | (high > np.array(shape[::-1]) - 0.5).any(1)
    known = np.sqrt(blobs.cov[rows][:, [0, 1], [0, 1]].max(1)) < method.max_edge_sd
    reasons = {
        Validity.TOO_LARGE: blobs.area[rows] > method.limits.max_area,
        Validity.AT_EDGE: beyond & ~known,
        Validity.TOO_SMALL: blobs.area[rows] < method.limits.min_area,
    }
    return np.select(list(reasons.values()), list(reasons), Validity.VALID).astype(np.uint8)
