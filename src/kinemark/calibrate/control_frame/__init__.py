"""The calibration frame of hanging rods: which marker is which (`recognise`), by their spacings (`spacing`)."""

from .recognise import (
    calibrate_control_frame,
    control_frame_quality,
    identify_markers,
    recognise_control_frame,
    rows_of_points,
)

__all__ = [
    "calibrate_control_frame",
    "control_frame_quality",
    "identify_markers",
    "recognise_control_frame",
    "rows_of_points",
]
