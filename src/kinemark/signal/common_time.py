"""Detections of cameras that are not synchronous, moved to the times of the frames.

Camera c takes its image k at the time k / r_c + d_c, r_c its rate in Hz and d_c its delay in s: an image that is taken
later has a positive one. Frame f, at f / r, gets the image that is nearest in time, which is

    δ(c, f) = k / r_c + d_c − f / r                                      (1)

late. In the images of one camera a marker moves little. With a and b the detections before and after u that go on most
evenly, those of the least

    |a − 2 u + b|² + STEP_WEIGHT |b − a|²                                (2)

the marker was at the time of the frame, s = −δ r_c images later, on the parabola through the three,

    u + s (b − a) / 2 + s² (a − 2 u + b) / 2                             (3)

and each of the three enters the covariance with the square of its weight (4). A detection that no other goes on from
stays where it is, and may be off by as far as the camera's others were moved, the root of their mean square (5).
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..data import Detections
from ..data.array_types import Bools, Floats, Ints
from ..data.detections import NOT_ROWS

STEP_WEIGHT = 0.01
"""Of (2), a ratio of squares; chosen: markers change their step by a tenth of it, and more where they are still."""

NEIGHBOURS = 3
"""Detections before, and after, that are tried; chosen: with more, others are taken for the marker."""

MAX_BEND = 2.0
"""px, and half of the step, that a step may change to the next; chosen: noise, and what limbs do at 50 Hz."""

NEGLIGIBLE = 1e-6
"""Of the time between images: a time difference that moves nothing; chosen."""


class CommonTime(NamedTuple):
    """The moved detections (D'), and the row (D') of each in those that were given."""

    detections: Detections
    row: Ints


def at_common_time(
    detections: Detections, delay: ArrayLike, *, rate: ArrayLike | None = None, first_frame: int = 0
) -> CommonTime:
    """The detections as they would be, had every camera taken its images at the times of the frames.

    Frames that no image of a camera is nearest to, at its beginning and end, have no detections of it. Where cameras
    have rates of their own, there are as many frames as the cameras' detections last.

    Args:
        detections: of C cameras, image after image.
        delay: (C) s by which each camera takes its images later than the frames are.
        rate: (C) Hz of each camera; that of the detections where None.
        first_frame: number of the first image in the recording, where the detections are a part of it.

    Raises:
        ValueError: not one finite delay, or one rate above 0, for each camera.
    """
    C, F = len(detections.cameras), detections.n_frames
    delay = np.asarray(delay, np.float64)
    rates = np.full(C, detections.rate) if rate is None else np.asarray(rate, np.float64)
    if delay.shape != (C,) or rates.shape != (C,) or not (np.isfinite(delay).all() and (rates > 0).all()):
        raise ValueError(
            f"wanted a finite delay and a rate above 0 for each of {C} cameras, found {delay} s, {rates} Hz"
        )
    images, F = F, F if (rates == detections.rate).all() else _frames(detections, rates, delay, first_frame)
    rows, counts, advance = [np.zeros(0, np.int64)], np.zeros((C, F), np.int64), [np.zeros(0)]
    for c in range(C):
        image, late = nearest_images(F, detections.rate, float(rates[c]), float(delay[c]), first_frame, n_images=images)
        own = _rows_of_images(detections, c, image)
        counts[c] = [len(each) for each in own]
        rows += own
        advance.append(np.repeat(-late * rates[c], counts[c]))
    row = np.concatenate(rows)
    columns = {f.name: getattr(detections, f.name)[row] for f in fields(detections) if f.name not in NOT_ROWS}
    columns["uv"], columns["cov"] = _moved(detections, row, np.concatenate(advance))
    return CommonTime(Detections.build(detections.cameras, detections.rate, counts, **columns), row)


def moved_in_time(detections: Detections, late: ArrayLike) -> Detections:
    """The same rows where they were at the times of the frames, of images that are taken late by (D) s, at most by the
    time between two."""
    uv, cov = _moved(detections, np.arange(len(detections)), -np.asarray(late, np.float64) * detections.rate)
    return replace(detections, uv=uv, cov=cov)


def image_flow(detections: Detections) -> Floats:
    """(D, 2) px by which the detections move from image to image, by those before and after; NaN where none goes on."""
    flow = np.full((len(detections), 2), np.nan)
    for c in range(len(detections.cameras)):
        own = slice(int(detections.start[c, 0]), int(detections.start[c, -1]))
        uv = detections.uv[own]
        before, after = linked(uv, detections.frame[own])
        flow[own] = np.where((before >= 0)[:, None], (uv[after] - uv[before]) / 2, np.nan)
    return flow


def nearest_images(
    n: int, rate: float, camera_rate: float, delay: float, first: int = 0, *, n_images: int | None = None
) -> tuple[Ints, Floats]:
    """Of n frames the camera's nearest image, −1 where it lies outside its images, n where None, and δ (n) s by (1)."""
    time = (np.arange(n) + first) / rate
    image = np.rint((time - delay) * camera_rate).astype(np.int64)
    late = image / camera_rate + delay - time
    image = image - first
    return np.where((image >= 0) & (image < (n if n_images is None else n_images)), image, -1), late


