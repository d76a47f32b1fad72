"""From detections straight to tracks, by whichever method."""

from __future__ import annotations

from ...data import Detections, Rig, Tracks
from ...data.method import Method
from ...geometry.ideal_pixels import check_cameras
from ...numerics.blas_threads import one_blas_thread
from ..stage import DETECTIONS, TRACK
from .simultaneous_method import DEFAULT


@one_blas_thread()
def track_detections(detections: Detections, rig: Rig, *, method: Method = DEFAULT) -> Tracks:
    """Tracks of all markers, straight from what the cameras saw.

    Raises:
        ValueError: the method is none of `TRACK`, or takes points (`track`).
        KinemarkError: fewer than two cameras, or detections and rig name other cameras.
    """
    check_cameras(detections, rig)
    return TRACK.function(method, takes=DETECTIONS)(detections, rig, method=method)
