"""Which 2D points are one marker: one file a method."""

from .epipolar import EpipolarTriplets
from .kiss import KissTriplets
from .methods import MATCHERS, MatchMethod, check_cameras, match
from .nearest import NearestEpipolar

__all__ = ["MATCHERS", "EpipolarTriplets", "KissTriplets", "MatchMethod", "NearestEpipolar", "check_cameras", "match"]
