"""`session.toml`: what a user says about a recording, checked, with errors that name the key and what it may be."""

from .calibration import Calibration, DigitisedPoints, Distance, LFrame, LinearisationGrid, Seen
from .listing import methods_text, parameters
from .methods import METHODS, METHODS_OF_WAY, calibrate_method, method_of
from .reading import ADVICE, read_settings
from .session import Cameras, Masks, Settings, TrialEntry, is_da

__all__ = [
    "ADVICE",
    "METHODS",
    "METHODS_OF_WAY",
    "Calibration",
    "Cameras",
    "DigitisedPoints",
    "Distance",
    "LFrame",
    "LinearisationGrid",
    "Masks",
    "Seen",
    "Settings",
    "TrialEntry",
    "calibrate_method",
    "is_da",
    "method_of",
    "methods_text",
    "parameters",
    "read_settings",
]
