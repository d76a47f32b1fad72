"""Detections of which each is one marker: overlapped ones told apart, partly hidden ones put where their centre is.

Suspected groups (`suspicion`) are cut out (`patches`) and explained (`overlap`); all others pass untouched. A group of
k discs becomes k detections with `merged` set, each with the covariance of its own centre and judged by its own size.
One that cannot be told apart keeps its centroid, with `merged` set and the larger covariance. A disc of which a part is
hidden gets the centre, the covariance and the area of the whole disc, so that later stages take it for one in full
sight. A disc at the image's edge likewise, but it stays AT_EDGE unless its centre is known within
`Centroids.max_edge_sd`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..data import Validity
from ..data.array_types import Bools, Floats, GreyLevels, Ints
from .blobs import Blobs, joined
from .centroids_method import Centroids, grey_scale
from .grouping import PixelGroups
from .overlap import CUT, ONE, UNCLEAR, ObservedGroup, explain
from .patches import Uncut, cut_out, pixels_of, together
from .suspicion import suspicious

PIXELS = 48_000  # fitted in one go: enough to share what NumPy costs a call, little enough for the cache; chosen


class Suspects(NamedTuple):
    """The blobs of some frames, of which those that may be more, or less, than one marker are yet to be explained.

    Attributes:
        blobs: as if each were one marker; which: (n) the suspected ones; pixels: theirs, None where n is 0.
        threshold: grey level above which a pixel is white.
        shape: of the frames, (n, H, W); scale: grey levels of the images to one of 8 bits.
        negative: the highest grey level where the images are negatives, else None.
    """

    blobs: Blobs
    which: Ints
    pixels: Uncut | None
    threshold: float
    shape: tuple[int, ...]
    scale: float
    negative: int | None = None


def suspects(
    images: GreyLevels, groups: PixelGroups, blobs: Blobs, *, threshold: float, variance: Floats, method: Centroids
) -> Suspects:
    """The blobs of these groups in frames (n, H, W) of noise variance (n), and the pixels of those to be explained."""
    some = np.zeros(0, np.int64)
    if method.max_discs > 1 or method.correct_occlusion:
        some = suspicious(groups, blobs.validity, aspect=method.aspect or 1.0)
    pixels = None
    if len(some):
        mask = np.zeros(len(blobs.uv), np.bool_)
        mask[some] = True
        pixels = pixels_of(images, groups.keep(mask), threshold=threshold, variance=variance)
    return Suspects(blobs, some, pixels, threshold, images.shape, grey_scale(images.dtype))


def separated(parts: Sequence[Suspects], *, method: Centroids) -> Blobs:
    """The blobs of one part or more, with their markers told apart; parts are of one camera, and so of one threshold.

    Many frames are done at once, as their groups share what NumPy costs a call.
    """
    blobs, some = joined([part.blobs for part in parts]), parts[0]
    if pixels := [part.pixels for part in parts if part.pixels]:
        first = np.cumsum([0, *(len(part.blobs.uv) for part in parts[:-1])])
        which = np.concatenate([part.which + start for part, start in zip(parts, first, strict=True)])
        seen = _explained(together(pixels), blobs.validity[which] == Validity.AT_EDGE, some, method)
        blobs = _rows(blobs, which, seen, some.shape[1:], method)
    return blobs if some.negative is None else blobs._replace(peak=some.negative - blobs.peak)


def _explained(pixels: Uncut, at_edge: Bools, part: Suspects, method: Centroids) -> ObservedGroup:
    """What n groups show, places counted in their own frames."""
    n, aspect = len(at_edge), method.aspect or 1.0
    k = method.max_discs + 1
    circles, cov = np.full((n, k, 3), np.nan), np.full((n, k, 2, 2), np.nan)
    seen = ObservedGroup(np.full(n, ONE), circles, cov, np.zeros((n, 2, 2)))
    for some in _portions(pixels.number):
        shot = method.shot_noise * part.scale
        cut = cut_out(pixels, some, threshold=part.threshold, shot=shot, aspect=aspect)
        found = explain(cut, most=method.max_discs, hidden=method.correct_occlusion, at_edge=at_edge[some])
        k = found.circles.shape[1]
        order = np.argsort(found.circles[:, :, 1], axis=1)[:, :, None]  # from above, whatever the fit began with
        circles = np.take_along_axis(found.circles, order, 1)
        seen.kind[some], seen.spread[some] = found.kind, _stretched(found.spread, aspect)
        seen.circles[some, :k] = circles
        seen.circles[some, :k, :2] = circles[..., :2] * [1, aspect] + cut.origin[:, None]
        seen.cov[some, :k] = _stretched(np.take_along_axis(found.cov, order[..., None], 1), aspect)
    return seen


def _portions(number: Ints) -> Iterator[Ints]:
    """Groups of these numbers of pixels (n), of like size, that together have no more than `PIXELS`."""
    order = np.argsort(-number, kind="stable")
    begin = 0
    while begin < len(order):
        count = max(1, int(PIXELS // number[order[begin]]))
        yield np.sort(order[begin : begin + count])
        begin += count


def _stretched(cov: NDArray[np.float64], aspect: float) -> NDArray[np.float64]:
    """Covariances (…, 2, 2) of places whose v was divided by the aspect."""
    scale = np.array([1.0, aspect])
    return np.asarray(cov * scale[:, None] * scale)


def _rows(blobs: Blobs, which: Ints, seen: ObservedGroup, shape: tuple[int, ...], method: Centroids) -> Blobs:
    """The blobs with a row for each marker; those of this index (n) are what was seen."""
    number = np.maximum(seen.kind, 1)
    rows = np.ones(len(blobs.uv), np.int64)
    rows[which] = number
    every = np.repeat(np.arange(len(rows)), rows)
    frame = np.repeat(np.arange(len(blobs.counts)), blobs.counts)[every]
    counts = np.bincount(frame, minlength=len(blobs.counts))
    new = Blobs(counts=counts, **{k: v[every] for k, v in blobs._asdict().items() if k != "counts"})
    group = np.repeat(np.arange(len(which)), number)
    disc = np.arange(len(group)) - np.repeat(np.cumsum(number) - number, number)
    row, kind, aspect = (np.cumsum(rows) - rows)[which][group] + disc, seen.kind[group], method.aspect or 1.0
    new.merged[row] |= (kind > ONE) | (kind == UNCLEAR)
    new.cov[row] += seen.spread[group]
    fitted = (kind > ONE) | (kind == CUT)
    row, group, disc = row[fitted], group[fitted], disc[fitted]
    radius = seen.circles[group, disc, 2]
    new.uv[row], new.cov[row] = seen.circles[group, disc, :2], seen.cov[group, disc]
    new.area[row] = np.pi * radius**2 * aspect
    new.width[row], new.height[row] = 2 * radius, 2 * radius * aspect
    new.validity[row] = _judged(new, row, shape, method)
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
