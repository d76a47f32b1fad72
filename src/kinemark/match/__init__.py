"""Which 2D points are one marker: one file a method."""

from ..geometry.ideal_pixels import check_cameras
from .epipolar_triplets import EpipolarTriplets
from .kiss_triplets import KissTriplets
from .methods import MATCHERS, MatchMethod, match
from .nearest_epipolar import NearestEpipolar

__all__ = ["MATCHERS", "EpipolarTriplets", "KissTriplets", "MatchMethod", "NearestEpipolar", "check_cameras", "match"]
