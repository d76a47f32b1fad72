"""Whether the cameras are synchronous, from the tracks.

A camera that takes its images later by τ shows a marker of velocity v where it is by then, so that its image lies off
the projection of the point X by

    off_c = J_c (x + v τ_c) + noise,   J_c = ∂u_c/∂X                     (1)

where x is what all the cameras of the point have in common, and moves it instead. With Q = 1 − J (JᵀJ)⁻¹ Jᵀ, which
takes x away, and D the images' velocities J_c v, each in its own camera's column,

    τ = (Σ DᵀQ D)⁻¹ Σ DᵀQ off                                            (2)

over the points that three and more cameras see. What all cameras have in common no image shows, so delays are given
less their median. Points of one track follow each other, and what bends one bends its neighbours; so the recording is
cut into k parts, and with τ₍ⱼ₎ the solution without the j-th, the variance is (k − 1)/k Σ (τ₍ⱼ₎ − mean)² (3), the
jackknife's (Tukey 1958).

A rolling shutter takes the rows of an image one after the other: with y from −1 in the first row to 1 in the last, an
image at y is taken λ_c y later than the camera's middle row. (2) then has for each camera a second column y J_c v (4),
and λ counts where it is significant in any.

A calibration that is off moves images as well, by more than delays do where little moves. It is left open beside them
(`timing_fit`), and what moves fast may be off by as much as delays that are not yet known.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ....data import Cloud, Tracks
from ....data.array_types import Bools, Floats, Ints
from ..detection_index import EVERY, Images, Rows
from ..following.associate import predict_images
from ..following.kalman_states import KalmanStates
from .timing_fit import PARTS, Moving, TimingFit, calibration_columns, timing_fit
from .timing_noise import timing_noise

MIN_SHIFT = 0.5
"""px; less is what a usual calibration leaves; chosen (see benchmarks/tracking.py)."""

MIN_UNEVEN_SHIFT = 1.0
"""px, the same of a standard deviation; chosen (see benchmarks/tracking_scenes.py): sprints before calibrations 1 px
off reach 0.98."""

MIN_STANDARD_ERRORS = 5.0
"""Standard errors of a delay; chosen (see benchmarks/tracking.py)."""

MAX_PLACES = 24_000
"""Points, times cameras, that are looked at, at most, at even steps in time; chosen: more take as long as tracking, and
delays are known to some thousandths of a frame from as many."""

AT_ONCE = 50_000
"""Points that are looked at in one go; chosen: more would take memory and no less time."""

MIN_POINTS = 300
"""Points from which something can be said; chosen (see benchmarks/tracking.py)."""

MAX_VELOCITY_CHANGE = 0.5
"""Of a point's velocity: the most by which it may change in a frame; nothing else says when the point was where.
Chosen (see benchmarks/tracking.py)."""

FAST = 0.9
"""Quantile of the images' speed for `TimeOffsets.shift`: where people move, most markers hardly do; chosen."""


class TrackedImages(Protocol):
    """Tracks, and the images that they are made of."""

    @property
    def tracks(self) -> Tracks:
        """The tracks."""

    @property
    def images(self) -> Images:
        """What the cameras saw."""


class TimeOffsets(NamedTuple):
    """How much later than the others C cameras take their images; NaN where not known.

    Attributes:
        delay, error: (C) frames, and its standard error; shift: (C) px by which that moves images that are fast.
        line, line_error, line_shift: (C) λ of (4), the same way; 0 where no camera has a rolling shutter.
        unsteady, unsteady_error: (C) frames², the variance of the times of the camera's images (`timing_noise`), and
        its standard error; unsteady_shift: (C) px, the standard deviation of images that are fast which that makes.
    """

    delay: Floats
    error: Floats
    shift: Floats
    line: Floats
    line_error: Floats
    line_shift: Floats
    unsteady: Floats
    unsteady_error: Floats
    unsteady_shift: Floats

    @property
    def significant(self) -> Bools:
        """(C) cameras whose delay is no chance, and moves their images by more than a usual calibration does."""
        return (np.abs(self.delay) > MIN_STANDARD_ERRORS * self.error) & (self.shift > MIN_SHIFT)

    @property
    def rolling(self) -> Bools:
        """(C) cameras whose rolling shutter is no chance, likewise."""
        return (np.abs(self.line) > MIN_STANDARD_ERRORS * self.line_error) & (self.line_shift > MIN_SHIFT)

    @property
    def flickering(self) -> Bools:
        """(C) cameras the times of whose images are not even, likewise."""
        return (self.unsteady > MIN_STANDARD_ERRORS * self.unsteady_error) & (self.unsteady_shift > MIN_UNEVEN_SHIFT)


