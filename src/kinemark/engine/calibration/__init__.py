"""How a session's `[calibration]` becomes calibrated cameras, and how good they are."""

from .from_known_points import rig_of_dlt
from .results import EarlierCalibration, LastCalibration, calibrate, earlier_calibrations, last_calibration
from .task import Calibrated

__all__ = [
    "Calibrated",
    "EarlierCalibration",
    "LastCalibration",
    "calibrate",
    "earlier_calibrations",
    "last_calibration",
    "rig_of_dlt",
]
