"""How a session's `[calibration]` becomes calibrated cameras, and how good they are."""

from .calibrated import Calibrated
from .from_known_points import rig_of_dlt
from .results import calibrate

__all__ = ["Calibrated", "calibrate", "rig_of_dlt"]