def time_offsets(result: TrackedImages) -> TimeOffsets:
    """The delays of the cameras of a run, by (2)."""
    C = len(result.images.P)
    if (moving := _moving(result)) is None:
        return TimeOffsets(*np.full((3, C), np.nan), *np.zeros((3, C)), *np.full((3, C), np.nan))
    speed = np.quantile(np.linalg.norm(moving.flow, axis=-1), FAST, axis=0)
    columns = np.stack([moving.flow, moving.flow * moving.y[..., None]], -1)  # (4)
    fit = timing_fit(moving, columns)
    found = _with_errors(moving, fit, speed)
    if not found.rolling.any():
        fit = timing_fit(moving, columns[..., :1])
        found = _with_errors(moving, fit, speed)
    variance, error = timing_noise(moving, fit)
    shift = np.sqrt(np.maximum(variance, 0.0)) * speed
    return found._replace(unsteady=variance, unsteady_error=error, unsteady_shift=shift)


def fast_residual(result: TrackedImages) -> float:
    """px, by which images of points in fast motion disagree beside what the calibration leaves; NaN of few points."""
    moving = _moving(result)
    return timing_fit(moving, np.zeros((*moving.flow.shape, 0))).fast if moving is not None else np.nan


def row_of_images(images: Images, rows: Rows = EVERY) -> Floats:
    """(…) y of (4) of some images."""
    return np.asarray(np.clip(2 * images.uv[rows, 1] / images.size[images.camera[rows], 1] - 1, -1.0, 1.0))


def _with_errors(moving: Moving, fit: TimingFit, speed: Floats) -> TimeOffsets:
    """What was fitted as delays, and as lines where these are wanted too, where images move at speeds (C)."""
    still = ~(moving.flow[fit.weight > 0] != 0).any((0, 2))
    found = np.where(still[:, None], np.nan, np.concatenate([fit.theta[None], fit.without]))  # (1 + PARTS, C, n)
    found[..., 0] -= np.nanmedian(found[..., 0], axis=1, keepdims=True) if not still.all() else 0.0
    error = found[1:].std(0) * np.sqrt(PARTS - 1)  # (3)
    rows = np.array([found[0].T, error.T, np.abs(found[0].T) * speed])  # (3, n, C)
    none = np.zeros((3, len(speed)))
    return TimeOffsets(*rows[:, 0], *(rows[:, 1] if found.shape[-1] == 2 else none), *none)


def _moving(result: TrackedImages) -> Moving | None:
    """The points of tracks that three cameras see, with the point before and after them; None of fewer than
    MIN_POINTS."""
    cloud, ids = result.tracks.cloud, result.tracks.id
    frame, order = cloud.frame, np.lexsort([cloud.frame, ids])
    parts = range(0, len(order) or 1, AT_ONCE)
    place = np.concatenate([k + _even(cloud, frame, ids, order[k : k + AT_ONCE + 2]) for k in parts])
    if len(place) < MIN_POINTS:
        return None
    place = place[np.argsort(frame[order[place]], kind="stable")]
    place = place[:: -(-len(place) * len(result.images.P) // MAX_PLACES)]
    ahead, behind = _steps(cloud, *(order[place + k] for k in (-1, 0, 1)))
    return _images_of(result, order[place], (ahead + behind) / 2)


def _even(cloud: Cloud, frame: Ints, ids: Ints, order: Ints) -> Ints:
    """Places in an order of rows by track and frame: of points that three cameras see, between two of their track in
    the frames beside them, of a velocity that hardly changes."""
    before, middle, after = order[:-2], order[1:-1], order[2:]
    near = (ids[before] == ids[after]) & (frame[after] - frame[before] == 2) & (ids[middle] >= 0)
    near &= (cloud.detection[middle] >= 0).sum(1) >= 3
    ahead, behind = _steps(cloud, before, middle, after)
    change, velocity = np.linalg.norm(ahead - behind, axis=1), (ahead + behind) / 2
    return 1 + np.flatnonzero(near & (change < MAX_VELOCITY_CHANGE * np.linalg.norm(velocity, axis=1)))


def _steps(cloud: Cloud, before: Ints, middle: Ints, after: Ints) -> tuple[Floats, Floats]:
    """(n, 3) mm from points to those after them, and from those before them."""
    return cloud.xyz[after] - cloud.xyz[middle], cloud.xyz[middle] - cloud.xyz[before]


def _images_of(result: TrackedImages, point: Ints, velocity: Floats) -> Moving:
    """The images of some points (N) that move at velocities (N, 3) mm a frame."""
    cloud, images = result.tracks.cloud, result.images
    xyz, detection = cloud.xyz[point], cloud.detection[point]
    expected = predict_images(images.P, KalmanStates(xyz.T, np.zeros((3, 3, len(point)))))
    seen = detection >= 0
    J = np.where(seen[..., None, None], expected.J.transpose(3, 0, 1, 2), 0.0)
    uv = expected.uv.transpose(2, 0, 1)
    off = np.where(seen[..., None], images.uv[detection] - uv, 0.0)
    flow = (J @ velocity[:, None, :, None])[..., 0]
    depth = xyz @ images.P[:, 2, :3].T + images.P[:, 2, 3]
    columns = np.where(seen[..., None, None], calibration_columns(xyz, depth, uv, images.size), 0.0)
    return Moving(J, off, flow, row_of_images(images, detection), cloud.frame[point], seen, columns)
