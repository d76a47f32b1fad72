"""Matching by whichever method."""

from __future__ import annotations

from ..data import Detections, Matches, Rig
from ..data.method import Method
from ..geometry.ideal_pixels import check_cameras
from .stage import MATCH


def match(detections: Detections, rig: Rig, *, method: Method | None = None) -> Matches:
    """Groups of detections that are one marker, frame by frame, without knowledge of other frames.

    Args:
        detections: of all cameras.
        rig: the cameras, in the same order.
        method: one of `MATCH`; `EpipolarTriplets()` where None.

    Raises:
        ValueError: the method is none of `MATCH`.
        KinemarkError: fewer than two cameras, or detections and rig name other cameras.
    """
    method = method or MATCH.make()
    check_cameras(detections, rig)
    return MATCH.function(method)(detections, rig, method=method)
