"""Tracking, and tracking again where the tracks show that cameras are not synchronous.

The tracks of a first run show delays of the cameras, and rolling shutters (`time_offsets`). Detections of cameras of
which either is significant are moved to the times of the frames (`signal.common_time`), and all is tracked again; what
is left then shows once more, as a first run that was torn by delays knows them less well. Errors of a calibration can
look like a delay where all move one way; so a run that does not leave the images in better agreement counts for
nothing (1). What is then left of the times of a camera's images is their variance τ² (`timing_noise`): where that is
significant, all is tracked with variances (τ |flow|)² of the images along their motion (2), as images that are taken
at uneven times, and fast ones, agree less.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...data import Detections, Rig, Tracks
from ...data.array_types import Floats
from ...geometry.weighted_points import ImageErrors
from ...signal.common_time import image_flow, moved_in_time
from .detection_index import Images
from .simultaneous_method import Simultaneous
from .times.time_offsets import TimeOffsets, fast_residual, row_of_images, time_offsets
from .tracker import CameraTimes, TrackingResult, track_once

ROUNDS = 3
"""Times at most that delays are learned; chosen: the third changes them by less than their standard error."""

UNEVEN_ROUNDS = 2
"""Times that variances by (2) are learned; chosen: in simulation the second brought τ from 68 to 103 % of it."""

BETTER, SAME = 0.9, 0.99
"""Of the residual of fast points, the most that is left, and of the images in tracks, the least, by (1); chosen (see
benchmarks/tracking_scenes.py): where calibrations 1 px off looked like delays, 1.0 was left, or 0.93 of the images."""

MAX_DELAY = 1.0
"""Frames: beyond the next image nothing is known of where a marker was; by definition of `common_time`."""


def track_with_delays(
    detections: Detections, rig: Rig, method: Simultaneous, errors: ImageErrors, volume_margin: float | None
) -> TrackingResult:
    """Tracks, and tracks again with what they show of the cameras' times."""
    result, found, moved = track_once(detections, rig, method, errors, volume_margin), None, detections
    for _ in range(ROUNDS if method.learn_delays else 0):
        found = time_offsets(result)
        times = _with_what_is_left(result.times, found, 1 / detections.rate)
        if times is result.times:
            break
        late = _late(times, result.images)
        if np.abs(late).max(initial=0.0) > MAX_DELAY / detections.rate:
            break
        there = moved_in_time(detections, late)
        again = track_once(there, rig, method, errors, volume_margin)
        if not (_as_many_images(again, result) and fast_residual(again) < BETTER * fast_residual(result)):
            break
        result, found, moved = again._replace(times=times), None, there
    if not method.learn_delays:
        return result
    return _with_uneven_times(result, found or time_offsets(result), moved, rig, method, errors, volume_margin)


class SeenTracks(NamedTuple):
    """Tracks by whichever method, and the images that they are made of."""

    tracks: Tracks
    images: Images


def late_images(seen: SeenTracks) -> Floats | None:
    """(D) s by which the images were taken after their frames, as the tracks show; None where all were in time."""
    T, none = 1 / seen.tracks.cloud.rate, CameraTimes(*np.zeros((5, len(seen.images.P))))
    times = _with_what_is_left(none, time_offsets(seen), T)
    late = _late(times, seen.images) if times is not none else None
    return None if late is None or np.abs(late).max(initial=0.0) > MAX_DELAY * T else late


def _late(times: CameraTimes, images: Images) -> Floats:
    """(D) s by which images were taken after their frames."""
    return np.asarray(np.nan_to_num(times.delay[images.camera] + times.line[images.camera] * row_of_images(images)))


def _with_uneven_times(
    result: TrackingResult,
    found: TimeOffsets,
    detections: Detections,
    rig: Rig,
    method: Simultaneous,
    errors: ImageErrors,
    volume_margin: float | None,
) -> TrackingResult:
    """The result with variances by (2), where cameras have uneven times by what was found; a second time, as images
    that were too far off to be associated then are."""
    for _ in range(UNEVEN_ROUNDS):
        if not found.flickering.any():
            break
        unsteady = np.where(found.flickering, np.sqrt(np.maximum(found.unsteady, 0.0)), 0.0)
        timing = unsteady[detections.camera, None] * _whole_flow(detections)
        again = track_once(detections, rig, method, errors, volume_margin, timing)
        if not _as_many_images(again, result):
            break
        result = again._replace(times=result.times._replace(unsteady=unsteady / detections.rate))
        found = time_offsets(result)
    return result


def _whole_flow(detections: Detections) -> Floats:
    """(D, 2) px a frame, of images that go on from none the root mean square of their camera's, as they may be fast."""
    flow, camera = image_flow(detections), detections.camera
    for c in range(len(detections.cameras)):
        own = flow[camera == c]
        known = np.isfinite(own)
        flow[camera == c] = np.where(
            known, own, np.sqrt(np.mean(own[known[:, 0]] ** 2, axis=0)) if known.any() else 0.0
        )
    return flow


def _as_many_images(again: TrackingResult, before: TrackingResult) -> bool:
    """Whether no fewer images are in tracks, by (1)."""
    seen, seen_before = ((one.tracks.cloud.detection >= 0).sum() for one in (again, before))
    return bool(seen >= SAME * seen_before)


def _with_what_is_left(times: CameraTimes, found: TimeOffsets, T: float) -> CameraTimes:
    """The times with what was found of them in a run by these times, T s between frames; the same where nothing was."""
    late, rolling = found.significant, found.rolling
    if not (late | rolling).any():
        return times
    return CameraTimes(
        times.delay + T * np.where(late, found.delay, 0.0),
        np.where(late, T * found.error, times.delay_error),
        times.line + T * np.where(rolling, found.line, 0.0),
        np.where(rolling, T * found.line_error, times.line_error),
        times.unsteady,
    )
