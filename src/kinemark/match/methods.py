"""Matching by whichever method."""

from __future__ import annotations

from collections.abc import Callable

from ..data import Detections, Matches, Rig
from ..geometry.ideal_pixels import check_cameras
from .epipolar_triplets import EpipolarTriplets, match_epipolar
from .kiss_triplets import KissTriplets, match_kiss
from .nearest_epipolar import NearestEpipolar, match_nearest

MatchMethod = EpipolarTriplets | KissTriplets | NearestEpipolar

MATCHERS: dict[type, Callable[..., Matches]] = {
    EpipolarTriplets: match_epipolar,
    KissTriplets: match_kiss,
    NearestEpipolar: match_nearest,
}
"""What does each method: called with detections, rig, and method=…"""

DEFAULT = EpipolarTriplets()


def match(detections: Detections, rig: Rig, *, method: MatchMethod = DEFAULT) -> Matches:
    """Groups of detections that are one marker, frame by frame, without knowledge of other frames.

    Raises:
        KinemarkError: fewer than two cameras, or detections and rig name other cameras.
    """
    check_cameras(detections, rig)
    return MATCHERS[type(method)](detections, rig, method=method)
