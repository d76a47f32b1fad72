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
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...data.array_types import Bools, Floats, Ints
from .associate import predict_images
from .detection_index import Images
from .kalman_states import KalmanStates
from .tracker import TrackingResult

PARTS = 10
"""k of (3); chosen (see benchmarks/tracking.py)."""

MIN_SHIFT = 0.5
"""px; less is what a usual calibration leaves; chosen (see benchmarks/tracking.py)."""

MIN_STANDARD_ERRORS = 5.0
"""Standard errors of a delay; chosen (see benchmarks/tracking.py)."""

MAX_POINTS = 100_000
"""Points that are looked at, at most, at even steps in time; chosen: more take memory, and the delay is known to a
thousandth of a frame from a tenth of them."""

MIN_POINTS = 300
"""Points from which something can be said; chosen (see benchmarks/tracking.py)."""

OUTLIER = 4.0
"""Images farther off than this many times the median are not used; they belong to something else; chosen."""

MAX_VELOCITY_CHANGE = 0.5
"""Of a point's velocity: the most by which it may change in a frame; nothing else says when the point was where.
Chosen (see benchmarks/tracking.py)."""

FAST = 0.9
"""Quantile of the images' speed for `TimeOffsets.shift`: where people move, most markers hardly do; chosen."""


class TimeOffsets(NamedTuple):
    """How much later than the others C cameras take their images; NaN where not known.

    Attributes:
        delay, error: (C) frames, and its standard error; shift: (C) px by which that moves images that are fast.
        line, line_error, line_shift: (C) λ of (4), the same way; 0 where no camera has a rolling shutter.
    """

    delay: Floats
    error: Floats
    shift: Floats
    line: Floats
    line_error: Floats
    line_shift: Floats

    @property
    def significant(self) -> Bools:
        """(C) cameras whose delay is no chance, and moves their images by more than a usual calibration does."""
        return (np.abs(self.delay) > MIN_STANDARD_ERRORS * self.error) & (self.shift > MIN_SHIFT)

    @property
    def rolling(self) -> Bools:
        """(C) cameras whose rolling shutter is no chance, likewise."""
        return (np.abs(self.line) > MIN_STANDARD_ERRORS * self.line_error) & (self.line_shift > MIN_SHIFT)


class Moving(NamedTuple):
    """N points in motion: J (N, C, 2, 3) px/mm, off and flow (N, C, 2) px and px a frame, 0 where unseen; y (N, C) of
    (4); frame (N)."""

    J: Floats
    off: Floats
    flow: Floats
    y: Floats
    frame: Ints


def time_offsets(result: TrackingResult) -> TimeOffsets:
    """The delays of the cameras of a run, by (2)."""
    C = len(result.images.P)
    moving = _moving(result)
    if len(moving.frame) < MIN_POINTS:
        return TimeOffsets(*np.full((3, C), np.nan), *np.zeros((3, C)))
    speed = np.quantile(np.linalg.norm(moving.flow, axis=-1), FAST, axis=0)
    delay, error = _solved(moving, rolling=False)
    both, both_error = _solved(moving, rolling=True)
    shift, line_shift = np.abs(both[:C]) * speed, np.abs(both[C:]) * speed
    lines = TimeOffsets(both[:C], both_error[:C], shift, both[C:], both_error[C:], line_shift)
    return lines if lines.rolling.any() else TimeOffsets(delay, error, np.abs(delay) * speed, *np.zeros((3, C)))


def row_of_images(images: Images) -> Floats:
    """(D) y of (4) of all images."""
    return np.asarray(np.clip(2 * images.uv[:, 1] / images.size[images.camera, 1] - 1, -1.0, 1.0))


def _solved(moving: Moving, *, rolling: bool) -> tuple[Floats, Floats]:
    """(K) the solution (2) for delays, and λ where shutters may roll, and its standard errors by (3), in frames."""
    A, b = _sums(moving, rolling)
    C = moving.off.shape[1]
    without = np.array([_time_offsets(A.sum(0) - A[j], b.sum(0) - b[j], C) for j in range(PARTS)])
    return _time_offsets(A.sum(0), b.sum(0), C), without.std(0) * np.sqrt(PARTS - 1)


