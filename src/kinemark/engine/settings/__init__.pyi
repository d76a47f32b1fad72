"""`session.toml`: what a user says about a recording, checked, with errors that name the key and what it may be."""

from .calibration_table import CalibrationTable, DigitisedPoints, Distance, LFrame, LinearisationGrid, TargetRecording
from .listing import methods_figures, methods_table_markdown, methods_text
from .method_tables import SETTABLE, STAGES, calibrate_method, check_camera_names, method_of
from .read import ADVICE, read_settings
from .schema import session_schema
from .session_file import Cameras, MaskTable, ReportTable, Settings, TrialEntry, is_da

__all__ = [
    "ADVICE",
    "SETTABLE",
    "STAGES",
    "CalibrationTable",
    "Cameras",
    "DigitisedPoints",
    "Distance",
    "LFrame",
    "LinearisationGrid",
    "MaskTable",
    "ReportTable",
    "Settings",
    "TargetRecording",
    "TrialEntry",
    "calibrate_method",
    "check_camera_names",
    "is_da",
    "method_of",
    "methods_figures",
    "methods_table_markdown",
    "methods_text",
    "read_settings",
    "session_schema",
]
