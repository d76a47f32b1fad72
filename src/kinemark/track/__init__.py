"""Points of successive frames become tracks, and tracks become trajectories."""

from .editing import blend, within_volume, without_short
from .kiss_tracking import KissTracking
from .ladder import ExtrapolationLadder
from .methods import track
from .stage import TRACK, matches_itself
from .swamidas import DistanceOnly, Swamidas
from .to_trajectories import to_trajectories

__all__ = [
    "TRACK",
    "DistanceOnly",
    "ExtrapolationLadder",
    "KissTracking",
    "Swamidas",
    "blend",
    "matches_itself",
    "to_trajectories",
    "track",
    "within_volume",
    "without_short",
]
