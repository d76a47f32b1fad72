"""Tracking, and tracking again where the tracks show that cameras are not synchronous.

The tracks of a first run show delays of the cameras (`time_offsets`). Detections of cameras whose delay is significant
are moved to the times of the frames (`signal.common_time`), and all is tracked again; what is left of the delays then
shows once more, as a first run that was torn by them knows them less well.
"""

from __future__ import annotations

import numpy as np

from ...data import Detections, Rig, Tracks
from ...geometry.weighted_points import DEFAULT_ERRORS, ImageErrors
from ...signal.common_time import moved_in_time
from ..stage import DETECTIONS, TRACK
from .simultaneous_method import Simultaneous
from .time_offsets import time_offsets
from .tracker import TrackingResult, track_once

VOLUME_MARGIN = 100.0
"""mm outside the volume that a point may lie; chosen: markers of a subject within it may."""

ROUNDS = 3
"""Times at most that delays are learned; chosen: the third changes them by less than their standard error."""

MAX_DELAY = 1.0
"""Frames: beyond the next image nothing is known of where a marker was; by definition of `common_time`."""


@TRACK.method("simultaneous", Simultaneous, takes=DETECTIONS)
def simultaneous_tracks(detections: Detections, rig: Rig, *, method: Simultaneous) -> Tracks:
    """Tracks of all markers; called through `track_detections`."""
    return track_simultaneously(detections, rig, method).tracks


def track_simultaneously(
    detections: Detections,
    rig: Rig,
    method: Simultaneous,
    *,
    errors: ImageErrors = DEFAULT_ERRORS,
    volume_margin: float | None = VOLUME_MARGIN,
) -> TrackingResult:
    """Tracks of all markers, their points by the `errors` of images, and how they came about.

    Points farther than `volume_margin` mm outside the rig's volume, where it has one, are left out and listed; None
    keeps all.
    """
    result = track_once(detections, rig, method, errors, volume_margin)
    for _ in range(ROUNDS if method.learn_delays else 0):
        found = time_offsets(result)
        late = result.delay + np.where(found.significant, found.delay, 0.0) / detections.rate
        if not found.significant.any() or (np.abs(late) > MAX_DELAY / detections.rate).any():
            break
        error = np.where(found.significant, found.error / detections.rate, result.delay_error)
        moved = moved_in_time(detections, late)
        result = track_once(moved, rig, method, errors, volume_margin)._replace(delay=late, delay_error=error)
    return result
