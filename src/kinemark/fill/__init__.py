"""Missing samples: fillers, which of them to trust, and how far off they may be."""

from .motion import Gap, Motion, Prediction, find_gaps

__all__ = ["Gap", "Motion", "Prediction", "find_gaps"]
