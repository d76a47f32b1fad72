"""From detections straight to tracks, by whichever method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...data import Detections, Rig, Tracks
from ...match import check_cameras
from ..two_cameras.former_two_cameras import FormerTwoCameras, follow_former
from .simultaneous_method import DEFAULT, Simultaneous
from .tracker import follow_simultaneous

FOLLOWERS: dict[type, Callable[[Detections, Rig, Any], Tracks]] = {
    Simultaneous: follow_simultaneous,
    FormerTwoCameras: follow_former,
}
"""What does each method: called with detections, rig, and the method."""


def follow(detections: Detections, rig: Rig, *, method: Simultaneous | FormerTwoCameras = DEFAULT) -> Tracks:
    """Tracks of all markers, straight from what the cameras saw.

    Raises:
        KinemarkError: fewer than two cameras, or detections and rig name other cameras.
    """
    check_cameras(detections, rig)
    return FOLLOWERS[type(method)](detections, rig, method)
