"""How a session's `[calibration]` becomes calibrated cameras, and how good they are."""

from .calibrated import Calibrated
from .from_known_points import rig_of_dlt
from .results import EarlierCalibration, LastCalibration, calibrate, earlier_calibrations, last_calibration

__all__ = [
    "Calibrated",
    "EarlierCalibration",
    "LastCalibration",
    "calibrate",
    "earlier_calibrations",
    "last_calibration",
    "rig_of_dlt",
]
