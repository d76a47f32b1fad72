"""Extrapolation and assignment: mathematics of signals that knows nothing of markers."""

from .assignment import assign
from .extrapolation import LADDER, PAST, extrapolate, gain, weights

__all__ = ["LADDER", "PAST", "assign", "extrapolate", "gain", "weights"]
