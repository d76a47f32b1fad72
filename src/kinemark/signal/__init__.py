"""Extrapolation and assignment: mathematics of signals that knows nothing of markers."""

from .assignment import assign, assign_nearest, cheapest_first
from .extrapolation import LADDER, PAST, extrapolate, gain, weights

__all__ = ["LADDER", "PAST", "assign", "assign_nearest", "cheapest_first", "extrapolate", "gain", "weights"]
