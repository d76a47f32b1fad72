"""Points of successive frames become tracks, and tracks become trajectories."""

from .ladder import ExtrapolationLadder, track
from .trajectories import to_trajectories

__all__ = ["ExtrapolationLadder", "to_trajectories", "track"]
