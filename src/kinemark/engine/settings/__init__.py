"""`session.toml`: what a user says about a recording, checked, with errors that name the key and what it may be."""

from .calibration_table import CalibrationTable, DigitisedPoints, Distance, LFrame, LinearisationGrid, TargetRecording
from .listing import methods_text, parameters
from .method_tables import METHODS, METHODS_OF_WAY, calibrate_method, method_of
from .read import ADVICE, read_settings
from .session_file import Cameras, MaskTable, Settings, TrialEntry, is_da

__all__ = [
    "ADVICE",
    "METHODS",
    "METHODS_OF_WAY",
    "CalibrationTable",
    "Cameras",
    "DigitisedPoints",
    "Distance",
    "LFrame",
    "LinearisationGrid",
    "MaskTable",
    "Settings",
    "TargetRecording",
    "TrialEntry",
    "calibrate_method",
    "is_da",
    "method_of",
    "methods_text",
    "parameters",
    "read_settings",
]
