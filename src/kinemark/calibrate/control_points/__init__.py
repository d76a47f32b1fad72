"""Cameras from markers at surveyed places, and whether that can be trusted.

`camera` fits one camera and `fit` all of them; `checks` refuses what determines none. `left_out` asks how well points
that took no part are seen, `mistaken` which images were taken for another's, `survey` which points are not where they
were said to be; `judgement` weighs it all.
"""

from .fit import ControlFit, calibrate_control_points, control_point_quality
from .fit_camera import CameraMethod, ControlPoints, Dlt, fit_camera, free_parameters
from .judgement import Judgement, judge_control_points

__all__ = [
    "CameraMethod",
    "ControlFit",
    "ControlPoints",
    "Dlt",
    "Judgement",
    "calibrate_control_points",
    "control_point_quality",
    "fit_camera",
    "free_parameters",
    "judge_control_points",
]
