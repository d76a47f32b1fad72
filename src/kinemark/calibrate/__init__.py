"""From markers at known places to calibrated cameras."""

from .control_frame import calibrate_control_frame, identify_markers, recognise_control_frame
from .control_points import ControlPoints, calibrate_control_points

__all__ = [
    "ControlPoints",
    "calibrate_control_frame",
    "calibrate_control_points",
    "identify_markers",
    "recognise_control_frame",
]