def _moving(result: TrackingResult) -> Moving:
    """The points of tracks that three cameras see, with the point before and after them."""
    cloud, ids = result.tracks.cloud, result.tracks.id
    order = np.lexsort([cloud.frame, ids])
    middle, before, after = order[1:-1], order[:-2], order[2:]
    near = (ids[before] == ids[after]) & (cloud.frame[after] - cloud.frame[before] == 2) & (ids[middle] >= 0)
    near &= (cloud.detection[middle] >= 0).sum(1) >= 3
    ahead, behind = cloud.xyz[after] - cloud.xyz[middle], cloud.xyz[middle] - cloud.xyz[before]
    velocity = (ahead + behind) / 2
    near &= np.linalg.norm(ahead - behind, axis=1) < MAX_VELOCITY_CHANGE * np.linalg.norm(velocity, axis=1)
    point, velocity = middle[near], velocity[near]
    in_time = np.argsort(cloud.frame[point], kind="stable")
    in_time = in_time[:: -(-len(in_time) // MAX_POINTS) or 1]
    point, velocity = point[in_time], velocity[in_time]
    expected = predict_images(result.images.P, KalmanStates(cloud.xyz[point].T, np.zeros((3, 3, len(point)))))
    detection = cloud.detection[point]
    seen = (detection >= 0)[..., None]
    J = np.where(seen[..., None], expected.J.transpose(3, 0, 1, 2), 0.0)
    off = np.where(seen, result.images.uv[detection] - expected.uv.transpose(2, 0, 1), 0.0)
    y = row_of_images(result.images)[detection]
    return Moving(J, off, (J @ velocity[:, None, :, None])[..., 0], y, cloud.frame[point])


def _sums(moving: Moving, rolling: bool) -> tuple[Floats, Floats]:
    """DᵀQ D (k, K, K) and DᵀQ off (k, K) of each part of the recording."""
    far = np.linalg.norm(moving.off, axis=-1).max(1)
    good = np.flatnonzero(far <= OUTLIER * np.median(far))
    first = np.searchsorted(moving.frame[good], np.linspace(0, moving.frame[-1] + 1, PARTS + 1))
    parts = [_sums_of(moving, good[begin:end], rolling) for begin, end in pairwise(first.tolist())]
    return np.array([A for A, _ in parts]), np.array([b for _, b in parts])


def _sums_of(moving: Moving, some: Ints, rolling: bool) -> tuple[Floats, Floats]:
    """The same of some points: a part at a time takes a tenth of the memory."""
    C = moving.off.shape[1]
    columns = moving.flow[some, ..., None] * np.eye(C)[:, None]
    if rolling:
        columns = np.concatenate([columns, columns * moving.y[some, ..., None, None]], -1)  # (4)
    J, off = moving.J[some].reshape(-1, 2 * C, 3), moving.off[some].reshape(-1, 2 * C)
    D = columns.reshape(-1, 2 * C, columns.shape[-1])
    QD = D - J @ np.linalg.solve(J.transpose(0, 2, 1) @ J, J.transpose(0, 2, 1) @ D)
    return np.einsum("nic,nid->cd", QD, D), np.einsum("nic,ni->c", QD, off)


def _time_offsets(A: Floats, b: Floats, C: int) -> Floats:
    """(K) frames by (2), the delays of C cameras less their median; NaN of cameras that saw nothing move."""
    seen = np.diag(A) > 0
    delay = np.full(len(b), np.nan)
    delay[seen] = np.linalg.pinv(A[np.ix_(seen, seen)], rcond=1e-6, hermitian=True) @ b[seen]
    if seen[:C].any():
        delay[:C] -= np.median(delay[:C][seen[:C]])
    return delay
