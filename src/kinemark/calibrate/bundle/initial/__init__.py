"""Cameras from nothing but their image sizes: a first guess from which a bundle adjustment converges.

start       the guess itself: a pair of cameras, and growth from it
optics      what is assumed of a camera; lines straightened
pairs       which cameras see the same points, and their epipolar geometry
seeds       focal lengths and pose of a pair
resection   a further camera from points that are known
"""

from .growth import TargetViews, start
from .unknown_optics import UnknownOptics, unknown_optics

__all__ = ["TargetViews", "UnknownOptics", "start", "unknown_optics"]
