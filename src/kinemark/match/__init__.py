"""Which 2D points are one marker: one file a method."""

from ..geometry.ideal_pixels import check_cameras
from .epipolar_triplets import EpipolarTriplets
from .kiss_triplets import KissTriplets
from .methods import match
from .nearest_epipolar import NearestEpipolar
from .stage import MATCH
from .start_offsets import StartOffsets, start_offsets

__all__ = [
    "MATCH",
    "EpipolarTriplets",
    "KissTriplets",
    "NearestEpipolar",
    "StartOffsets",
    "check_cameras",
    "match",
    "start_offsets",
]
