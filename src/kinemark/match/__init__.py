"""Which 2D points are one marker: one file a method."""

from .epipolar import EpipolarTriplets, match

__all__ = ["EpipolarTriplets", "match"]
