"""Which 2D points are one marker: one file a method."""

from .epipolar import EpipolarTriplets
from .images import check_cameras
from .kiss import KissTriplets
from .methods import MATCHERS, MatchMethod, match
from .nearest import NearestEpipolar

__all__ = ["MATCHERS", "EpipolarTriplets", "KissTriplets", "MatchMethod", "NearestEpipolar", "check_cameras", "match"]
