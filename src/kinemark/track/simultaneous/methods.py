"""From detections straight to tracks, by whichever method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...data import Detections, Rig, Tracks
from ...geometry.ideal_pixels import check_cameras
from ..two_cameras.former_two_cameras import FormerTwoCameras, track_two_cameras
from .simultaneous_method import DEFAULT, Simultaneous
from .tracker import simultaneous_tracks

DETECTION_TRACKERS: dict[type, Callable[[Detections, Rig, Any], Tracks]] = {
    Simultaneous: simultaneous_tracks,
    FormerTwoCameras: track_two_cameras,
}
"""What does each method: called with detections, rig, and the method."""


def track_detections(detections: Detections, rig: Rig, *, method: Simultaneous | FormerTwoCameras = DEFAULT) -> Tracks:
    """Tracks of all markers, straight from what the cameras saw.

    Raises:
        KinemarkError: fewer than two cameras, or detections and rig name other cameras.
    """
    check_cameras(detections, rig)
    return DETECTION_TRACKERS[type(method)](detections, rig, method)