def _frames(detections: Detections, rates: Floats, delay: Floats, first: int) -> int:
    """Frames until the last image with detections of the camera that has them longest."""
    last = np.array([np.flatnonzero(counts).max(initial=-1) for counts in detections.counts])
    end = ((last + first) / rates + delay) * detections.rate
    return max(int(np.rint(end[last >= 0].max(initial=first - 1))) - first + 1, 0)


def _rows_of_images(detections: Detections, c: int, image: Ints) -> list[Ints]:
    """The rows of camera c of each image (F), none for −1."""
    start = detections.start[c]
    return [np.arange(start[k], start[k + 1]) if k >= 0 else np.zeros(0, np.int64) for k in image.tolist()]


def _moved(detections: Detections, row: Ints, advance: Floats) -> tuple[Floats, Floats]:
    """uv (N, 2) px and cov (N, 2, 2) px² of rows (N), s (N) images later."""
    camera, uv, cov = detections.camera[row], detections.uv[row], detections.cov[row]
    for c in np.unique(camera[np.abs(advance) > NEGLIGIBLE]).tolist():
        own = camera == c
        uv[own], cov[own] = _moved_in_camera(detections, c, row[own], advance[own])
    return uv, cov


def _moved_in_camera(detections: Detections, c: int, row: Ints, s: Floats) -> tuple[Floats, Floats]:
    """`_moved` of one camera."""
    whole = slice(int(detections.start[c, 0]), int(detections.start[c, -1]))
    before, after = (near[row - whole.start] for near in linked(detections.uv[whole], detections.frame[whole]))
    alone = before < 0
    weight = np.array([(s * s - s) / 2, 1 - s * s, (s * s + s) / 2])  # (3)
    weight[:, alone] = np.array([[0.0], [1.0], [0.0]])
    three = np.array([before + whole.start, row, after + whole.start])
    uv = np.einsum("kn,kni->ni", weight, detections.uv[three])
    cov = np.einsum("kn,knij->nij", weight**2, detections.cov[three])  # (4)
    shift = ((uv - detections.uv[row])[~alone] ** 2).sum(1)
    half_shift = shift.mean() / 2 if len(shift) else 0.0
    return uv, cov + np.where(alone, half_shift, 0.0)[:, None, None] * np.eye(2)  # (5)


def linked(uv: Floats, frame: Ints) -> tuple[Ints, Ints]:
    """(N) the detections of the image before and after that each of uv (N, 2) px goes on from and to by (2); both −1
    where it goes on from none."""
    none = np.full(len(uv), -1)
    good = np.flatnonzero(np.isfinite(uv).all(1))
    if not len(good):
        return none, none.copy()
    apart = 4 * (np.ptp(uv[good], axis=0).max() + 1)  # images lie so far from each other that none is near the next
    place = np.column_stack([uv[good], frame[good] * apart])
    tree = scipy.spatial.cKDTree(place)
    near = []
    for way in (-1, 1):
        found = tree.query(place + np.array([0, 0, way * apart]), k=NEIGHBOURS, distance_upper_bound=apart / 2)[1]
        near.append(np.where(found < len(good), good[np.minimum(found, len(good) - 1)], -1))
    before, after = none.copy(), none.copy()
    before[good], after[good] = _smoothest(uv, good, *near)
    return before, after


def _smoothest(uv: Floats, middle: Ints, before: Ints, after: Ints) -> tuple[Ints, Ints]:
    """Of detections `middle` (n), and those before and after (n, k), the pair by (2)."""
    a, b = np.repeat(before, NEIGHBOURS, axis=1), np.tile(after, NEIGHBOURS)
    bend = np.linalg.norm(uv[a] - 2 * uv[middle][:, None] + uv[b], axis=-1)
    step = np.linalg.norm(uv[b] - uv[a], axis=-1)
    fits: Bools = (a >= 0) & (b >= 0) & (bend < MAX_BEND + step / 4)
    best = np.where(fits, bend**2 + STEP_WEIGHT * step**2, np.inf).argmin(1)[:, None]
    fit = np.take_along_axis(fits, best, 1)[:, 0]
    before, after = (np.where(fit, np.take_along_axis(each, best, 1)[:, 0], -1) for each in (a, b))
    return before, after
