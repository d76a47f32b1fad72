"""Extrapolation, splines and assignment: mathematics of signals that knows nothing of markers."""

from .assignment import assign, assign_nearest, cheapest_first
from .extrapolation import LADDER, PAST, extrapolate, gain, weights
from .splines import Spline, smoothing_spline

__all__ = [
    "LADDER",
    "PAST",
    "Spline",
    "assign",
    "assign_nearest",
    "cheapest_first",
    "extrapolate",
    "gain",
    "smoothing_spline",
    "weights",
]
