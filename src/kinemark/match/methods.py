"""Matching by whichever method."""

from __future__ import annotations

from collections.abc import Callable

from ..data import Detections, KinemarkError, Matches, Rig
from .epipolar import EpipolarTriplets, match_epipolar
from .kiss import KissTriplets, match_kiss
from .nearest import NearestEpipolar, match_nearest

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


def check_cameras(detections: Detections, rig: Rig) -> None:
    """Two cameras or more, the same in both.

    Raises:
        KinemarkError: they are not.
    """
    if len(rig) < 2:
        raise KinemarkError(f"{len(rig)} camera is calibrated, and a point in space needs two. Add a camera.")
    if detections.cameras != rig.names:
        raise KinemarkError(
            f"The detections are of cameras {list(detections.cameras)} and the calibration of {list(rig.names)}. "
            "Name the same cameras in the same order in both."
        )
