"""Which 2D points are one marker: one file a method."""

from ..geometry.ideal_pixels import check_cameras
from .epipolar_triplets import EpipolarTriplets
from .kiss_triplets import KissTriplets
from .methods import match
from .nearest_epipolar import NearestEpipolar
from .stage import MATCH

__all__ = ["MATCH", "EpipolarTriplets", "KissTriplets", "NearestEpipolar", "check_cameras", "match"]
