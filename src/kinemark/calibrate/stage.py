"""The methods of calibration; which of them may be chosen follows from the way that a session is calibrated.

Those for control points are called for one camera, as `fit_camera` says; `calibrate_wand` and `calibrate_points` say
how the others are.
"""

from ..data.method import Stage

CALIBRATE = Stage("calibrate", "kinemark.calibrate", default="control_points", meaning="cameras from what they saw")
